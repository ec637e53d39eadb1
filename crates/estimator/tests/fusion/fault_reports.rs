//! What is wrong with a site is named, and nothing else.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, ImageObservation, ObjectModel, ObjectTag, Rig};
use sextant_site_report::Fault;

use crate::scene::{
    Eye, Random, START_NS, camera_id, cube, cube_id, feed, fusion, path_at, rig, run, tag_id,
};

/// What the machine says is wrong after some seconds, if it believes in the site of the scenes but the images are of
/// another.
fn faults(rig_in_truth: &Rig, object_in_truth: &ObjectModel, seconds: f64) -> Vec<Fault> {
    let mut fusion = fusion(&rig(4), &cube(), FusionOptions::default());
    for image in run(rig_in_truth, object_in_truth, 0.1, seconds, &mut Random(8)) {
        feed(&mut fusion, image);
    }
    fusion.faults()
}

fn cube_with(change: impl Fn(&mut ObjectTag)) -> ObjectModel {
    let mut tags = cube().tags().to_vec();
    change(&mut tags[0]);
    ObjectModel::new(cube_id(), tags).unwrap().exact()
}

#[test]
fn a_sound_site_has_no_faults() {
    let mut fusion: Fusion = fusion(&rig(4), &cube(), FusionOptions::default());
    for image in run(&rig(4), &cube(), 0.1, 20.0, &mut Random(8)) {
        feed(&mut fusion, image);
        assert_eq!(fusion.faults(), []);
    }
}

#[test]
fn a_camera_that_was_bumped_is_named() {
    let mut cameras: Vec<Camera> = rig(4).cameras().to_vec();
    let bump = Pose::from_parts(
        Vector3::zeros().into(),
        UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0175, 0.0)),
    );
    cameras[2].world_from_camera = cameras[2].world_from_camera.map(|pose| pose * bump);
    let found = faults(&Rig::new(cameras).unwrap().exact(), &cube(), 2.0);
    assert_eq!(
        found,
        [Fault::CameraMoved {
            camera: camera_id(2)
        }]
    );
}

#[test]
fn a_tag_that_slipped_is_named() {
    let slipped = cube_with(|tag| {
        tag.object_from_tag = tag
            .object_from_tag
            .map(|pose| pose * Pose::translation(0.003, 0.0, 0.0))
    });
    let found = faults(&rig(4), &slipped, 3.0);
    assert_eq!(
        found,
        [Fault::TagMisplaced {
            object: cube_id(),
            tag: tag_id(0)
        }]
    );
}

#[test]
fn a_tag_in_the_image_twice_is_named() {
    let mut fusion = fusion(&rig(4), &cube(), FusionOptions::default());
    let mut images: Vec<ImageObservation> = run(&rig(4), &cube(), 0.1, 0.5, &mut Random(8));
    let twin = images[20].tags[0].clone();
    let (camera, tag) = (images[20].camera.clone(), twin.tag);
    images[20].tags.push(twin);
    images
        .into_iter()
        .for_each(|image| drop(feed(&mut fusion, image)));
    assert_eq!(fusion.faults(), [Fault::DuplicateTag { camera, tag }]);
}

#[test]
fn a_tag_of_another_size_is_named_with_its_size() {
    let larger = cube_with(|tag| tag.size_m *= 1.02);
    let found = faults(&rig(4), &larger, 3.0);
    assert!(
        matches!(found[..], [Fault::TagSize { tag, ratio, .. }] if tag == tag_id(0) && (ratio - 1.02).abs() < 0.004),
        "{found:?}"
    );
}

#[test]
fn ten_minutes_without_a_fault_raise_no_alarm() {
    let (rig, object, mut random) = (rig(3), cube(), Random(4));
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    for round in 0..10 * 60 * 20 {
        for camera in 0..3 {
            let time_ns = START_NS + round * 50_000_000 + camera as u64 * 16_000_000;
            let image = eye.image(camera, time_ns, &path_at(time_ns), &mut random);
            feed(&mut fusion, image);
        }
        assert_eq!(fusion.faults(), [], "round {round}");
    }
}
