//! A camera that stands wrong from the very first image, with an unknown clock error: is the pose wrong, or the clock?

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, ImageObservation, Rig};
use sextant_site_report::Fault;

use crate::scene::{Eye, PERIOD_NS, Random, START_NS, camera_id, cube, fusion, path, poses, rig};

/// The rig with a camera turned by a degree.
fn with_turned(rig: &Rig, camera: usize, about: &Vector3<f64>) -> Rig {
    let mut cameras: Vec<Camera> = rig.cameras().to_vec();
    let turn = UnitQuaternion::from_scaled_axis(about * 1f64.to_radians());
    let by = Pose::from_parts(Vector3::zeros().into(), turn);
    cameras[camera].world_from_camera = cameras[camera].world_from_camera.map(|pose| pose * by);
    Rig::new(cameras).unwrap().exact()
}

/// Faults after each image, with the seconds since the first one.
fn named(wrong: usize, about: &Vector3<f64>, seed: u64) -> Vec<(f64, Vec<Fault>)> {
    let (configured, object, mut random) = (rig(4), cube(), Random(seed));
    let truth = with_turned(&configured, wrong, about);
    let eye = Eye {
        rig: &truth,
        object: &object,
        sigma_px: 0.05,
    };
    let mut fusion = fusion(&configured, &object, FusionOptions::default());
    let mut named = Vec::new();
    for round in 0..150 {
        for camera in 0..4 {
            let after_ns = round * PERIOD_NS + camera as u64 * 7_123_457;
            let (seconds, time_ns) = (after_ns as f64 * 1e-9, START_NS + after_ns);
            let pose = path(seconds + seed as f64 * 1.7);
            let mut image = eye.image(camera, time_ns, &pose, &mut random);
            image.clock_error_ns = ImageObservation::CLOCK_ERROR_UNKNOWN;
            fusion.handle(time_ns + 10_000_000, Input::Image(image));
            drop(poses(&mut fusion));
            named.push((seconds, fusion.faults()));
        }
    }
    named
}

#[test]
fn whichever_camera_stands_wrong_from_the_start_is_named_and_stays_so() {
    let about = [Vector3::x(), Vector3::y(), -Vector3::x(), -Vector3::y()];
    for (seed, (wrong, about)) in (1..).zip(about.iter().enumerate()) {
        let moved = Fault::CameraMoved {
            camera: camera_id(wrong),
        };
        for (seconds, faults) in named(wrong, about, seed) {
            let is_right = faults == [moved.clone()];
            assert!(
                is_right || (faults.is_empty() && seconds < 2.0),
                "camera {wrong} at {seconds:.2} s: {faults:?}"
            );
        }
    }
}

/// Seconds after the first image within which another camera may be reported for what the first one does: tracks begin
/// with what the first one sees.
const FIRST_S: f64 = 2.0;

#[test]
fn no_other_camera_is_reported_for_it() {
    let about = [Vector3::x(), Vector3::y(), -Vector3::x(), -Vector3::y()];
    for (seed, (wrong, about)) in
        (1..6).flat_map(|seed| (0..).zip(&about).map(move |one| (seed, one)))
    {
        let camera = camera_id(wrong);
        let moved = Fault::CameraMoved { camera };
        let faults = named(wrong, about, seed);
        let other = faults
            .iter()
            .filter(|(seconds, _)| wrong != 0 || *seconds > FIRST_S)
            .find(|(_, all)| all.iter().any(|one| *one != moved));
        assert_eq!(other, None, "seed {seed}, camera {wrong}");
        let last = faults.last().map(|(_, all)| all.as_slice());
        assert_eq!(
            last,
            Some([moved].as_slice()),
            "seed {seed}, camera {wrong}"
        );
    }
}
