//! What is known about joints that can't leave their limits: the density truncated at them.
//!
//! Mean and variance of a value become those of its Gaussian within the limits, and the rest of the state follows by its
//! correlation (Simon, Simon 2010, Constrained Kalman filtering via density function truncation, Int. J. Systems Sci. 41,
//! eqs. 24-33, with two-sided limits; here joint by joint, in their order). So the estimate always respects the limits, and
//! its covariance shrinks where they cut something off. Only what is published is truncated: the filter goes on with the
//! untruncated density, for the limits are one piece of knowledge, and taken in at every image they would count as many.

use nalgebra::SVector;
use sextant_geometry::se3;

use crate::filter::covariance::{WIDTH, symmetric};
use crate::filter::state::ObjectState;
use sextant_site_model::MOST_JOINTS;

/// Intervals of Simpson's rule for the moments.
const INTERVALS: usize = 64;
/// Scales of its decay beyond which a density is nothing.
const FAR: f64 = 9.0;

impl ObjectState {
    /// Takes in that the joints' values lie within their limits and their speeds within the highest.
    pub fn keep_within_limits(&mut self) {
        let Some(joints) = &self.joints else {
            return;
        };
        let chain = joints.chain.clone();
        for (slot, joint) in chain.moving().enumerate() {
            if let Some(limits) = joint.limits {
                self.truncate(slot, limits);
            }
            if let Some(speed) = joint.max_speed {
                self.truncate(MOST_JOINTS + slot, [-speed, speed]);
            }
        }
    }

    fn truncate(&mut self, place: usize, limits: [f64; 2]) {
        let Some(joints) = &mut self.joints else {
            return;
        };
        let variance = joints.own[(place, place)];
        let mean = match place.checked_sub(MOST_JOINTS) {
            None => joints.values[place],
            Some(slot) => joints.speeds[slot],
        };
        let truncated = Truncated::of(mean, variance, limits);
        let pull = (truncated.mean - mean) / variance;
        let narrowing = (truncated.variance - variance) / (variance * variance);
        if !(pull.is_finite() && narrowing.is_finite()) {
            return;
        }
        let with_motion = joints.cross.column(place).into_owned();
        let own: SVector<f64, WIDTH> = joints.own.column(place).into_owned();
        joints.shift(&(own * pull));
        joints.cross += with_motion * own.transpose() * narrowing;
        joints.own = symmetric(&(joints.own + own * own.transpose() * narrowing));
        let step = with_motion * pull;
        self.covariance += with_motion * with_motion.transpose() * narrowing;
        self.pose = se3::perturb(&self.pose, &step.fixed_rows::<6>(0).into_owned());
        self.twist += step.fixed_rows::<6>(6);
    }
}

/// Moments of a Gaussian within limits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Truncated {
    mean: f64,
    variance: f64,
}

impl Truncated {
    /// By quadrature relative to the density's peak between the limits, which no distance makes vanish.
    fn of(mean: f64, variance: f64, [lowest, highest]: [f64; 2]) -> Self {
        let sigma = variance.max(0.0).sqrt();
        let inside = lowest < mean - FAR * sigma && mean + FAR * sigma < highest;
        if inside || sigma == 0.0 {
            let mean = mean.clamp(lowest, highest);
            return Self { mean, variance };
        }
        let peak = mean.clamp(lowest, highest);
        let beyond = (mean - peak).abs();
        // Beyond the limits the density falls off like an exponential.
        let reach = FAR * sigma.min(4.0 * variance / beyond.max(f64::MIN_POSITIVE));
        let (from, to) = (lowest.max(peak - reach), highest.min(peak + reach));
        let mut sums = [0.0; 3];
        for index in 0..=INTERVALS {
            let at = (to - from) * index as f64 / INTERVALS as f64 + from - peak;
            let weight = match index {
                0 | INTERVALS => 1.0,
                _ if index % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let density = weight * (-0.5 * at * (at + 2.0 * (peak - mean)) / variance).exp();
            sums = [
                sums[0] + density,
                sums[1] + density * at,
                sums[2] + density * at * at,
            ];
        }
        let off = sums[1] / sums[0];
        Self {
            mean: (peak + off).clamp(lowest, highest),
            variance: (sums[2] / sums[0] - off * off).clamp(0.0, variance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-4
    }

    #[test]
    fn half_a_gaussian_has_the_moments_of_the_books() {
        let half = Truncated::of(1.0, 4.0, [1.0, 100.0]);
        let mean = (2.0 / std::f64::consts::PI).sqrt();
        assert!(close(half.mean, 1.0 + 2.0 * mean), "{half:?}");
        assert!(close(half.variance, 4.0 * (1.0 - mean * mean)), "{half:?}");
    }

    #[test]
    fn a_vague_one_lies_anywhere_between_the_limits() {
        let uniform = Truncated::of(0.3, 1e8, [-1.0, 2.0]);
        assert!(
            close(uniform.mean, 0.5) && close(uniform.variance, 0.75),
            "{uniform:?}"
        );
    }

    #[test]
    fn one_far_outside_lies_just_within() {
        for mean in [3.0, 30.0, 3e6] {
            let outside = Truncated::of(mean, 0.01, [-1.0, 1.0]);
            // Almost an exponential of the rate distance / variance.
            let scale = 0.01 / (mean - 1.0);
            assert!(
                outside.mean <= 1.0 && outside.mean > 1.0 - 1.1 * scale,
                "{outside:?}"
            );
            assert!(outside.variance.sqrt() < 1.1 * scale, "{outside:?}");
        }
    }

    #[test]
    fn one_far_inside_stays_as_it_is() {
        let inside = Truncated::of(0.2, 1e-4, [-1.0, 1.0]);
        assert_eq!((inside.mean, inside.variance), (0.2, 1e-4));
    }
}
