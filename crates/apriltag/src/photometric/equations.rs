//! Weighted least squares by its normal equations, in whole numbers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: exact sums, the same in any order and on
//! any processor, by vector instructions that all of them have. What rounding changes in the derivatives leaves the estimate
//! where it is, as sums of residuals times anything but themselves are zero on average where the model holds.

use super::SHIFT;
use super::state::{BLACK, HOMOGRAPHY, PARAMETERS, Vector, WHITE};
use crate::kernels::{AT_A_TIME, COLUMNS, Column, MAX_GROUPS, ROWS, Sums, WIDTH, products};

/// The column of the residuals; those of the derivatives come after it.
const RESIDUALS: usize = 0;

/// Pixels that are worked on together.
pub(super) const GROUP: usize = ROWS;

/// What derivatives of 1 are in the columns.
pub(super) const UNIT: f32 = 256.0;

/// What residuals as large as the limit are.
pub(super) const RESIDUAL: f32 = 2048.0;

/// A pixel's residual and derivatives.
pub(super) type Row = [f32; COLUMNS];

#[derive(Debug)]
pub(super) struct Equations {
    columns: Box<[Column; COLUMNS]>,
    n_groups: usize,
    /// Room for a group, before it is rounded.
    rows: [[f32; GROUP]; COLUMNS],
    products: Sums,
    /// Of each of the normal equations its right side and then what stands up to the diagonal; what stands after it is nothing.
    /// When solved, a triangle T with the diagonal D: of what is left of them for the first parameters when all else is
    /// eliminated, T^T D^-1 T is the matrix.
    system: [[f32; WIDTH]; PARAMETERS],
    /// Limit of the residuals, as a part of the contrast.
    limit: f32,
    /// Variance of the residuals, in parts of the contrast squared, and what the step that solves the equations should leave of it.
    pub(super) variance: f32,
    pub(super) variance_left: f32,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            columns: Box::new([[[0; GROUP]; MAX_GROUPS]; COLUMNS]),
            n_groups: 0,
            rows: [[0.0; GROUP]; COLUMNS],
            products: [[0; WIDTH]; COLUMNS],
            system: [[0.0; WIDTH]; PARAMETERS],
            limit: 1.0,
            variance: 0.0,
            variance_left: 0.0,
        }
    }
}

impl Equations {
    pub(super) fn clear(&mut self, limit: f32) {
        self.n_groups = 0;
        self.limit = limit;
    }

    /// Adds a group, rounded.
    #[inline(always)]
    pub(super) fn add(&mut self, row: impl Fn(usize) -> Row) {
        for i in 0..GROUP {
            let row = row(i);
            for k in 0..COLUMNS {
                self.rows[k][i] = row[k] + SHIFT;
            }
        }
        if self.n_groups < MAX_GROUPS {
            for k in 0..COLUMNS {
                for i in 0..GROUP {
                    self.columns[k][self.n_groups][i] = self.rows[k][i].to_bits() as i16;
                }
            }
            self.n_groups += 1;
        }
    }

    /// Adds everything up, for as many parameters; pixels tell nothing of those after them.
    pub(super) fn finish(&mut self, n_parameters: usize) {
        let end = self.n_groups.next_multiple_of(AT_A_TIME);
        for column in self.columns.iter_mut() {
            column[self.n_groups..end].fill([0; GROUP]);
        }
        self.products[1 + n_parameters..].fill([0; WIDTH]);
        products(&self.columns[..1 + n_parameters], end, &mut self.products);
    }

    /// The Gauss-Newton step, with what is known of the last parameters beforehand.
    #[inline(always)]
    pub(super) fn solve<const N: usize>(&mut self, priors: &[[f32; 2]; N]) -> Vector {
        let freedom = (self.weight() - PARAMETERS as f32).max(1.0);
        let per_square = (self.limit / RESIDUAL).powi(2) / freedom;
        self.variance = self.products[RESIDUALS][RESIDUALS] as f32 * per_square;
        let variance = self.variance;
        for (row, products) in self.system.iter_mut().zip(&self.products[1..]) {
            for (value, product) in row.iter_mut().zip(products) {
                *value = *product as f32 * (1.0 / (UNIT * UNIT));
            }
            row[0] *= self.limit * UNIT / RESIDUAL;
        }
        for (i, [away, spread]) in (PARAMETERS - N..).zip(priors) {
            let strength = variance / (spread * spread);
            self.system[i][1 + i] += strength;
            self.system[i][0] += strength * away;
        }
        let sides: Vector = std::array::from_fn(|i| self.system[i][0]);
        let step = self.eliminate();
        let explained: f32 = sides.iter().zip(&step).map(|(a, b)| a * b).sum();
        self.variance_left = (variance - explained / freedom).max(0.0);
        step
    }

    /// Takes each row, from the last one on, off those before it; returns the solution. Of a symmetric matrix the numbers up to
    /// the diagonal are enough.
    #[inline(always)]
    fn eliminate(&mut self) -> Vector {
        const LEAST_PIVOT: f32 = 1e-6;
        let diagonal: Vector = std::array::from_fn(|i| self.system[i][1 + i]);
        for k in (0..PARAMETERS).rev() {
            self.system[k][1 + k] = self.system[k][1 + k].max(LEAST_PIVOT * diagonal[k]);
            let row = self.system[k];
            let per_pivot = 1.0 / row[1 + k];
            for (other, value) in self.system[..k].iter_mut().zip(&row[1..]) {
                let factor = value * per_pivot;
                for (value, pivot) in other.iter_mut().zip(&row) {
                    *value -= factor * pivot;
                }
            }
        }
        let mut solution = [0.0; PARAMETERS];
        for (k, row) in self.system.iter().enumerate() {
            let known = row[1..=k].iter().zip(&solution).map(|(a, b)| a * b);
            solution[k] = (row[0] - known.sum::<f32>()) / row[1 + k];
        }
        solution
    }

    /// D^(1/2) T^-T j: products of what this makes of two rows are the covariance of what they take from the homography.
    pub(super) fn whiten(&self, mut row: [f32; HOMOGRAPHY]) -> [f32; HOMOGRAPHY] {
        for (k, [_, triangle @ ..]) in self.system[..HOMOGRAPHY].iter().enumerate().rev() {
            let share = row[k] / triangle[k];
            for j in 0..k {
                row[j] -= share * triangle[j];
            }
            row[k] = share * triangle[k].sqrt();
        }
        row
    }

    /// Sum of the pixels' weights: to black and white together, each pixel's derivative is the root of its own.
    fn weight(&self) -> f32 {
        let product = |i: usize, j: usize| self.products[1 + i][1 + j] as f32;
        let square = product(BLACK, BLACK) + 2.0 * product(WHITE, BLACK) + product(WHITE, WHITE);
        square / (UNIT * UNIT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(right: usize) -> [[f32; WIDTH]; PARAMETERS] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match j {
                0 => f32::from(i == right),
                _ => {
                    let (i, j) = (i as f32, j as f32 - 1.0);
                    (1.0 + i) * (1.0 + j) * (-0.7 * (i - j).abs()).exp()
                }
            })
        })
    }

    #[test]
    fn steps_solve_the_equations_and_show_the_covariance() {
        for right in 0..HOMOGRAPHY {
            let mut equations = Equations {
                system: system(right),
                ..Equations::default()
            };
            let step = equations.eliminate();
            let unit = |k: usize| equations.whiten(std::array::from_fn(|i| f32::from(i == k)));
            for (i, row) in system(right).iter().enumerate() {
                let sum: f32 = row[1..].iter().zip(&step).map(|(a, b)| a * b).sum();
                assert!((sum - f32::from(i == right)).abs() < 1e-3, "{i}: {sum}");
            }
            for k in 0..HOMOGRAPHY {
                let products = unit(k).into_iter().zip(unit(right)).map(|(a, b)| a * b);
                let covariance: f32 = products.sum();
                assert!((covariance - step[k]).abs() < 1e-3 * step[right]);
            }
        }
    }
}
