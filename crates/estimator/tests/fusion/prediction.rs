//! Poses ahead of the newest image.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::FusionOptions;
use sextant_geometry::Pose;

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, attitude_error, cube, cube_id, feed, fusion, position_error,
    rig,
};

/// 1 m/s to and fro, slowly changing its way, and 180 degrees a second about an axis that tumbles.
fn fast(time_ns: u64) -> Pose {
    let seconds = (time_ns - START_NS) as f64 * 1e-9;
    let (angle, radius) = (seconds / 0.2, 0.2);
    let place = Vector3::new(angle.cos(), angle.sin(), 0.0) * radius;
    let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.3 * seconds.sin(), 0.2, 0.0));
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::PI * seconds);
    Pose::from_parts(place.into(), tilt * turn)
}

#[test]
fn a_fast_body_is_foreseen_by_33_ms() {
    let (rig, object) = (rig(4), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.03,
    };
    let (mut fusion, mut random) = (fusion(&rig, &object, FusionOptions::default()), Random(5));
    let (mut places, mut turns) = (Vec::new(), Vec::new());
    for number in 0..600u64 {
        let time_ns = START_NS + number * PERIOD_NS / 4;
        let image = eye.image((number % 4) as usize, time_ns, &fast(time_ns), &mut random);
        feed(&mut fusion, image);
        let ahead_ns = time_ns + 33_000_000;
        if number > 60 {
            let ahead = fusion.pose_at(&cube_id(), ahead_ns).unwrap();
            places.push(position_error(&ahead, &fast(ahead_ns)));
            turns.push(attitude_error(&ahead, &fast(ahead_ns)));
        }
    }
    let worst_of_95 = |errors: &mut Vec<f64>| {
        errors.sort_by(f64::total_cmp);
        errors[errors.len() * 95 / 100]
    };
    let (place, turn) = (worst_of_95(&mut places), worst_of_95(&mut turns));
    assert!(place < 5.2e-3, "{place} m");
    assert!(turn < 1f64.to_radians(), "{turn} rad");
}
