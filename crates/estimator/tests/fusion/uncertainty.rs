//! The covariance is what the errors are: Monte Carlo with known noise.

use nalgebra::{Matrix2, Vector2, Vector6};
use sextant_estimator::{FusionOptions, ObjectEstimate, State};
use sextant_geometry::Pose;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, cube, cube_id, error, exact_options, feed, fusion, path_at,
    position_error, rig, run, run_in_phase,
};

pub fn nees(estimate: &ObjectEstimate, truth: &Pose) -> f64 {
    let off: Vector6<f64> = error(estimate, truth);
    off.dot(&estimate.covariance.cholesky().unwrap().solve(&off)) / 6.0
}

/// NEES per degree of freedom at the end of many runs of 0.8 s on all parts of the path, and the share inside the 95 % ellipsoid.
fn mean_nees(cameras: usize, runs: u64) -> (f64, f64) {
    let (rig, object) = (rig(cameras), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.1,
    };
    let mut values = Vec::new();
    for seed in 0..runs {
        let mut fusion = fusion(&rig, &object, exact_options());
        let start_ns = 137_000_000 * seed;
        let phase_ns = |camera: usize| start_ns + camera as u64 * PERIOD_NS / cameras as u64;
        let mut last = None;
        for image in run_in_phase(&eye, 0.8, phase_ns, &mut Random(seed)) {
            last = feed(&mut fusion, image).pop().or(last);
        }
        let last = last.unwrap();
        values.push(nees(&last, &path_at(last.capture_ns)));
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let inside = values.iter().filter(|nees| **nees < 12.592 / 6.0).count();
    (mean, inside as f64 / values.len() as f64)
}

#[test]
fn errors_of_a_thousand_runs_are_as_large_as_the_covariance_says() {
    let of_two = mean_nees(2, 500);
    let of_four = mean_nees(4, 500);
    let (mean, inside) = (0.5 * (of_two.0 + of_four.0), 0.5 * (of_two.1 + of_four.1));
    assert!((0.9..1.1).contains(&mean), "NEES {of_two:?} {of_four:?}");
    assert!(
        (0.9..=0.98).contains(&inside),
        "{of_two:?} {of_four:?} inside"
    );
}

#[test]
fn a_lone_camera_knows_how_little_it_sees() {
    let (mean, inside) = mean_nees(1, 500);
    assert!((0.9..1.25).contains(&mean), "NEES {mean}");
    assert!((0.87..=0.98).contains(&inside), "{inside} inside");
}

#[test]
fn noise_that_is_twice_what_is_stated_is_found_out() {
    let (rig, object) = (rig(4), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let mut values = Vec::new();
    for mut image in run(&rig, &object, 0.2, 6.0, &mut Random(5)) {
        for tag in &mut image.tags {
            tag.corner_covariance
                .iter_mut()
                .for_each(|covariance| *covariance *= 0.25);
        }
        let time_ns = image.capture_ns;
        for estimate in feed(&mut fusion, image)
            .iter()
            .filter(|_| time_ns > START_NS + 1_000_000_000)
        {
            values.push(nees(estimate, &path_at(time_ns)));
        }
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    assert!((0.7..1.4).contains(&mean), "NEES {mean}");
}

/// About 0.015 px, another in every view, where 0.05 px are usual.
#[test]
fn noise_that_nobody_states_is_found_out_within_a_second() {
    let (rig, object) = (rig(4), cube());
    let (mut values, mut random) = (Vec::new(), Random(31));
    for seed in 0..6 {
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        for mut image in run(&rig, &object, 0.0, 3.0, &mut Random(seed)) {
            for tag in &mut image.tags {
                let sigma_px = 0.015 * (0.45 * random.gauss()).exp();
                for corner in &mut tag.corners {
                    *corner += Vector2::new(random.gauss(), random.gauss()) * sigma_px;
                }
            }
            let time_ns = image.capture_ns;
            let said = feed(&mut fusion, image);
            let late = said.iter().filter(|_| time_ns > START_NS + 1_000_000_000);
            values.extend(late.map(|estimate| nees(estimate, &path_at(time_ns))));
        }
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    assert!((0.7..1.4).contains(&mean), "NEES {mean}");
}

#[test]
fn four_cameras_give_a_tenth_of_a_millimetre() {
    let (rig, object) = (rig(4), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let mut worst: f64 = 0.0;
    for image in run(&rig, &object, 0.1, 3.0, &mut Random(11)) {
        let time_ns = image.capture_ns;
        for estimate in feed(&mut fusion, image) {
            if time_ns > START_NS + 100_000_000 {
                assert_eq!(estimate.state, State::Tracking);
                worst = worst.max(position_error(&estimate, &path_at(time_ns)));
            }
        }
    }
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn a_prediction_by_33_ms_stays_within_5_mm_and_its_covariance_grows() {
    let (rig, object) = (rig(4), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    for image in run(&rig, &object, 0.1, 1.0, &mut Random(2)) {
        feed(&mut fusion, image);
    }
    let newest_ns = START_NS + 990_000_000;
    let trace = |ms: u64| {
        fusion
            .pose_at(&cube_id(), newest_ns + ms * 1_000_000)
            .unwrap()
            .covariance
            .trace()
    };
    assert!(trace(10) < trace(33) && trace(33) < trace(100));
    let ahead = fusion.pose_at(&cube_id(), newest_ns + 33_000_000).unwrap();
    assert!(position_error(&ahead, &path_at(ahead.capture_ns)) < 5e-3);
    assert_eq!(ahead.state, State::Coasting);
}

/// Six times as usual: most views are refused at first, and those that are not seem quieter than they are.
#[test]
fn much_noise_that_nobody_states_is_found_out_within_half_a_second() {
    let (rig, object) = (rig(4), cube());
    let mut values = Vec::new();
    for seed in 0..6 {
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        for mut image in run(&rig, &object, 0.3, 1.5, &mut Random(seed + 40)) {
            for tag in &mut image.tags {
                tag.corner_covariance = [Matrix2::zeros(); 4];
            }
            let time_ns = image.capture_ns;
            let said = feed(&mut fusion, image);
            let late = said.iter().filter(|_| time_ns > START_NS + 500_000_000);
            values.extend(late.map(|estimate| nees(estimate, &path_at(time_ns))));
        }
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    assert!((0.7..1.4).contains(&mean), "NEES {mean}");
}
