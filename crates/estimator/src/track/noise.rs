//! How noisy a camera's corners are, against what was stated: estimated from the residuals that remain after each update.
//!
//! A residual after the update is smaller than the noise by the share of it that the pose took up. With redundancy
//! r = 8 - tr(L P⁺) of a view (Förstner 1979, reliability of blocks) a corner's squared length is about r/8 times a
//! chi-square of two degrees of freedom, and cut off at c its mean is 2a (1 - exp(-c / 2a)) with a = r/8. The cut keeps
//! outliers from passing for noise.

use super::update::Taken;
use crate::FusionOptions;
use crate::filter::corners::SCALE_LIMIT;

/// Degrees of freedom that the stated noise counts as before anything is seen.
const FAITH: f64 = 60.0;
/// Bounds of the factor on the stated standard deviation.
const FACTOR: (f64, f64) = (0.3, 5.0);

/// The noise of one camera's corners, as a factor on what is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CameraNoise {
    chi2: f64,
    redundancy: f64,
}

impl Default for CameraNoise {
    fn default() -> Self {
        Self {
            chi2: FAITH,
            redundancy: FAITH,
        }
    }
}

impl CameraNoise {
    /// Factor on the stated standard deviation.
    pub fn factor(self) -> f64 {
        (self.chi2 / self.redundancy)
            .sqrt()
            .clamp(FACTOR.0, FACTOR.1)
    }

    /// Factor on the stated information.
    pub fn weight(self) -> f64 {
        self.factor().powi(-2)
    }

    /// Takes a view in, whether it took part or was refused: else a noise underestimated at the start would stay so.
    pub fn learn(&mut self, taken: &Taken, options: &FusionOptions) {
        let keep = (1.0 - taken.redundancy / options.noise_memory).clamp(0.0, 1.0);
        let share = taken.redundancy / 8.0;
        let expected = 8.0 * share * (1.0 - (-0.5 * SCALE_LIMIT / share).exp());
        let ratio = taken.scale / expected * self.factor().powi(2);
        self.chi2 = self.chi2 * keep + ratio * taken.redundancy;
        self.redundancy = self.redundancy * keep + taken.redundancy;
    }
}
