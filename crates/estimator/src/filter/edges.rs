//! The noise of a tag's corners by what its edges may do: shift and turn.
//!
//! Detectors find edges, and corners where they meet, so that the errors of a tag's four corners hang together: where an
//! edge lies is known better than how it is turned (a line fitted along its length: 1 to 3 in variance, whereas corners
//! found one by one give 1 to 1). How much is learned from the residuals, as a factor on the stated variance for either.

use nalgebra::{Cholesky, Matrix2, Point2, SMatrix, SVector, Vector2};

pub(crate) type Matrix8 = SMatrix<f64, 8, 8>;
pub(crate) type Vector8 = SVector<f64, 8>;

/// Variance of the corners' noise against what is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NoiseFactors {
    /// Of the places of edges.
    pub shift: f64,
    /// Of their directions.
    pub turn: f64,
}

impl NoiseFactors {
    /// Of single corners: half of either.
    pub fn of_corner(self) -> f64 {
        0.5 * (self.shift + self.turn)
    }
}

/// The residuals of a tag's corners as shifts and turns of its edges.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EdgeModes {
    /// From residuals (x, y of each corner) to four shifts and four turns in pixels.
    modes: Matrix8,
    /// Upper triangle whose square is the inverse of their covariance as stated.
    whitener: Matrix8,
}

impl EdgeModes {
    /// `covariance` is each corner's as stated; `None` where the corners enclose nothing.
    pub fn new(corners: &[Point2<f64>; 4], covariance: &[Matrix2<f64>; 4]) -> Option<Self> {
        let mut modes = Matrix8::zeros();
        let mut stated = Matrix8::zeros();
        for (edge, covariance) in covariance.iter().enumerate() {
            let (from, to) = (edge, (edge + 1) % 4);
            let along = (corners[to] - corners[from]).try_normalize(1e-9)?;
            let normal = Vector2::new(-along.y, along.x) * std::f64::consts::FRAC_1_SQRT_2;
            for (corner, sign) in [(from, -1.0), (to, 1.0)] {
                let shift = normal.transpose();
                modes
                    .fixed_view_mut::<1, 2>(edge, 2 * corner)
                    .copy_from(&shift);
                modes
                    .fixed_view_mut::<1, 2>(edge + 4, 2 * corner)
                    .copy_from(&(shift * sign));
            }
            stated
                .fixed_view_mut::<2, 2>(2 * edge, 2 * edge)
                .copy_from(covariance);
        }
        let inverse = Cholesky::new(modes * stated * modes.transpose())?.inverse();
        let whitener = Cholesky::new(inverse)?.l().transpose();
        whitener
            .iter()
            .all(|x| x.is_finite())
            .then_some(Self { modes, whitener })
    }

    /// What makes residuals of that noise independent with unit variance: first the shifts, then the turns.
    pub fn whitener(&self, factors: NoiseFactors) -> Matrix8 {
        let mut scaled = self.modes;
        scaled
            .fixed_rows_mut::<4>(0)
            .scale_mut(factors.shift.sqrt().recip());
        scaled
            .fixed_rows_mut::<4>(4)
            .scale_mut(factors.turn.sqrt().recip());
        self.whitener * scaled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> [Point2<f64>; 4] {
        [
            (100.0, 100.0),
            (130.0, 104.0),
            (126.0, 140.0),
            (95.0, 131.0),
        ]
        .map(|(x, y)| Point2::new(x, y))
    }

    fn covariances() -> [Matrix2<f64>; 4] {
        [0.01, 0.02, 0.03, 0.04].map(|v| Matrix2::new(v, 0.2 * v, 0.2 * v, 1.5 * v))
    }

    #[test]
    fn with_factors_of_one_the_noise_is_as_stated() {
        let whitener = EdgeModes::new(&corners(), &covariances())
            .unwrap()
            .whitener(NoiseFactors {
                shift: 1.0,
                turn: 1.0,
            });
        let covariance = (whitener.transpose() * whitener).try_inverse().unwrap();
        for (corner, stated) in covariances().iter().enumerate() {
            let block = covariance.fixed_view::<2, 2>(2 * corner, 2 * corner);
            assert!((block - stated).amax() < 1e-9);
        }
    }

    #[test]
    fn a_shifted_edge_is_no_turn() {
        let modes = EdgeModes::new(&corners(), &[Matrix2::identity(); 4])
            .unwrap()
            .modes;
        let along = (corners()[1] - corners()[0]).normalize();
        let mut residual = Vector8::zeros();
        for corner in [0, 1] {
            residual
                .fixed_rows_mut::<2>(2 * corner)
                .copy_from(&Vector2::new(-along.y, along.x));
        }
        let seen = modes * residual;
        assert!((seen[0] - std::f64::consts::SQRT_2).abs() < 1e-12 && seen[4].abs() < 1e-12);
    }
}
