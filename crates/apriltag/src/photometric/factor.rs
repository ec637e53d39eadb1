//! Symmetric positive matrices as products of a lower one with its transpose (Cholesky).

use super::lanes::{LANES, Lanes};
use super::normal_equations::{Matrix, PARAMETERS, Vector};

/// Cholesky factor of a matrix scaled to a unit diagonal, and the scales.
pub(super) struct Factor {
    /// Columns of the lower factor, without the diagonal.
    columns: Matrix,
    /// Rows of it.
    rows: Matrix,
    /// Reciprocals of the diagonal.
    pivots: Vector,
    scales: Vector,
}

impl Factor {
    /// Of a symmetric matrix given by its lower half.
    #[inline(always)]
    pub(super) fn of(matrix: &Matrix) -> Option<Self> {
        const LEAST_PIVOT: f32 = 1e-6;
        let scales: Vector = std::array::from_fn(|i| 1.0 / matrix[i][i].sqrt());
        let mut rest = *matrix;
        for (row, scale) in rest.iter_mut().zip(scales) {
            for (value, other) in row.iter_mut().zip(scales) {
                *value *= scale * other;
            }
        }
        let mut columns = [[0.0; PARAMETERS]; PARAMETERS];
        let mut pivots = [0.0; PARAMETERS];
        for j in 0..PARAMETERS {
            pivots[j] = 1.0 / rest[j][j].max(LEAST_PIVOT).sqrt();
            for i in j + 1..PARAMETERS {
                columns[j][i] = rest[i][j] * pivots[j];
            }
            for i in j + 1..PARAMETERS {
                let factor = columns[j][i];
                subtract(&mut rest[i], factor, &columns[j]);
            }
        }
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        pivots
            .iter()
            .chain(&scales)
            .all(|value| value.is_finite())
            .then_some(Self {
                columns,
                rows,
                pivots,
                scales,
            })
    }

    /// L^-1 b.
    #[inline(always)]
    pub(super) fn whiten(&self, right: &Vector) -> Vector {
        whiten(
            std::array::from_fn(|i| right[i] * self.scales[i]),
            &self.columns,
            &self.pivots,
            PARAMETERS,
        )
    }

    /// (L L^T)^-1 b.
    #[inline(always)]
    pub(super) fn solve(&self, right: &Vector) -> Vector {
        let mut x = self.whiten(right);
        for i in (0..PARAMETERS).rev() {
            let value = x[i] * self.pivots[i];
            subtract(&mut x, value, &self.rows[i]);
            x[i] = value;
        }
        std::array::from_fn(|i| x[i] * self.scales[i])
    }
}

impl Factor {
    /// Adds |L^-1 b|^2 for the vectors b that are given lane by lane.
    #[inline(always)]
    pub(super) fn add_whitened_squares(&self, mut x: [Lanes; PARAMETERS], squares: &mut Lanes) {
        for i in 0..PARAMETERS {
            let (scale, pivot) = (self.scales[i], self.pivots[i]);
            let mut value = x[i];
            for lane in 0..LANES {
                value[lane] *= scale;
            }
            for j in 0..i {
                let element = self.rows[i][j];
                for lane in 0..LANES {
                    value[lane] -= element * x[j][lane];
                }
            }
            for lane in 0..LANES {
                value[lane] *= pivot;
                squares[lane] += value[lane] * value[lane];
            }
            x[i] = value;
        }
    }
}

/// The first `n` elements of L^-1 x.
#[inline(always)]
fn whiten(mut x: Vector, columns: &Matrix, pivots: &Vector, n: usize) -> Vector {
    for i in 0..n {
        x[i] *= pivots[i];
        let value = x[i];
        subtract(&mut x, value, &columns[i]);
    }
    x
}

/// x - factor * column
#[inline(always)]
fn subtract(x: &mut Vector, factor: f32, column: &Vector) {
    for (value, element) in x.iter_mut().zip(column) {
        *value -= factor * element;
    }
}
