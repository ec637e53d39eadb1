//! How strongly objects accelerate, learned from the keyframes whose motion is sought with the pose, as [`variance_components`] learn the scales
//! of the site's errors. A prior that is much wider than what objects do would explain by motion what cameras contradict in one another, and
//! files that are off would pass for exact.
//!
//! [`variance_components`]: crate::self_calibration::variance_components

use crate::self_calibration::keyframes::{Keyframes, Path};
use crate::self_calibration::normal_equations::Eliminated;

/// Before anything is known, m/s² and rad/s².
const USUAL: [f64; 2] = [10.0, 50.0];
/// Accelerations as which that counts.
const OF_USUAL: f64 = 1.0;
/// Bounds as shares of that.
const BOUNDS: (f64, f64) = (0.03, 3.0);

/// Standard deviations of the accelerations of objects, m/s² and rad/s², of each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Accelerations([f64; 2]);

impl Default for Accelerations {
    fn default() -> Self {
        Self(USUAL)
    }
}

impl Accelerations {
    /// Inverse variance of an axis.
    pub fn precision(&self, axis: usize) -> f64 {
        self.0[axis / 3].powi(-2)
    }

    /// Square of a path's accelerations in these units.
    pub fn improbability(&self, path: &Path) -> f64 {
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
            let square = squares[part] + OF_USUAL * USUAL[part].powi(2);
            let sigma = (square / (determined[part] + OF_USUAL)).sqrt();
            sigma.clamp(BOUNDS.0 * USUAL[part], BOUNDS.1 * USUAL[part])
        }))
    }
}
