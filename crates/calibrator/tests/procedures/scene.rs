//! Cameras, objects and paths of which everything is known, and the corners that images of them would show.

use nalgebra::{Isometry3, Matrix2, Point2, Point3, Vector2, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
pub use sextant_simulator::Random;
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectModel, ObjectTag, Rig, TagCorners, TagId,
};
use sextant_tag_families::Family;
use std::f64::consts::PI;

pub fn tag(id: u32) -> TagId {
    TagId {
        family: Family::Tag36h11,
        id,
    }
}

pub fn camera_id(at: usize) -> CameraId {
    CameraId::new(["a", "b", "c", "d"][at]).unwrap()
}

/// A pose that looks from one point to another, z up in the image.
pub fn looking(from: [f64; 3], to: [f64; 3]) -> Pose {
    let (from, to) = (Point3::from(from), Point3::from(to));
    Isometry3::face_towards(&from, &to, &-Vector3::z())
}

/// A pose that looks straight down.
pub fn above(x: f64, height: f64) -> Pose {
    Isometry3::new(Vector3::new(x, 0.0, height), Vector3::new(PI, 0.0, 0.0))
}

/// Four cameras around a room of four metres, each with a lens of its own.
pub fn rig() -> Rig {
    let camera = |at: usize| {
        let angle = PI * (0.15 + 0.5 * at as f64);
        let from = [1.9 * angle.cos(), 1.9 * angle.sin(), 1.3 + 0.2 * at as f64];
        let intrinsics = Intrinsics {
            fx: 600.0 + 6.0 * at as f64,
            fy: 601.0 + 6.0 * at as f64,
            cx: 318.0 + 5.0 * at as f64,
            cy: 242.0 - 6.0 * at as f64,
        };
        Camera::new(
            camera_id(at),
            [640, 480],
            Lens::pinhole(intrinsics).unwrap(),
            Some(looking(from, [0.0, 0.0, 0.6])),
        )
    };
    Rig::new((0..4).map(camera).collect()).unwrap()
}

/// The rig as a person has it before: lenses only.
pub fn blind(rig: &Rig) -> Rig {
    let cameras = rig.cameras().iter().map(|camera| Camera {
        world_from_camera: None,
        ..camera.clone()
    });
    Rig::new(cameras.collect()).unwrap()
}

/// The same rig with focal lengths that are off by a factor of each camera.
pub fn with_focal_lengths_off(rig: &Rig, mut factor: impl FnMut() -> f64) -> Rig {
    let cameras = rig.cameras().iter().map(|camera| {
        let (mut numbers, factor) = (camera.lens.parameters(), factor());
        numbers[..2].iter_mut().for_each(|focal| *focal *= factor);
        Camera {
            lens: camera.lens.with_parameters(&numbers).unwrap(),
            ..camera.clone()
        }
    });
    Rig::new(cameras.collect()).unwrap()
}

/// A board with twelve tags on either side.
pub fn board() -> ObjectModel {
    let place = |id: u32| {
        let (side, at) = (id / 12, id % 12);
        let x = 0.105 * (f64::from(at % 4) - 1.5);
        let y = 0.105 * (f64::from(at / 4) - 1.0);
        let turn = if side == 0 { 0.0 } else { PI };
        let z = if side == 0 { 0.006 } else { -0.006 };
        Isometry3::new(Vector3::new(x, y, z), Vector3::new(0.0, turn, 0.0))
    };
    object("board", (0..24).map(|id| (id, 0.08, place(id))))
}

/// Seven tags around an irregular body of ten centimetres.
pub fn thing() -> ObjectModel {
    body("thing", 0.05, 0.038)
}

/// The same, large enough to be carried through a room.
pub fn wand() -> ObjectModel {
    body("wand", 0.14, 0.11)
}

fn body(name: &str, radius: f64, size_m: f64) -> ObjectModel {
    let place = |id: u32| {
        let around = f64::from(id) * PI / 3.0;
        let outwards = if id == 6 {
            Isometry3::translation(0.0, 0.0, radius)
        } else {
            let turn = Isometry3::new(Vector3::zeros(), Vector3::new(0.0, 0.0, around));
            let lean = Isometry3::new(
                Vector3::zeros(),
                Vector3::new(0.0, 1.2 + 0.05 * f64::from(id), 0.0),
            );
            turn * lean * Isometry3::translation(0.0, 0.0, radius)
        };
        outwards
            * Isometry3::new(
                Vector3::zeros(),
                Vector3::new(0.0, 0.0, 0.3 * f64::from(id)),
            )
    };
    object(name, (0..7).map(|id| (id, size_m, place(id))))
}

pub fn object(name: &str, tags: impl Iterator<Item = (u32, f64, Pose)>) -> ObjectModel {
    let tags = tags.map(|(id, size_m, pose)| ObjectTag::new(tag(id), size_m, Some(pose)));
    ObjectModel::new(name.parse().unwrap(), tags.collect()).unwrap()
}

/// The object with its tags changed.
pub fn changed(model: &ObjectModel, change: impl Fn(&mut ObjectTag)) -> ObjectModel {
    let mut tags = model.tags().to_vec();
    tags.iter_mut().for_each(change);
    ObjectModel::new(model.id().clone(), tags).unwrap()
}

/// Carried about the middle of the room, turned to everyone.
pub fn carried(seconds: f64) -> Pose {
    let wave = |period: f64, phase: f64| (2.0 * PI * seconds / period + phase).sin();
    let position = Vector3::new(
        0.5 * wave(5.0, 0.3),
        0.5 * wave(6.1, 1.0),
        0.7 + 0.3 * wave(4.3, 2.0),
    );
    let heading = Isometry3::new(position, Vector3::new(0.0, 0.0, 2.0 * PI * seconds / 7.0));
    let tilt = Vector3::new(PI / 2.0 + 0.5 * wave(3.7, 0.0), 0.4 * wave(2.9, 1.5), 0.0);
    heading * Isometry3::new(Vector3::zeros(), tilt)
}

/// Turned before one camera, half a metre away.
pub fn turned(seconds: f64) -> Pose {
    let wave = |period: f64, phase: f64| (2.0 * PI * seconds / period + phase).sin();
    let tilt = Vector3::new(0.9 * wave(3.1, 0.0), 0.9 * wave(4.7, 0.5), 0.0);
    Isometry3::new(Vector3::new(0.02 * wave(2.0, 0.0), 0.0, 0.0), tilt)
        * Isometry3::new(
            Vector3::zeros(),
            Vector3::new(0.0, 0.0, 2.0 * PI * seconds / 9.0),
        )
}

/// What of an image is not perfect.
#[derive(Clone, Copy)]
pub struct Lack {
    pub sigma_px: f64,
    /// Part of the tags whose corners are anywhere.
    pub wrong: f64,
}

pub const SHARP: Lack = Lack {
    sigma_px: 0.1,
    wrong: 0.0,
};

/// What a camera sees of an object somewhere; the stamp is its clock's.
pub fn image(
    camera: &Camera,
    model: &ObjectModel,
    world_from_object: &Pose,
    stamp_s: f64,
    lack: Lack,
    noise: &mut Random,
) -> ImageObservation {
    let world_from_camera = camera.world_from_camera.unwrap();
    let camera_from_object = world_from_camera.inverse() * world_from_object;
    let tags = model.tags().iter().filter_map(|tag| {
        let mut corners = corners(
            camera,
            &(camera_from_object * tag.object_from_tag?),
            tag.size_m,
        )?;
        if noise.uniform() < lack.wrong {
            let away = Vector2::new(
                noise.uniform() * 500.0 + 40.0,
                noise.uniform() * 350.0 + 40.0,
            );
            let to = away - corners[0].coords;
            corners = corners.map(|c| Point2::from(c.coords + to * 0.9));
        }
        let shaken =
            corners.map(|c| c + Vector2::new(noise.normal(), noise.normal()) * lack.sigma_px);
        let inside = |c: &Point2<f64>| (0.0..639.0).contains(&c.x) && (0.0..479.0).contains(&c.y);
        shaken.iter().all(inside).then(|| TagCorners {
            tag: tag.tag,
            corners: shaken,
            corner_covariance: [Matrix2::zeros(); 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        })
    });
    ImageObservation {
        camera: camera.id.clone(),
        capture_ns: 1_000_000_000 + (stamp_s * 1e9).round() as u64,
        clock_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
        exposure_ns: 0,
        resolution: None,
        tags: tags.collect(),
    }
}

/// Where a tag's corners are seen; `None` from behind, too slanted or out of the picture.
fn corners(camera: &Camera, camera_from_tag: &Pose, size_m: f64) -> Option<[Point2<f64>; 4]> {
    let centre = camera_from_tag.translation.vector;
    let normal = camera_from_tag.rotation * Vector3::z();
    if -normal.dot(&centre.normalize()) < 0.3 {
        return None;
    }
    let mut seen = [Point2::origin(); 4];
    for (seen, corner) in seen.iter_mut().zip(tag_corners_in_tag(size_m)) {
        *seen = camera.lens.project(&(camera_from_tag * corner))?;
    }
    Some(seen)
}

/// All cameras' images of a walk with synchronised shutters.
pub fn walk(
    rig: &Rig,
    model: &ObjectModel,
    n: u32,
    step_s: f64,
    lack: Lack,
    seed: u64,
) -> Vec<ImageObservation> {
    let mut noise = Random::new(seed);
    let mut images = Vec::new();
    for at in 0..n {
        let seconds = step_s * f64::from(at);
        let pose = carried(seconds);
        for camera in rig.cameras() {
            images.push(image(camera, model, &pose, seconds, lack, &mut noise));
        }
    }
    images
}
