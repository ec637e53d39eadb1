//! Cameras of which everything is known, things carried before them, and `detections.jsonl` of what they would see.

#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file takes what it needs, and a test may panic"
)]

use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::{Value, json};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_simulator::Random;
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};
use sextant_tag_families::Family;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

/// Standard deviation of every coordinate of a corner, pixels.
const NOISE_PX: f64 = 0.1;

/// Three cameras a third of a circle apart, looking to its middle.
pub fn rig() -> Rig {
    let camera = |(at, name): (usize, &&str)| {
        let angle = PI * (0.15 + 0.5 * at as f64);
        let from = Point3::new(1.9 * angle.cos(), 1.9 * angle.sin(), 1.3 + 0.2 * at as f64);
        let to = Point3::new(0.0, 0.0, 0.6);
        let numbers = Intrinsics {
            fx: 600.0 + 6.0 * at as f64,
            fy: 602.0,
            cx: 318.0,
            cy: 242.0 - 6.0 * at as f64,
        };
        Camera::new(
            CameraId::new(name).unwrap(),
            [640, 480],
            Lens::pinhole(numbers).unwrap(),
            Some(Isometry3::face_towards(&from, &to, &-Vector3::z())),
        )
    };
    let names = ["east", "north", "west"];
    Rig::new(names.iter().enumerate().map(camera).collect()).unwrap()
}

/// The rig as a person has it before: lenses only.
pub fn without_poses(rig: &Rig) -> Rig {
    let cameras = rig.cameras().iter().map(|camera| Camera {
        world_from_camera: None,
        ..camera.clone()
    });
    Rig::new(cameras.collect()).unwrap()
}

/// A board with twelve tags on either side.
pub fn board() -> ObjectModel {
    let place = |id: u32| {
        let (side, at) = (id / 12, id % 12);
        let x = 0.105 * (f64::from(at % 4) - 1.5);
        let y = 0.105 * (f64::from(at / 4) - 1.0);
        let (turn, z) = [(0.0, 0.006), (PI, -0.006)][side as usize];
        Isometry3::new(Vector3::new(x, y, z), Vector3::y() * turn)
    };
    object("board", (0..24).map(|id| (id, 0.08, place(id))))
}

/// A cap: a tag on top and five leaning around it.
pub fn cap() -> ObjectModel {
    let place = |id: u32| {
        let lean = if id == 0 { 0.0 } else { 0.9 };
        let around = Isometry3::rotation(Vector3::z() * (f64::from(id) * 0.4 * PI));
        around * Isometry3::rotation(Vector3::y() * lean) * Isometry3::translation(0.0, 0.0, 0.06)
    };
    object("cap", (0..6).map(|id| (id, 0.04, place(id))))
}

fn object(name: &str, tags: impl Iterator<Item = (u32, f64, Pose)>) -> ObjectModel {
    let tags = tags.map(|(id, size_m, pose)| ObjectTag::new(tag(id), size_m, Some(pose)));
    ObjectModel::new(ObjectId::new(name).unwrap(), tags.collect()).unwrap()
}

pub fn tag(id: u32) -> TagId {
    TagId {
        family: Family::Tag36h11,
        id,
    }
}

/// Carried about the middle of the room, turned to everyone.
pub fn through_the_room(seconds: f64) -> Pose {
    let wave = |period: f64, phase: f64| (2.0 * PI * seconds / period + phase).sin();
    let position = Vector3::new(
        0.5 * wave(5.0, 0.3),
        0.5 * wave(6.1, 1.0),
        0.7 + 0.3 * wave(4.3, 2.0),
    );
    let heading = Isometry3::new(position, Vector3::z() * (2.0 * PI * seconds / 7.0));
    let tilt = Vector3::new(PI / 2.0 + 0.5 * wave(3.7, 0.0), 0.4 * wave(2.9, 1.5), 0.0);
    heading * Isometry3::rotation(tilt)
}

/// Turned half a metre before a camera.
pub fn before(camera: &Camera, seconds: f64) -> Pose {
    let wave = |period: f64, phase: f64| (2.0 * PI * seconds / period + phase).sin();
    let facing = Isometry3::new(Vector3::z() * 0.5, Vector3::x() * PI);
    let tilt = Vector3::new(0.9 * wave(3.1, 0.0), 0.9 * wave(4.7, 0.5), 0.0);
    let spin = Isometry3::rotation(Vector3::z() * (2.0 * PI * seconds / 9.0));
    camera.world_from_camera.unwrap() * facing * Isometry3::rotation(tilt) * spin
}

/// Writes `CAMERA/detections.jsonl` of so many images a tenth of a second apart.
pub fn record(
    folder: &Path,
    camera: &Camera,
    object: &ObjectModel,
    images: u32,
    pose_at: impl Fn(f64) -> Pose,
) {
    let mut random = Random::new(1);
    let mut text = String::new();
    for at in 0..images {
        let camera_from_object =
            camera.world_from_camera.unwrap().inverse() * pose_at(0.1 * f64::from(at));
        let see = |tag| detection(camera, &camera_from_object, tag, &mut random);
        let seen: Vec<Value> = object.tags().iter().filter_map(see).collect();
        let t_ns = 1_000_000_000 + 100_000_000 * u64::from(at);
        text += &format!("{}\n", json!({"t_ns": t_ns, "detections": seen}));
    }
    let folder = folder.join(camera.id.as_str());
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("detections.jsonl"), text).unwrap();
}

/// `None` from behind, too slanted or out of the picture.
fn detection(
    camera: &Camera,
    camera_from_object: &Pose,
    tag: &ObjectTag,
    random: &mut Random,
) -> Option<Value> {
    let pose = camera_from_object * tag.object_from_tag?;
    let towards = pose.translation.vector.normalize();
    if -towards.dot(&(pose.rotation * Vector3::z())) < 0.3 {
        return None;
    }
    let mut corners = [[0.0; 2]; 4];
    for (corner, point) in corners.iter_mut().zip(tag_corners_in_tag(tag.size_m)) {
        let pixel = camera.lens.project(&(pose * point))?;
        let inside = (2.0..637.0).contains(&pixel.x) && (2.0..477.0).contains(&pixel.y);
        inside.then_some(())?;
        *corner = [pixel.x, pixel.y].map(|at| at + noise_px(random));
    }
    Some(json!({"family": tag.tag.family, "id": tag.tag.id, "corners": corners}))
}

/// Evenly distributed, with the standard deviation [`NOISE_PX`].
fn noise_px(random: &mut Random) -> f64 {
    random.between(-0.5, 0.5) * 12.0_f64.sqrt() * NOISE_PX
}
