//! What two cameras' motions tell of their clocks, by poses of one body every 30 ms for four seconds.

use super::*;

const EVERY_NS: u64 = 30_000_000;
const POSES: u64 = 130;
/// Metres and radians, one sigma, to which poses are known.
const SIGMA: f64 = 0.0005;

/// Poses by the stamps of a camera whose clock is ahead by so much, of a body that is at `x` metres at a time in
/// seconds.
fn seen(ahead_s: f64, x: impl Fn(f64) -> f64) -> VecDeque<Sample> {
    let ahead_ns = (ahead_s * 1e9) as u64;
    let sample = |index: u64| {
        let time_ns = 10_000_000_000 + index * EVERY_NS;
        // Noise that is the same on every run.
        let noise = SIGMA * (1e3 * (index as f64 + ahead_s)).sin();
        let place = x(time_ns as f64 * 1e-9) + noise;
        Sample {
            stamp_ns: time_ns + ahead_ns,
            world_from_body: Pose::translation(place, 0.0, 0.5),
            covariance: Matrix6::identity() * SIGMA.powi(2),
        }
    };
    (0..POSES).map(sample).collect()
}

fn compared(a: &VecDeque<Sample>, b: &VecDeque<Sample>) -> MotionMatch {
    compare(&[MotionPair { a, b }], 0)
}

#[test]
fn motion_tells_the_offset() {
    let waving = |s: f64| 0.1 * (2.0 * s).sin();
    let MotionMatch::Off(found) = compared(&seen(0.0, waving), &seen(0.37, waving)) else {
        panic!("it is not found");
    };
    assert!((found.offset_s - 0.37).abs() < 0.003, "{found:?}");
    assert!(found.sigma_s > 0.0005);
    assert_eq!(
        compared(&seen(0.0, waving), &seen(0.0, waving)),
        MotionMatch::Agree
    );
}

#[test]
fn a_step_that_one_camera_alone_shows_of_a_body_at_rest_tells_none() {
    let still = seen(0.0, |_| 0.0);
    for (step, after_s) in [(0.02, 10.5), (0.05, 11.3), (0.02, 12.9), (0.1, 13.6)] {
        // A track overshoots.
        let stepped = seen(0.0, |s| match s - after_s {
            ..0.0 => step,
            since_s => -0.3 * step * (-since_s / 0.15).exp(),
        });
        for (a, b) in [(&still, &stepped), (&stepped, &still)] {
            let found = compared(a, b);
            assert!(
                !matches!(found, MotionMatch::Off(_)),
                "{step} m at {after_s} s: {found:?}"
            );
        }
    }
}

#[test]
fn an_offset_within_its_deviation_is_none() {
    // Tracks so rough that neither the stamps as they are nor a camera that was moved explains them.
    let waving = |s: f64| 0.1 * (2.0 * s).sin();
    let rough = |s: f64| waving(s) + 0.016 * (1e3 * s).sin();
    let (a, b) = (seen(0.0, waving), seen(0.0, rough));
    let comparison = Comparison {
        pairs: &[MotionPair { a: &a, b: &b }],
    };
    let at_zero = comparison.cost(0.0, FINE);
    let fits = Cost {
        mean: FITS - 4.0,
        compared: FINE,
    };
    let found = |offset_s: f64| verdict(&comparison, &[(offset_s, fits)], at_zero, 0.0);
    assert!(
        matches!(found(0.04), MotionMatch::Off(_)),
        "{:?}",
        found(0.04)
    );
    assert_eq!(found(0.004), MotionMatch::Open);
}
