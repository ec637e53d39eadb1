//! Rolling shutters: each row has its own time, and the twist tells where an object was by then.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::FusionOptions;
use sextant_geometry::Pose;
use sextant_site_model::{CameraId, Exposure, ObjectModel, Rig, Stamp};

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, cube, error, exact_options, feed, fusion, position_error,
    rig, with_cameras,
};

/// Seconds a row: 14 ms an image.
const LINE_DELAY_S: f64 = 3e-5;
const SIGMA_PX: f64 = 0.05;

fn rolling(rig: &Rig) -> Rig {
    // One reads from below.
    let delays = [LINE_DELAY_S, -LINE_DELAY_S, LINE_DELAY_S, LINE_DELAY_S];
    let mut delays_s = delays.into_iter();
    with_cameras(rig, |camera| camera.line_delay_s = delays_s.next())
}

/// Swings at up to 1.1 m/s and turns at up to 3 rad/s.
fn swift(seconds: f64) -> Pose {
    let place = Vector3::new(
        0.22 * (5.0 * seconds).sin(),
        0.10 * (3.7 * seconds).cos(),
        0.05 * (4.1 * seconds).sin(),
    );
    let turn = Vector3::new(0.4 * (2.3 * seconds).sin(), 0.3, 2.5 * seconds);
    Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// Rows are exposed for 10 ms; the cameras stamp this moment of their images.
fn stamping(rig: &Rig, stamp: Stamp) -> Rig {
    let length_s = 0.010;
    with_cameras(rig, |camera| {
        camera.exposure = Some(Exposure { length_s, stamp });
    })
}

/// Seconds from the start of such an image to the middle of its middle row: half of 10 ms and of 479 rows.
const HALF_S: f64 = 0.5 * (0.010 + 479.0 * LINE_DELAY_S);

/// Rms error in m and NEES per degree of freedom, from 0.3 s on, by cameras that run free.
fn followed(truth: &Rig, configured: &Rig, object: &ObjectModel) -> (f64, f64) {
    let eye = Eye {
        rig: truth,
        object,
        sigma_px: SIGMA_PX,
    };
    let (mut square, mut nees, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..4 {
        let mut random = Random(seed + 70);
        let mut fusion = fusion(configured, object, FusionOptions::default());
        let cameras = truth.cameras().len() as u64;
        for number in 0..60 * cameras {
            let after_ns = number * PERIOD_NS / cameras;
            let at_s = after_ns as f64 * 1e-9 + seed as f64;
            let taken = ((number % cameras) as usize, START_NS + after_ns);
            let pose = |after_s: f64| swift(at_s + after_s);
            let mut image = eye.image_over_time(taken.0, taken.1, &pose, &mut random);
            image.capture_ns = stamp_ns(truth, &image.camera, image.capture_ns);
            for estimate in feed(&mut fusion, configured.timed(image)) {
                if after_ns > 300_000_000 {
                    // Where the object was at the time that the estimate states.
                    let stated_s = (estimate.capture_ns as f64 - START_NS as f64) * 1e-9;
                    let truth = swift(stated_s + seed as f64);
                    let off = error(&estimate, &truth);
                    let sure = estimate.covariance.cholesky().unwrap().solve(&off);
                    square += position_error(&estimate, &truth).powi(2);
                    nees += off.dot(&sure) / 6.0;
                    count += 1.0;
                }
            }
        }
    }
    (f64::sqrt(square / count), nees / count)
}

#[test]
fn a_rolling_shutter_that_is_known_costs_no_accuracy() {
    for cameras in [2, 4] {
        let (global, object) = (rig(cameras), cube());
        let rolling = rolling(&global);
        let best = followed(&global, &global, &object);
        let known = followed(&rolling, &rolling, &object);
        let unknown = followed(&rolling, &global, &object);
        assert!(known.0 < 1.2 * best.0, "{known:?} against {best:?}");
        // Below what global shutters give (0.8): what the body may have done between the capture time and the rows is
        // counted for every image by itself, though it is a part of what it may have done since the image before.
        assert!((0.6..1.25).contains(&known.1), "NEES {}", known.1);
        assert!(
            unknown.0 > 2.0 * known.0 && unknown.1 > 5.0,
            "{unknown:?} against {known:?}"
        );
    }
}

/// What a camera of the true rig stamps an image with whose exposure has its middle then.
fn stamp_ns(truth: &Rig, camera: &CameraId, middle_ns: u64) -> u64 {
    let half_ns = (HALF_S * 1e9) as u64;
    let exposure = truth.camera(camera).and_then(|camera| camera.exposure);
    match exposure.map(|exposure| exposure.stamp) {
        Some(Stamp::Start) => middle_ns - half_ns,
        Some(Stamp::End) => middle_ns + half_ns,
        Some(Stamp::Middle) | None => middle_ns,
    }
}

/// 12 ms at 1 m/s: stamps of another moment than the rig says displace what moves by a centimetre.
#[test]
fn stamps_of_the_start_or_end_of_the_exposure_cost_nothing_where_the_rig_says_so() {
    let (rolling, object) = (rolling(&rig(3)), cube());
    let middle = followed(&rolling, &rolling, &object);
    for stamp in [Stamp::Start, Stamp::End] {
        let truth = stamping(&rolling, stamp);
        let said = followed(&truth, &truth, &object);
        let unsaid = followed(&truth, &rolling, &object);
        assert!(
            (said.0 - middle.0).abs() < 0.05 * middle.0 && (0.6..1.25).contains(&said.1),
            "{stamp:?}: {said:?} against {middle:?}"
        );
        assert!(
            unsaid.0 > 0.005 && unsaid.0 > 10.0 * said.0,
            "{stamp:?}: {unsaid:?} against {said:?}"
        );
    }
}

/// The first image of an object that moves: nothing but the corners' own times tells how fast.
#[test]
fn one_image_tells_that_an_object_moves() {
    let (rig, object) = (rolling(&rig(1)), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.01,
    };
    let pose = |after_s: f64| swift(0.1 + after_s);
    let image = eye.image_over_time(0, START_NS, &pose, &mut Random(3));
    let mut fusion = fusion(&rig, &object, exact_options());
    let found = feed(&mut fusion, image).pop().unwrap();
    let off = error(&found, &pose(0.0));
    let sure = found.covariance.cholesky().unwrap().solve(&off);
    assert!(off.dot(&sure) / 6.0 < 4.0, "{off}");
}
