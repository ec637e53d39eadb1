//! Evidence for errors of the files: Laplace's approximation with the information and the errors at the minimum, for
//! other prior precisions than those they were found with.

use nalgebra::DVector;

use crate::self_calibration::arrow::{Arrow, ArrowFactor};
use crate::self_calibration::parameters::{CLASSES, Class, ParameterLayout};

/// Logarithm of the odds beyond which it is decided.
const DECISIVE_ODDS: f64 = 7.0;
/// A scale at which a class has no errors.
pub(crate) const NOTHING: f64 = 1e-3;
/// Files suffice while they leave no more than this many times what the images leave anyway: twice as large residuals.
const SUFFICIENT: f64 = 3.0;

/// Result of an adjustment.
pub(crate) struct Evidence<'a> {
    layout: &'a ParameterLayout,
    errors: &'a DVector<f64>,
    /// Of the views and the priors.
    information: &'a Arrow,
    factor: &'a ArrowFactor,
    /// Of the priors.
    precision: &'a DVector<f64>,
    pull: DVector<f64>,
}

impl<'a> Evidence<'a> {
    pub fn new(
        layout: &'a ParameterLayout,
        errors: &'a DVector<f64>,
        information: &'a Arrow,
        factor: &'a ArrowFactor,
        precision: &'a DVector<f64>,
    ) -> Self {
        Self {
            layout,
            errors,
            information,
            factor,
            precision,
            pull: information.times(errors),
        }
    }

    /// Logarithm of the odds of errors of such precisions against none; `None` where numbers end.
    fn odds(&self, precision: &DVector<f64>) -> Option<f64> {
        let change = precision - self.precision;
        let factor = self.information.factor_changed(self.factor, &change)?;
        let fitted = self.pull.dot(&factor.solve(&self.pull));
        let prior = precision.map(f64::ln).sum();
        Some(0.5 * (fitted - factor.ln_determinant() + prior))
    }

    /// The precisions with those of one class at another scale.
    fn with(&self, class: Class, scale: f64) -> DVector<f64> {
        let mut precision = self.precision.clone();
        let scaled = self.layout.precision(&[scale; CLASSES.len()]);
        for at in self.layout.places(class) {
            precision[at] = scaled[at];
        }
        precision
    }

    /// Whether the files are exact: the evidence for errors as found is not decisive, and that against errors as large
    /// as their priors is.
    pub fn excludes_all(&self) -> bool {
        let usual = self.layout.precision(&[1.0; CLASSES.len()]);
        let found = self.odds(self.precision).is_none_or(is_decisive);
        let excluded = self.odds(&usual).is_some_and(|odds| is_decisive(-odds));
        excluded && !found
    }

    /// The same of one class, whatever is wrong with the others.
    pub fn excludes(&self, class: Class) -> bool {
        let odds = |scale| self.odds(&self.with(class, scale));
        let (Some(found), Some(usual), Some(nothing)) =
            (self.odds(self.precision), odds(1.0), odds(NOTHING))
        else {
            return false;
        };
        is_decisive(nothing - usual) && !is_decisive(found - nothing)
    }

    /// Whether the files leave hardly more than the errors as found do, which leave `left`: what remains is not theirs,
    /// and correcting them would follow it.
    pub fn suffices(&self, left: f64) -> bool {
        // The gradients of the squares and of the prior cancel at the minimum.
        let prior = self.precision.dot(&self.errors.component_mul(self.errors));
        prior + self.errors.dot(&self.pull) <= SUFFICIENT * left
    }
}

fn is_decisive(odds: f64) -> bool {
    odds > DECISIVE_ODDS
}
