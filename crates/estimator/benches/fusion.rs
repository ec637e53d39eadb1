//! What fusion costs: one image of a tracked object, a late image, a large site. `cargo bench -p sextant-estimator`.
//!
//! Prints microseconds of one core; the clock is read here, never in the crate. `-- NAME..` runs some cases only
//! (1-tag, 6-tags, lasting, arm, body, late, clock, ahead, free-running, simultaneous). Instructions of a case, which
//! no busy machine changes: `cost.sh` beside this.

#![allow(clippy::expect_used, reason = "a bench without its scene is none")]

use std::time::Instant;

use nalgebra::{Matrix2, Point2, Rotation3, UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::lens::Intrinsics;
use sextant_geometry::{Lens, Pose, tag_corners_in_tag};
use sextant_site_model::{
    Articulation, Camera, CameraId, ImageObservation, Joint, JointId, JointKind, LensSigma, LinkId,
    ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig, TagCorners, TagId,
};
use sextant_tag_families::Family;

const START_NS: u64 = 1_700_000_000_000_000_000;
const PERIOD_NS: u64 = 33_333_333;
/// Age of an image on arrival; late ones come when they come.
const LATENCY_NS: u64 = 30_000_000;

fn rig(cameras: usize) -> Rig {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = |index: usize| {
        let angle = std::f64::consts::TAU * index as f64 / cameras as f64;
        let place = Vector3::new(0.5 * angle.cos(), 0.5 * angle.sin(), 1.2);
        let forward = -place.normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let rotation = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
        Camera::new(
            CameraId::new(&format!("cam{index}")).expect("a name"),
            [640, 480],
            Lens::pinhole(intrinsics).expect("a lens"),
            Some(Pose::from_parts(
                place.into(),
                UnitQuaternion::from_rotation_matrix(&rotation),
            )),
        )
    };
    Rig::new((0..cameras).map(camera).collect())
        .expect("a rig")
        .exact()
}

/// A plate whose tags lie side by side, all facing up.
fn plate(index: usize, tags: usize) -> ObjectModel {
    let tag = |number: usize| {
        ObjectTag::new(
            TagId {
                family: Family::Tag36h11,
                id: (index * tags + number) as u32,
            },
            0.03,
            Some(Pose::translation(
                0.04 * (number % 3) as f64,
                0.04 * (number / 3) as f64,
                0.0,
            )),
        )
    };
    ObjectModel::new(
        ObjectId::new(&format!("plate{index}")).expect("a name"),
        (0..tags).map(tag).collect(),
    )
    .expect("an object")
    .exact()
}

fn pose(index: usize, time_ns: u64) -> Pose {
    let seconds = (time_ns - START_NS) as f64 * 1e-9;
    let angle = index as f64 * 0.63;
    let place = Vector3::new(
        0.25 * angle.cos() + 0.1 * seconds.sin(),
        0.25 * angle.sin(),
        0.05 * (2.0 * seconds).cos(),
    );
    Pose::from_parts(
        place.into(),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.2 * seconds.sin(), 0.1, 0.5 * seconds)),
    )
}

/// A cheap deterministic noise of about 0.05 px.
fn noise(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 33) as f64 / (1u64 << 31) as f64 - 0.5) * 0.17
}

fn image(
    rig: &Rig,
    camera: usize,
    objects: &[ObjectModel],
    time_ns: u64,
    state: &mut u64,
) -> ImageObservation {
    let camera = &rig.cameras()[camera];
    let camera_from_world = camera.world_from_camera.expect("a pose").inverse();
    let mut tags = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        for tag in object.tags() {
            let camera_from_tag =
                camera_from_world * pose(index, time_ns) * tag.object_from_tag.expect("a place");
            let corners = tag_corners_in_tag(tag.size_m)
                .map(|corner| camera.lens.project(&(camera_from_tag * corner)));
            if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                let corners =
                    [a, b, c, d].map(|p| Point2::new(p.x + noise(state), p.y + noise(state)));
                tags.push(TagCorners {
                    tag: tag.tag,
                    corners,
                    corner_covariance: [Matrix2::identity() * 0.0025; 4],
                    corner_cross_covariance: [Matrix2::zeros(); 6],
                });
            }
        }
    }
    ImageObservation {
        camera: camera.id.clone(),
        capture_ns: time_ns,
        clock_error_ns: 0,
        exposure_ns: 0,
        resolution: None,
        tags,
    }
}

/// A scene and the microseconds of each of its images.
struct Case {
    name: &'static str,
    title: &'static str,
    run: fn() -> Vec<f64>,
    /// Images at the beginning that do not count.
    warm_up: usize,
    /// Images a second.
    rate: Option<f64>,
}

/// Runs of a case: the same images each time, of which the shortest time counts. What a busy machine adds is no cost of
/// fusion.
const RUNS: usize = 5;

impl Case {
    fn report(&self, runs: usize) {
        let mut micros = (self.run)();
        for _ in 1..runs {
            let again = (self.run)();
            micros
                .iter_mut()
                .zip(again)
                .for_each(|(one, other)| *one = one.min(other));
        }
        let mut micros = micros.split_off(self.warm_up);
        let mean = micros.iter().sum::<f64>() / micros.len() as f64;
        micros.sort_by(f64::total_cmp);
        let at = |share: f64| micros[((micros.len() - 1) as f64 * share) as usize];
        let core = self
            .rate
            .map(|rate| format!("   {:.0} % of a core", mean * rate * 1e-4));
        println!(
            "{:<14} {:<50} median {:8.1} us   p99 {:8.1} us   max {:8.1} us{}",
            self.name,
            self.title,
            at(0.5),
            at(0.99),
            at(1.0),
            core.unwrap_or_default()
        );
    }
}

/// As [`timed`]: a name of its own, so that its instructions can be counted apart.
#[inline(never)]
fn timed_late(fusion: &mut Fusion, image: ImageObservation) -> f64 {
    timed(fusion, image.capture_ns, image)
}

/// Microseconds that an image takes that comes `LATENCY_NS` after it was taken, whatever it says of that.
#[inline(never)]
fn timed(fusion: &mut Fusion, taken_ns: u64, image: ImageObservation) -> f64 {
    let start = Instant::now();
    fusion.handle(taken_ns + LATENCY_NS, Input::Image(image));
    while fusion.poll_output().is_some() {}
    start.elapsed().as_secs_f64() * 1e6
}

fn one_image(tags: usize) -> Vec<f64> {
    images_of(&rig(4), plate(0, tags))
}

/// With configured deviations of cameras, lenses and tags.
fn one_image_of_a_known_site() -> Vec<f64> {
    const PLACED: PoseSigma = PoseSigma {
        position_m: 0.001,
        orientation_rad: 0.002,
    };
    const CAST: LensSigma = LensSigma {
        focal_px: 0.5,
        distortion_px: 0.2,
    };
    let (mut cameras, object) = (rig(4).cameras().to_vec(), plate(0, 6));
    for camera in &mut cameras {
        camera.pose_prior = Prior::Sigma(PLACED);
        camera.lens_prior = Prior::Sigma(CAST);
    }
    let mut tags = object.tags().to_vec();
    for tag in &mut tags {
        tag.pose_prior = Prior::Sigma(PLACED);
    }
    let rig = Rig::new(cameras).expect("a rig");
    let object = ObjectModel::new(object.id().clone(), tags);
    images_of(&rig, object.expect("an object"))
}

fn images_of(rig: &Rig, object: ObjectModel) -> Vec<f64> {
    let (objects, mut state) = (vec![object], 1);
    let mut fusion =
        Fusion::new(rig.clone(), objects.clone(), FusionOptions::default()).expect("a machine");
    let mut micros = Vec::new();
    for number in 0..4000u64 {
        let time_ns = START_NS + number * PERIOD_NS / 4;
        let image = image(rig, (number % 4) as usize, &objects, time_ns, &mut state);
        micros.push(timed(&mut fusion, time_ns, image));
    }
    micros
}

/// The plate's six tags on a base, three more on either of two links that hinges join to it.
fn arm() -> ObjectModel {
    let link = |name: &str| LinkId::new(name).expect("a name");
    let joint = |id: &str, parent: &str, child: &str, x: f64| Joint {
        id: JointId::new(id).expect("a name"),
        kind: JointKind::Revolute,
        parent: link(parent),
        child: link(child),
        axis: Vector3::z(),
        parent_from_joint: Pose::translation(x, 0.0, 0.0),
        limits: Some([-1.0, 1.0]),
        max_speed: None,
    };
    let joints = vec![
        joint("a", "base", "upper", 0.12),
        joint("b", "upper", "fore", 0.12),
    ];
    let links = ["base", "upper", "fore"];
    let tree = Articulation::new(links.map(link).to_vec(), joints).expect("a tree");
    let tags = plate(0, 9).tags().to_vec();
    let on_links = tags.into_iter().enumerate().map(|(index, mut tag)| {
        tag.object_from_tag = Some(Pose::translation(0.0, 0.04 * (index % 3) as f64, 0.0));
        tag.link = Some(link(links[index / 3]));
        tag
    });
    let id = ObjectId::new("arm").expect("a name");
    ObjectModel::articulated(id, tree, on_links.collect())
        .expect("an arm")
        .exact()
}

/// The arm as one body, its joints at zero: what the cameras see.
fn stiff(arm: &ObjectModel) -> ObjectModel {
    let mut tags = arm.tags().to_vec();
    for tag in &mut tags {
        let link = arm.link_of(tag).unwrap_or(0) as f64;
        let from_link = Pose::translation(0.12 * link, 0.0, 0.0);
        tag.object_from_tag = tag.object_from_tag.map(|pose| from_link * pose);
        tag.link = None;
    }
    ObjectModel::new(arm.id().clone(), tags)
        .expect("an object")
        .exact()
}

/// Of the arm, which is followed as `object`.
fn one_image_of(object: ObjectModel) -> Vec<f64> {
    let (rig, body, mut state) = (rig(4), [stiff(&arm())], 1);
    let mut fusion =
        Fusion::new(rig.clone(), vec![object], FusionOptions::default()).expect("a machine");
    let mut micros = Vec::new();
    for number in 0..4000u64 {
        let time_ns = START_NS + number * PERIOD_NS / 4;
        let image = image(&rig, (number % 4) as usize, &body, time_ns, &mut state);
        micros.push(timed(&mut fusion, time_ns, image));
    }
    micros
}

fn late_image() -> Vec<f64> {
    let (rig, objects, mut state) = (rig(4), vec![plate(0, 6)], 1);
    let mut fusion =
        Fusion::new(rig.clone(), objects.clone(), FusionOptions::default()).expect("a machine");
    let mut micros = Vec::new();
    for number in 0..4000u64 {
        let time_ns = START_NS + number * PERIOD_NS / 4;
        timed(
            &mut fusion,
            time_ns,
            image(&rig, (number % 3) as usize, &objects, time_ns, &mut state),
        );
        if number > 100 && number % 10 == 0 {
            let late_ns = time_ns - 50 * PERIOD_NS / 4 + 1;
            let late = image(&rig, 3, &objects, late_ns, &mut state);
            // Whoever looks next pays for what came late.
            let next = image(&rig, 3, &objects, time_ns + 1, &mut state);
            micros.push(timed_late(&mut fusion, late) + timed_late(&mut fusion, next));
        }
    }
    micros
}

/// When the cameras of a site take their images.
#[derive(Clone, Copy)]
enum Phase {
    /// One after the other.
    Free,
    /// All at once.
    Same,
}

fn large_site(phase: Phase) -> Vec<f64> {
    let (rig, mut state) = (rig(64), 1);
    let objects: Vec<_> = (0..10).map(|index| plate(index, 2)).collect();
    let mut fusion =
        Fusion::new(rig.clone(), objects.clone(), FusionOptions::default()).expect("a machine");
    let mut micros = Vec::new();
    let rounds = 60;
    for round in 0..rounds {
        for camera in 0..64 {
            let after_ns = match phase {
                Phase::Free => camera * PERIOD_NS / 64,
                Phase::Same => 0,
            };
            let time_ns = START_NS + round * PERIOD_NS + after_ns;
            let image = image(&rig, camera as usize, &objects, time_ns, &mut state);
            micros.push(timed(&mut fusion, time_ns, image));
        }
    }
    micros
}

/// A camera whose stamps are ahead: until that is found out, what single cameras see is compared; by less than the
/// window, and all images of the others would be late.
fn open_clock_question(ahead_ns: i64) -> Vec<f64> {
    let (rig, mut state) = (rig(6), 1);
    let objects: Vec<_> = (0..8).map(|index| plate(index, 6)).collect();
    let mut fusion =
        Fusion::new(rig.clone(), objects.clone(), FusionOptions::default()).expect("a machine");
    let mut micros = Vec::new();
    for number in 0..6 * 150u64 {
        let (camera, time_ns) = (number % 6, START_NS + number * PERIOD_NS / 6);
        let mut image = image(&rig, camera as usize, &objects, time_ns, &mut state);
        image.clock_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
        let off_ns = if camera == 1 { ahead_ns } else { 0 };
        image.capture_ns = image.capture_ns.saturating_add_signed(off_ns);
        micros.push(timed(&mut fusion, time_ns, image));
    }
    assert!(
        !fusion.clock_offsets().is_empty(),
        "the clock was not found out"
    );
    micros
}

fn main() {
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    let once = chosen.iter().any(|one| one == "--once");
    let named: Vec<&String> = chosen.iter().filter(|one| !one.starts_with("--")).collect();
    for case in CASES {
        if named.is_empty() || named.iter().any(|one| *one == case.name) {
            case.report(if once { 1 } else { RUNS });
        }
    }
}

const CASES: &[Case] = &[
    Case {
        name: "1-tag",
        title: "one image, one object, 1 tag",
        run: || one_image(1),
        warm_up: 100,
        rate: None,
    },
    Case {
        name: "6-tags",
        title: "one image, one object, 6 tags",
        run: || one_image(6),
        warm_up: 100,
        rate: None,
    },
    Case {
        name: "lasting",
        title: "the same, cameras, lenses and tags as well known",
        run: one_image_of_a_known_site,
        warm_up: 100,
        rate: None,
    },
    Case {
        name: "arm",
        title: "one image, an arm of 3 links, 9 tags",
        run: || one_image_of(arm()),
        warm_up: 100,
        rate: None,
    },
    Case {
        name: "body",
        title: "one image, a body, 9 tags",
        run: || one_image_of(stiff(&arm())),
        warm_up: 100,
        rate: None,
    },
    Case {
        name: "late",
        title: "an image late by 50 images and the next, 6 tags",
        run: late_image,
        warm_up: 0,
        rate: None,
    },
    Case {
        name: "clock",
        title: "6 cameras, 8 objects of 6 tags, a clock far off",
        run: || open_clock_question(3_000_000_000),
        warm_up: 60,
        rate: None,
    },
    Case {
        name: "ahead",
        title: "the same, by 0.3 s",
        run: || open_clock_question(300_000_000),
        warm_up: 0,
        rate: Some(6.0 * 30.0),
    },
    Case {
        name: "behind",
        title: "the same, behind by 0.3 s",
        run: || open_clock_question(-300_000_000),
        warm_up: 0,
        rate: Some(6.0 * 30.0),
    },
    Case {
        name: "free-running",
        title: "64 cameras, 10 objects, 20 tags, free-running",
        run: || large_site(Phase::Free),
        warm_up: 640,
        rate: Some(64.0 * 30.0),
    },
    Case {
        name: "simultaneous",
        title: "64 cameras, 10 objects, 20 tags, simultaneous",
        run: || large_site(Phase::Same),
        warm_up: 640,
        rate: Some(64.0 * 30.0),
    },
];
