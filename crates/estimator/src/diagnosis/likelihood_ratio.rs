//! Likelihood ratios of faults: how much better a window is explained if some errors may be larger than they are known
//! to be.
//!
//! With the information N and the gradient g of the errors, the precision L of what is known of them, A = N + L and x =
//! -A^-1 g, the half square that the errors explain is -g' x / 2. A fault adds V p to the errors, the columns of V
//! telling which errors a parameter moves, with a prior of its own, of precision S. Its score is V' L x, its
//! information V' (L - L A^-1 L) V, and with the prior the explained half square grows by score' (information + S)^-1
//! score / 2: the logarithm of the generalised likelihood ratio (Basseville, Nikiforov 1993, Detection of abrupt
//! changes, sec. 7.2.4).

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

    /// What a fault explains more whose parameters move the errors at these places, each with a prior standard
    /// deviation; `None` where numbers end.
    pub fn gain(&self, moved: &[Vec<usize>], sigmas: &[f64]) -> Option<Gain> {
        let score_at = |at: usize| self.precision[at] * self.errors[at];
        let score = moved
            .iter()
            .map(|places| places.iter().map(|at| score_at(*at)).sum());
        let score = DVector::from_iterator(moved.len(), score);
        let pair = |a: usize, b: usize| {
            let own = if a == b { self.precision[a] } else { 0.0 };
            own - self.precision[a] * self.covariance[(a, b)] * self.precision[b]
        };
        let information = DMatrix::from_fn(moved.len(), moved.len(), |row, column| {
            let by_row = |a: &usize| moved[column].iter().map(|b| pair(*a, *b)).sum::<f64>();
            let prior = if row == column {
                sigmas[row].powi(-2)
            } else {
                0.0
            };
            prior + moved[row].iter().map(by_row).sum::<f64>()
        });
        let parameters = information.cholesky()?.solve(&score);
        let odds = 0.5 * score.dot(&parameters);
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
        // The variances of the known errors and of the fault add up.
        (free[1], free[2]) = (1.0 / 100.0001, 1.0 / 100.0001);
        let solve = |precision| LikelihoodRatio::new(&information, &gradient, precision);
        let (before, after) = (solve(known).unwrap(), solve(free).unwrap());
        let gain = before.gain(&[vec![1], vec![2]], &[10.0, 10.0]).unwrap();
        let expected = after.explained - before.explained;
        assert!((gain.odds - expected).abs() < 1e-6 * expected);
        let moved = after.errors.rows(1, 2) - gain.parameters;
        assert!(moved.amax() < 1e-3);
    }
}
