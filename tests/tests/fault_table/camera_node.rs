//! A real camera node of two processes that renders its images, and an object that it alone sees.

use super::*;
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{Background, Path, Scenario, SceneCamera, SceneObject, SceneTag, Solid};
use sextant_site_model::{Camera, CameraId, ObjectModel, Rig};

pub const DIE: &str = "die";
pub const CAMERA: &str = "eye";

/// Where the object stays.
pub fn die_at() -> Isometry3<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
    Isometry3::from_parts(Vector3::new(0.6, 0.6, 0.0).into(), turn)
}

fn eye() -> Camera {
    let place = Vector3::new(0.6, 0.25, 0.25);
    let forward = (die_at().translation.vector - place).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let rotation = Rotation3::from_basis_unchecked(&[right, forward.cross(&right), forward]);
    let intrinsics = Intrinsics {
        fx: 300.0,
        fy: 300.0,
        cx: 159.5,
        cy: 119.5,
    };
    Camera::new(
        CameraId::new(CAMERA).expect("an id"),
        [320, 240],
        Lens::pinhole(intrinsics).expect("a lens"),
        Some(Pose::from_parts(
            place.into(),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )),
    )
}

fn die() -> ObjectModel {
    Scene::new(CAMERAS, &["box", "cube", DIE]).objects.remove(2)
}

/// What the camera node renders.
fn scenario() -> Scenario {
    let (camera, die) = (eye(), die());
    let tag = |tag: &sextant_site_model::ObjectTag| {
        let at = tag.object_from_tag.expect("a place");
        SceneTag::new(tag.tag.family, tag.tag.id, tag.size_m, at)
    };
    let pose = camera.world_from_camera.expect("a place");
    Scenario {
        background: Background::Plain { level: 110.0 },
        cameras: vec![SceneCamera {
            rate_hz: 10.0,
            ..SceneCamera::new(CAMERA, camera.resolution, camera.lens, pose)
        }],
        objects: vec![SceneObject {
            id: DIE.to_owned(),
            solids: vec![Solid::Box {
                size: [0.06; 3],
                object_from_box: Pose::identity(),
                albedo: 0.4,
            }],
            tags: die.tags().iter().map(tag).collect(),
            path: Path::at_rest(&die_at()),
        }],
        ..Scenario::demo(1, 1, 1)
    }
}

/// A house of the usual scene whose files know the camera and its object, too.
pub fn house() -> House {
    let seen = scene();
    let mut cameras = seen.rig.cameras().to_vec();
    cameras.push(eye());
    let mut objects = seen.objects.clone();
    objects.push(die());
    House::with_files(
        &Scene::from_models(Rig::new(cameras).expect("a rig"), objects),
        &seen,
    )
}

/// Writes the scenario, and makes the text of a camera node's file that connects to `router` and shares images under
/// `prefix`.
pub fn write_files(house: &House, router: &str, prefix: &str) -> String {
    std::fs::create_dir(house.path("", CAMERA)).expect("a folder");
    let file = house.path(CAMERA, "scenario.toml");
    sextant_site_files::write_toml(&file, &scenario()).expect("a file");
    format!(
        "site = \"lab\"\ncamera = \"{CAMERA}\"\n[source]\nkind = \"simulator\"\n\
         scenario = \"scenario.toml\"\n[shared_memory]\nroot = \"i\"\nprefix = \"{prefix}\"\n\
         [network]\nmode = \"client\"\nconnect = [\"{router}\"]\n"
    )
}

/// Distance of a pose of its object from the truth, m.
pub fn error_m(pose: &sextant_proto::ObjectPose) -> f64 {
    (Vector3::from(pose.position) - die_at().translation.vector).norm()
}

/// What begins with `prefix` in shared memory, and the folder of its bookkeeping.
pub fn in_shared_memory(house: &House, prefix: &str) -> Vec<String> {
    let entries = |folder: &std::path::Path, prefix: &str| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let names = entries.map(|one| one.file_name().to_string_lossy().into_owned());
        let own = names.filter(|name| name.starts_with(prefix));
        own.collect::<Vec<_>>()
    };
    let mut files = entries("/dev/shm".as_ref(), prefix);
    files.extend(entries(&house.path(CAMERA, "i"), ""));
    files
}
