//! Likelihood ratios of faults: how much better a window is explained if some errors may be larger than they are known to be.
//!
//! With the information N and the gradient g of the errors, the precision L of what is known of them, A = N + L, C = A^-1 and x = -C g, the
//! half square that the errors explain is -g' x / 2. If the precisions of some of them change by D, C becomes C - C_h S C_h' and the
//! explained half square grows by -x_h' S x_h / 2 with S = (D^-1 + C_hh)^-1 (Woodbury): the logarithm of the generalised likelihood ratio
//! (Basseville, Nikiforov 1993, Detection of abrupt changes, sec. 7.2.4).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

/// A window's equations solved with what is known of the errors.
pub(crate) struct LikelihoodRatio {
    /// Covariance of the errors.
    covariance: DMatrix<f64>,
    /// The likeliest errors.
    errors: DVector<f64>,
    precision: DVector<f64>,
    /// Half the squares that they explain.
    pub explained: f64,
}

/// What larger errors explain.
pub(crate) struct Gain {
    /// Logarithm of the likelihood ratio.
    pub odds: f64,
    /// The likeliest errors.
    pub parameters: DVector<f64>,
}

impl LikelihoodRatio {
    /// `None` where numbers end.
    pub fn new(
        information: &DMatrix<f64>,
        gradient: &DVector<f64>,
        precision: DVector<f64>,
    ) -> Option<Self> {
        let factor = (information + DMatrix::from_diagonal(&precision)).cholesky()?;
        let errors = -factor.solve(gradient);
        Some(Self {
            explained: -0.5 * gradient.dot(&errors),
            covariance: factor.inverse(),
            errors,
            precision,
        })
    }

    /// What the errors at some places explain more with prior standard deviations `sigmas` in place of the known ones; `None` where
    /// numbers end.
    pub fn gain(&self, places: Range<usize>, sigmas: &[f64]) -> Option<Gain> {
        let (first, width) = (places.start, places.len());
        let own = self.errors.rows(first, width);
        let covariance = self.covariance.view((first, first), (width, width));
        let mut system = covariance.into_owned();
        for (at, sigma) in sigmas.iter().enumerate() {
            let change = sigma.powi(-2) - self.precision[first + at];
            system[(at, at)] += change.recip();
        }
        let solved = system.lu().solve(&own)?;
        let odds = -0.5 * own.dot(&solved);
        let parameters = own - covariance * solved;
        let is_finite = odds.is_finite() && parameters.iter().all(|x| x.is_finite());
        is_finite.then_some(Gain { odds, parameters })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gain_is_that_of_solving_anew() {
        let root = DMatrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j) % 7) as f64 - 2.5);
        let information = &root * root.transpose();
        let gradient = DVector::from_vec(vec![1.0, -2.0, 0.5, 3.0]);
        let known = DVector::from_element(4, 1e4);
        let mut free = known.clone();
        (free[1], free[2]) = (0.01, 0.01);
        let solve = |precision| LikelihoodRatio::new(&information, &gradient, precision);
        let (before, after) = (solve(known).unwrap(), solve(free).unwrap());
        let gain = before.gain(1..3, &[10.0, 10.0]).unwrap();
        let expected = after.explained - before.explained;
        assert!((gain.odds - expected).abs() < 1e-6 * expected);
        assert!((gain.parameters - after.errors.rows(1, 2)).amax() < 1e-6);
    }
}
