//! Variance components: the scale of the errors of each class against their priors, by type-II maximum likelihood.
//!
//! With x the errors, L0 their prior precision at scale one and C their posterior covariance at scale s, the images
//! determine g = n - tr(L0 C) / s^2 of a class's n errors, and s^2 = x' L0 x / g is the fixed point (MacKay 1992,
//! Bayesian interpolation, eq. 4.8). A class of which the images determine little follows the others: tags placed to
//! hundredths of a millimetre come with calibrated lenses.

use nalgebra::DVector;

use crate::self_calibration::parameters::{CLASSES, Class, ParameterLayout};

/// Errors as which the scale of all classes counts for the scale of one.
const OF_OTHERS: f64 = 0.2;
/// Errors as which a log-uniform prior of the scale counts where the images determine some: what they cannot tell from
/// nothing is nothing.
const OF_EXACTNESS: f64 = 1.0;
/// Errors as which the priors' own scale counts for that of all.
const OF_PRIOR: f64 = 1.0;
/// Bounds of a scale: below, an error is nothing; above, it is a blunder and not an imperfection.
const BOUNDS: (f64, f64) = (1e-4, 30.0);

/// A scale on the prior sigmas for each class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales(pub [f64; CLASSES.len()]);

impl Default for Scales {
    fn default() -> Self {
        Self([1.0; CLASSES.len()])
    }
}

impl Scales {
    /// One step of the fixed point, by the errors and their posterior variances.
    pub fn updated(
        &self,
        layout: &ParameterLayout,
        errors: &DVector<f64>,
        variances: &DVector<f64>,
    ) -> Self {
        let mut determined = [0.0; CLASSES.len()];
        let mut squares = [0.0; CLASSES.len()];
        for (index, class) in CLASSES.iter().enumerate() {
            // That one print is larger says nothing of other prints.
            for at in layout.places(*class).filter(|_| *class != Class::Scale) {
                let prior = layout.sigmas[at].powi(2);
                let posterior = variances[at] / (prior * self.0[index].powi(2));
                determined[index] += (1.0 - posterior).clamp(0.0, 1.0);
                squares[index] += errors[at].powi(2) / prior;
            }
        }
        let logarithms = self.0.iter().zip(&determined);
        let sum: f64 = logarithms.map(|(scale, weight)| weight * scale.ln()).sum();
        let common = (sum / (determined.iter().sum::<f64>() + OF_PRIOR)).exp();
        Self(std::array::from_fn(|index| {
            if CLASSES[index] == Class::Scale {
                return 1.0;
            }
            let square = squares[index] + OF_OTHERS * common.powi(2);
            let exactness = OF_EXACTNESS * determined[index] / (1.0 + determined[index]);
            let scale = (square / (determined[index] + OF_OTHERS + exactness)).sqrt();
            scale.clamp(BOUNDS.0, BOUNDS.1)
        }))
    }
}
