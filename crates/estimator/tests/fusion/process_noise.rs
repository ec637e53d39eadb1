//! How restless a body is, is found out, whatever it does and whenever it is seen.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_report::State;

use crate::scene::{Eye, PERIOD_NS, Random, START_NS, cube, exact_options, feed, fusion, rig};
use crate::uncertainty::nees;

/// Shaken by hand: 1 m/s at 12 m/s², 5 rad/s at 50 rad/s².
fn shaken(time_ns: u64) -> Pose {
    let seconds = (time_ns - START_NS) as f64 * 1e-9;
    let wave = |rate: f64, phase: f64| (rate * seconds + phase).sin();
    let place = Vector3::new(wave(12.0, 0.3), wave(11.0, 1.0), wave(9.0, 2.0)) * 0.08;
    let turn = Vector3::new(wave(10.0, 0.0), wave(9.0, 1.0), wave(11.0, 2.0)) * 0.5;
    Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// NEES per degree of freedom, on the whole, of short runs with the cameras' shutters at these phases.
fn mean_nees(phases_ns: [u64; 3], path: impl Fn(u64) -> Pose) -> f64 {
    let (rig, object) = (rig(3), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let mut values = Vec::new();
    for seed in 0..12 {
        let (mut fusion, mut random) = (fusion(&rig, &object, exact_options()), Random(seed));
        for round in 0..18 {
            for (camera, phase_ns) in phases_ns.into_iter().enumerate() {
                let time_ns = START_NS + seed * 431_000_000 + round * PERIOD_NS + phase_ns;
                let image = eye.image(camera, time_ns, &path(time_ns), &mut random);
                let said = feed(&mut fusion, image);
                values.extend(said.iter().map(|one| nees(one, &path(one.capture_ns))));
            }
        }
    }
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_body_shaken_from_the_start_is_known_as_well_as_is_said() {
    let mean = mean_nees([0, 11_000_000, 22_000_000], shaken);
    assert!((0.7..1.5).contains(&mean), "NEES {mean}");
}

#[test]
fn images_in_bunches_with_gaps_between_are_taken_for_what_they_are() {
    let mean = mean_nees([0, 2_000_000, 5_000_000], shaken);
    assert!((0.7..1.5).contains(&mean), "NEES {mean}");
}

/// Lies still for half a second, then flies off at 2.5 m/s and 5 rad/s from one moment to the next.
fn struck(time_ns: u64) -> Pose {
    let flown_s = ((time_ns - START_NS) as f64 * 1e-9 - 0.5).max(0.0);
    let place = Vector3::new(-0.15 + 2.5 * flown_s, 0.0, 0.0);
    let turn = Vector3::new(0.3, 5.0 * flown_s, 0.0);
    Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

#[test]
fn nothing_is_said_for_sure_of_a_body_that_was_struck_until_it_is_followed_again() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    for seed in 0..6 {
        let (mut fusion, mut random) = (fusion(&rig, &object, exact_options()), Random(seed));
        let mut followed = 0;
        for number in 0..76 {
            let time_ns = START_NS + seed * 3_000_000 + number * PERIOD_NS / 4;
            let camera = (number % 4) as usize;
            let image = eye.image(camera, time_ns, &struck(time_ns), &mut random);
            for said in feed(&mut fusion, image) {
                let nees = nees(&said, &struck(said.capture_ns));
                assert!(nees < 8.0, "seed {seed}, image {number}: NEES {nees}");
                followed += u32::from(number >= 66 && said.state == State::Tracking);
            }
        }
        assert!(followed >= 8, "seed {seed}: {followed} of 10");
    }
}

/// Hangs still for half a second, then flies off at 0.5 m/s towards the first camera.
fn struck_towards_a_camera(time_ns: u64) -> Pose {
    let flown_s = ((time_ns - START_NS) as f64 * 1e-9 - 0.5).max(0.0);
    let place = Vector3::new(1.0, 0.0, 0.7).normalize() * (0.5 * flown_s);
    Pose::new(place, Vector3::new(0.3, 0.2, 0.1))
}

/// A camera hardly sees how far away a body is, so that it agrees with the prediction; the other, at the same instant,
/// does not.
#[test]
fn a_body_that_was_struck_is_followed_by_cameras_that_see_it_at_once() {
    let (rig, object) = (rig(2), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    for seed in 0..6 {
        let (mut fusion, mut random) = (fusion(&rig, &object, exact_options()), Random(seed));
        for number in 0..40 {
            let time_ns = START_NS + seed * 3_000_000 + number * PERIOD_NS;
            let pose = struck_towards_a_camera(time_ns);
            let first = eye.image(0, time_ns, &pose, &mut random);
            feed(&mut fusion, first);
            let second = eye.image(1, time_ns, &pose, &mut random);
            for said in feed(&mut fusion, second) {
                let nees = nees(&said, &pose);
                assert!(nees < 8.0, "seed {seed}, instant {number}: NEES {nees}");
            }
        }
    }
}
