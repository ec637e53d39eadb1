//! How strongly objects accelerate, learned from the keyframes whose motion is sought with the pose, as
//! [`variance_components`] learn the scales of the site's errors. A prior that is much wider than what objects do would
//! explain by motion what cameras contradict in one another, and files that are off would pass for exact.
//!
//! [`variance_components`]: crate::self_calibration::variance_components

use crate::self_calibration::keyframes::{Keyframes, Path};
use crate::self_calibration::normal_equations::Eliminated;

/// Prior standard deviation of an acceleration, m/s² and rad/s².
const PRIOR_SIGMA: [f64; 2] = [10.0, 50.0];
/// Number of observed accelerations that the prior counts for.
const PRIOR_WEIGHT: f64 = 1.0;
/// Bounds of the estimate as multiples of the prior.
const BOUNDS: (f64, f64) = (0.03, 3.0);

/// Standard deviations of the accelerations of objects, m/s² and rad/s², of each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Accelerations([f64; 2]);

impl Default for Accelerations {
    fn default() -> Self {
        Self(PRIOR_SIGMA)
    }
}

impl Accelerations {
    /// Inverse variance of an axis.
    pub fn precision(&self, axis: usize) -> f64 {
        self.0[axis / 3].powi(-2)
    }

    /// Squared Mahalanobis distance of a path's accelerations from zero.
    pub fn squared_distance(&self, path: &Path) -> f64 {
        let axes = path.acceleration.iter().enumerate();
        axes.map(|(axis, one)| self.precision(axis) * one * one)
            .sum()
    }

    /// One step of the fixed point, by the paths and their posterior variances.
    pub(super) fn updated(&self, keyframes: &Keyframes, eliminated: &[Eliminated]) -> Self {
        let (mut squares, mut determined) = ([0.0; 2], [0.0; 2]);
        for (keyframe, own) in keyframes.iter().zip(eliminated) {
            let Some(path) = &keyframe.path else {
                continue;
            };
            for axis in 0..6 {
                let posterior = own.variance(12 + axis) * self.precision(axis);
                determined[axis / 3] += (1.0 - posterior).clamp(0.0, 1.0);
                squares[axis / 3] += path.acceleration[axis].powi(2);
            }
        }
        Self(std::array::from_fn(|part| {
            let square = squares[part] + PRIOR_WEIGHT * PRIOR_SIGMA[part].powi(2);
            let sigma = (square / (determined[part] + PRIOR_WEIGHT)).sqrt();
            sigma.clamp(BOUNDS.0 * PRIOR_SIGMA[part], BOUNDS.1 * PRIOR_SIGMA[part])
        }))
    }
}
