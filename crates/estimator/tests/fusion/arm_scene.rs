//! An arm of two joints and three tags a link, moved smoothly, its corners projected exactly with Gaussian noise.

use nalgebra::{Matrix2, Point2, UnitQuaternion, Vector2, Vector3};
use sextant_geometry::{Pose, tag_corners_in_tag};
use sextant_site_model::{
    Articulation, ImageObservation, Joint, JointId, JointKind, LinkId, ObjectId, ObjectModel,
    ObjectTag, Rig, TagCorners,
};

use crate::scene::{PERIOD_NS, Random, START_NS, camera_id, tag_id};

const SIGMA_PX: f64 = 0.1;

fn link(name: &str) -> LinkId {
    LinkId::new(name).unwrap()
}

fn joint(id: &str, parent: &str, child: &str, limits: Option<[f64; 2]>) -> Joint {
    Joint {
        id: JointId::new(id).unwrap(),
        kind: JointKind::Revolute,
        parent: link(parent),
        child: link(child),
        axis: Vector3::z(),
        parent_from_joint: Pose::identity(),
        limits,
        max_speed: None,
    }
}

/// Base, upper arm (shoulder turns about z) and forearm (elbow turns about y), three tags a link.
pub fn arm() -> ObjectModel {
    let shoulder = Joint {
        parent_from_joint: Pose::translation(0.0, 0.0, 0.05),
        ..joint("shoulder", "base", "upper", Some([-2.0, 2.0]))
    };
    let elbow = Joint {
        axis: Vector3::y(),
        parent_from_joint: Pose::translation(0.15, 0.0, 0.04),
        ..joint("elbow", "upper", "fore", Some([-1.2, 1.2]))
    };
    let tree = Articulation::new(
        vec![link("base"), link("upper"), link("fore")],
        vec![shoulder, elbow],
    )
    .unwrap();
    let mut tags = Vec::new();
    for (index, name) in ["base", "upper", "fore"].into_iter().enumerate() {
        // On the top and on two sides of a beam along x, 4 cm wide.
        for (side, turn) in [0.0, 1.2, -1.2].into_iter().enumerate() {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), turn);
            let place = turn * Vector3::new(0.0, 0.0, 0.02) + Vector3::new(0.07, 0.0, 0.0);
            let tag = tag_id(10 + 3 * index as u32 + side as u32);
            let link_from_tag = Pose::from_parts(place.into(), turn);
            tags.push(ObjectTag {
                link: Some(link(name)),
                ..ObjectTag::new(tag, 0.03, Some(link_from_tag))
            });
        }
    }
    ObjectModel::articulated(ObjectId::new("arm").unwrap(), tree, tags)
        .unwrap()
        .exact()
}

/// Base pose and joint values, `seconds` after the start.
pub fn motion(seconds: f64) -> (Pose, [f64; 2]) {
    let base = Pose::new(
        Vector3::new(
            0.05 * (0.9 * seconds).sin() - 0.08,
            0.04 * (1.1 * seconds).cos(),
            0.0,
        ),
        Vector3::new(0.0, 0.0, 0.4 * (0.7 * seconds).sin()),
    );
    let values = [
        1.2 * (1.3 * seconds).sin(),
        0.9 * (1.7 * seconds + 1.0).sin(),
    ];
    (base, values)
}

pub fn at(time_ns: u64) -> (Pose, [f64; 2]) {
    motion((time_ns as i128 - START_NS as i128) as f64 * 1e-9)
}

/// World from each link.
pub fn links(base: &Pose, values: [f64; 2]) -> [Pose; 3] {
    let arm = arm();
    let joints = arm.articulation().unwrap().joints().to_vec();
    let upper = base * joints[0].parent_from_child(values[0]);
    [*base, upper, upper * joints[1].parent_from_child(values[1])]
}

/// The tags that a camera sees of some links.
pub fn image(
    rig: &Rig,
    camera: usize,
    time_ns: u64,
    seen: &[usize],
    base: &Pose,
    values: [f64; 2],
    random: &mut Random,
) -> ImageObservation {
    let (camera_model, arm) = (&rig.cameras()[camera], arm());
    let camera_from_world = camera_model.world_from_camera.unwrap().inverse();
    let poses = links(base, values);
    let mut tags = Vec::new();
    for tag in arm.tags() {
        let link = arm.link_of(tag).unwrap();
        let camera_from_tag = camera_from_world * poses[link] * tag.object_from_tag.unwrap();
        let towards = camera_from_tag.translation.vector.normalize();
        let facing = -(camera_from_tag.rotation * Vector3::z()).dot(&towards);
        if !seen.contains(&link) || facing < 0.25 {
            continue;
        }
        let project = |corner| {
            camera_model
                .lens
                .project(&(camera_from_tag * corner))
                .unwrap()
        };
        let corners: [Point2<f64>; 4] = tag_corners_in_tag(tag.size_m).map(project);
        let inside = |c: &Point2<f64>| (0.0..640.0).contains(&c.x) && (0.0..480.0).contains(&c.y);
        if corners.iter().all(inside) {
            let mut noisy = |c| c + Vector2::new(random.gauss(), random.gauss()) * SIGMA_PX;
            tags.push(TagCorners {
                tag: tag.tag,
                corners: corners.map(&mut noisy),
                corner_covariance: [Matrix2::identity() * SIGMA_PX.powi(2); 4],
                corner_cross_covariance: [Matrix2::zeros(); 6],
            });
        }
    }
    ImageObservation {
        camera: camera_id(camera),
        capture_ns: time_ns,
        clock_error_ns: 0,
        exposure_ns: 0,
        resolution: None,
        tags,
    }
}

/// Images of all cameras in turn; `seen` says which links show at a time in seconds.
pub fn run(
    rig: &Rig,
    seconds: f64,
    seen: fn(f64) -> &'static [usize],
    seed: u64,
) -> Vec<ImageObservation> {
    let (cameras, mut random) = (rig.cameras().len() as u64, Random(seed));
    let images = (0..(seconds * 1e9) as u64 * cameras / PERIOD_NS).map(|index| {
        let time_ns = START_NS + index * PERIOD_NS / cameras;
        let links = seen((time_ns - START_NS) as f64 * 1e-9);
        let camera = (index % cameras) as usize;
        let (base, values) = at(time_ns);
        image(rig, camera, time_ns, links, &base, values, &mut random)
    });
    images.collect()
}

/// Base, upper arm, forearm.
pub const ALL: &[usize] = &[0, 1, 2];
