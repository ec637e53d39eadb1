//! How noisy a camera's corners are, against what was stated: estimated from the residuals that remain after each update.
//!
//! A residual after the update is smaller than the noise by the share of it that the pose took up. Of the four shifts (or
//! turns) of a view's edges the redundancy r = 4 - tr(L P⁺) is left (Förstner 1979, reliability of blocks); a pair of them
//! is about r/4 times a chi-square of two degrees of freedom, and cut off at c its mean is 2a (1 - exp(-c / 2a)) with
//! a = r/4. The cut keeps outliers from passing for noise.

use super::update::Taken;
use crate::FusionOptions;
use crate::filter::corners::SCALE_LIMIT;
use crate::filter::edges::NoiseFactors;

/// Degrees of freedom that the stated noise counts as before anything is seen.
const FAITH: f64 = 30.0;
/// Bounds of the factors on the stated variance.
const BOUNDS: (f64, f64) = (0.1, 25.0);

/// The noise of one camera's corners.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CameraNoise {
    shift: Variance,
    turn: Variance,
}

/// A factor on a stated variance.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Variance {
    chi2: f64,
    redundancy: f64,
}

impl Default for Variance {
    fn default() -> Self {
        Self {
            chi2: FAITH,
            redundancy: FAITH,
        }
    }
}

impl Variance {
    fn factor(self) -> f64 {
        (self.chi2 / self.redundancy).clamp(BOUNDS.0, BOUNDS.1)
    }

    fn learn(&mut self, scale: f64, redundancy: f64, memory: f64) {
        let keep = (1.0 - redundancy / memory).clamp(0.0, 1.0);
        let share = redundancy / 4.0;
        let expected = 4.0 * share * (1.0 - (-0.5 * SCALE_LIMIT / share).exp());
        let ratio = scale / expected * self.factor();
        self.chi2 = self.chi2 * keep + ratio * redundancy;
        self.redundancy = self.redundancy * keep + redundancy;
    }
}

impl CameraNoise {
    pub fn factors(self) -> NoiseFactors {
        NoiseFactors {
            shift: self.shift.factor(),
            turn: self.turn.factor(),
        }
    }

    /// Takes a view in, whether it took part or was refused: else a noise underestimated at the start would stay so.
    pub fn learn(&mut self, taken: &Taken, options: &FusionOptions) {
        let memory = 0.5 * options.noise_memory;
        self.shift
            .learn(taken.scale[0], taken.redundancy[0], memory);
        self.turn.learn(taken.scale[1], taken.redundancy[1], memory);
    }
}
