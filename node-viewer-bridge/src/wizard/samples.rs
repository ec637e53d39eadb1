//! A small site for tests: two cameras, of which the second has a pose, and a cube.

use nalgebra::{Matrix2, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_proto::{KeyRef, ObjectConfig, RigConfig, encode};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, Rig, TagCorners, TagId,
};
use sextant_tag_families::Family;

pub(crate) fn rig() -> Rig {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = |name: &str, world_from_camera| {
        Camera::new(
            CameraId::new(name).unwrap(),
            [640, 480],
            Lens::pinhole(intrinsics).unwrap(),
            world_from_camera,
        )
    };
    let placed = Some(Pose::translation(1.0, 2.0, 3.0));
    Rig::new(vec![camera("a", None), camera("b", placed)]).unwrap()
}

/// Six tags in a row of two, so near that any image shows them all.
pub(crate) fn cube() -> ObjectModel {
    let tag = |id: u32| {
        ObjectTag::new(
            TagId {
                family: Family::Tag36h11,
                id,
            },
            0.04,
            Some(Pose::translation(0.05 * f64::from(id), 0.0, 0.0)),
        )
    };
    ObjectModel::new(ObjectId::new("cube").unwrap(), (0..6).map(tag).collect()).unwrap()
}

/// The site as heard: both models.
pub(crate) fn mirror() -> SiteMirror {
    let mut mirror = SiteMirror::default();
    let cube = encode(&ObjectConfig::from(&cube())).unwrap();
    let key = KeyRef::ConfigObject(ObjectId::new("cube").unwrap());
    mirror.handle(1, &key, None, Ok(&cube)).unwrap();
    hear_rig(&mut mirror, &rig());
    mirror
}

pub(crate) fn hear_rig(mirror: &mut SiteMirror, rig: &Rig) {
    let rig = encode(&RigConfig::from(rig)).unwrap();
    mirror
        .handle(1, &KeyRef::ConfigRig, None, Ok(&rig))
        .unwrap();
}

/// What camera `a` sees of the cube at a step of its way: each step from elsewhere, turned a little otherwise.
pub(crate) fn image(step: u64) -> ImageObservation {
    let (way, at) = (step as f64 * 0.7, step as f64);
    let face = UnitQuaternion::from_scaled_axis(Vector3::new(std::f64::consts::PI, 0.0, 0.0));
    let tilt = Vector3::new(0.6 * way.sin(), 0.6 * (1.7 * way).cos(), 0.3 * way.cos());
    let turn = face * UnitQuaternion::from_scaled_axis(tilt);
    let place = Vector3::new(
        -0.1 + 0.05 * way.sin(),
        0.05 * way.cos(),
        0.5 + 0.1 * (0.37 * at).sin(),
    );
    let camera_from_object = Pose::from_parts(place.into(), turn);
    let lens = rig().cameras()[0].lens;
    let cube = cube();
    let tags = cube.tags().iter().map(|tag| {
        let camera_from_tag = camera_from_object * tag.object_from_tag.unwrap();
        let corners = tag_corners_in_tag(tag.size_m);
        TagCorners {
            tag: tag.tag,
            corners: corners.map(|corner| lens.project(&(camera_from_tag * corner)).unwrap()),
            corner_covariance: [Matrix2::zeros(); 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        }
    });
    ImageObservation {
        camera: CameraId::new("a").unwrap(),
        capture_ns: step * 33_333_333,
        clock_error_ns: 0,
        exposure_ns: 0,
        resolution: None,
        tags: tags.collect(),
    }
}
