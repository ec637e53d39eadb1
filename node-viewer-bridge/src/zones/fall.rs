//! Whether an object fell: it lost height faster than anybody puts something down, or it tipped over where it stood.
//!
//! Drop: the origin sinks by more than 15 cm plus two sigma within a quarter of a second; free fall from rest takes
//! 0.18 s for that, a hand about half a second. Tilt: the axis that was vertical while the object rested leans by more
//! than 45 degrees plus two sigma. An object that was lifted before is being carried, and may be turned as one likes.

use super::event::FallCause;
use super::sample::Sample;
use nalgebra::Vector3;
use std::collections::VecDeque;

const DROP_M: f64 = 0.15;
const DROP_WITHIN_NS: u64 = 250_000_000;
const TILT_RAD: f64 = 45.0 * std::f64::consts::PI / 180.0;
/// Rise of the origin that is a lift. A box that tips over an edge rises by less.
const LIFT_M: f64 = 0.05;
/// Slower than this for this long is rest.
const REST_SPEED_M_S: f64 = 0.05;
const REST_RATE_RAD_S: f64 = 0.2;
const REST_NS: u64 = 1_000_000_000;
/// A fall is reported once: nothing more is reported for so long.
const QUIET_NS: u64 = 2_000_000_000;
const SIGMAS: f64 = 2.0;
/// Heights of the last quarter of a second; enough for 250 poses a second, the oldest are dropped.
const HEIGHTS: usize = 64;

#[derive(Debug, Clone, Copy)]
struct Height {
    t_ns: u64,
    z: f64,
    variance: f64,
}

/// How an object stood when it last rested.
#[derive(Debug, Clone, Copy)]
struct Rest {
    z: f64,
    /// The world's vertical in the object's frame.
    up_in_object: Vector3<f64>,
}

/// Follows one object.
#[derive(Debug, Default)]
pub(crate) struct FallDetector {
    heights: VecDeque<Height>,
    slow_since_ns: Option<u64>,
    rest: Option<Rest>,
    quiet_until_ns: u64,
}

impl FallDetector {
    /// Takes a measured pose, later than those before.
    pub(crate) fn handle(&mut self, sample: &Sample) -> Option<FallCause> {
        let height = Height {
            t_ns: sample.t_ns,
            z: sample.position.z,
            variance: sample.covariance[(2, 2)],
        };
        let cause = match (self.has_dropped(height), self.has_tipped(sample)) {
            (true, _) => Some(FallCause::Drop),
            (false, true) => Some(FallCause::Tilt),
            (false, false) => None,
        };
        self.record(height);
        self.update_rest(sample);
        let cause = cause.filter(|_| sample.t_ns >= self.quiet_until_ns)?;
        self.quiet_until_ns = sample.t_ns.saturating_add(QUIET_NS);
        self.rest = None;
        Some(cause)
    }

    fn has_dropped(&self, now: Height) -> bool {
        let recent = self.heights.iter();
        let mut recent = recent.filter(|before| now.t_ns - before.t_ns <= DROP_WITHIN_NS);
        recent.any(|before| {
            let sigma = (before.variance + now.variance).max(0.0).sqrt();
            before.z - now.z > DROP_M + SIGMAS * sigma
        })
    }

    fn has_tipped(&self, sample: &Sample) -> bool {
        let Some(rest) = self.rest else { return false };
        let lean = (sample.orientation * rest.up_in_object).angle(&Vector3::z());
        lean > TILT_RAD + SIGMAS * sample.sigma_inclination()
    }

    fn record(&mut self, height: Height) {
        if self.heights.len() == HEIGHTS {
            self.heights.pop_front();
        }
        self.heights.push_back(height);
    }

    fn update_rest(&mut self, sample: &Sample) {
        let is_slow = sample.speed < REST_SPEED_M_S && sample.angular_speed < REST_RATE_RAD_S;
        if !is_slow {
            self.slow_since_ns = None;
            let sigma = sample.sigma_along(&Vector3::z());
            let lifted = |rest: &Rest| sample.position.z - rest.z > LIFT_M + SIGMAS * sigma;
            self.rest = self.rest.filter(|rest| !lifted(rest));
            return;
        }
        let since = *self.slow_since_ns.get_or_insert(sample.t_ns);
        if sample.t_ns - since >= REST_NS {
            self.rest = Some(Rest {
                z: sample.position.z,
                up_in_object: sample.orientation.inverse() * Vector3::z(),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, UnitQuaternion};

    const FRAME_NS: u64 = 33_000_000;

    /// What is reported of a height (m) and a lean (rad) over time (s), at 30 Hz.
    fn falls(seconds: f64, sigma_m: f64, motion: impl Fn(f64) -> (f64, f64)) -> Vec<FallCause> {
        let mut detector = FallDetector::default();
        let frames = (seconds * 1e9) as u64 / FRAME_NS;
        let step = FRAME_NS as f64 / 1e9;
        let sample = |frame: u64| {
            let t = frame as f64 * step;
            let ((z, lean), (z_before, lean_before)) = (motion(t), motion(t - step));
            Sample {
                t_ns: 1 + frame * FRAME_NS,
                position: Vector3::new(0.0, 0.0, z),
                orientation: UnitQuaternion::from_euler_angles(lean, 0.0, 0.0),
                covariance: Matrix6::identity() * sigma_m * sigma_m,
                speed: (z - z_before).abs() / step,
                angular_speed: (lean - lean_before).abs() / step,
                is_measured: true,
            }
        };
        (0..frames)
            .filter_map(|frame| detector.handle(&sample(frame)))
            .collect()
    }

    fn ramp(t: f64, from: f64, seconds: f64) -> f64 {
        ((t - from) / seconds).clamp(0.0, 1.0)
    }

    #[test]
    fn free_fall_from_a_table_is_reported_once() {
        let height = |t: f64| (0.75 - 4.9 * (t - 2.0).max(0.0).powi(2)).max(0.0);
        assert_eq!(falls(4.0, 0.001, |t| (height(t), 0.0)), [FallCause::Drop]);
    }

    #[test]
    fn putting_something_down_is_no_fall() {
        assert_eq!(
            falls(5.0, 0.001, |t| (0.5 * (1.0 - ramp(t, 2.0, 1.0)), 0.0)),
            []
        );
    }

    #[test]
    fn a_drop_within_the_uncertainty_is_no_fall() {
        let motion = |t: f64| (0.2 * (1.0 - ramp(t, 2.0, 0.1)), 0.0);
        assert_eq!(falls(3.0, 0.001, motion), [FallCause::Drop]);
        assert_eq!(falls(3.0, 0.05, motion), []);
    }

    #[test]
    fn tipping_over_is_a_fall_and_turning_what_was_lifted_is_none() {
        let lean = |t: f64| 1.5 * ramp(t, 2.0, 0.6);
        assert_eq!(falls(5.0, 0.001, |t| (0.1, lean(t))), [FallCause::Tilt]);
        let lifted = |t: f64| (0.1 + 0.2 * ramp(t, 1.5, 0.4), lean(t));
        assert_eq!(falls(5.0, 0.001, lifted), []);
    }

    #[test]
    fn what_lies_on_its_side_may_fall_again() {
        let lean = |t: f64| 1.5 * ramp(t, 2.0, 0.5) + 1.5 * ramp(t, 6.0, 0.5);
        let both = [FallCause::Tilt, FallCause::Tilt];
        assert_eq!(falls(8.0, 0.001, |t| (0.1, lean(t))), both);
    }
}
