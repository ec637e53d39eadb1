//! Weighted least squares by normal equations, in integers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: the sums are exact, independent of
//! order and processor, and use vector instructions that all processors have. Rounding of the derivatives does not bias
//! the estimate, since sums of residuals times anything independent of them are zero on average where the model holds.

use super::SHIFT;
use super::parameters::{BLACK, HOMOGRAPHY, PARAMETERS, Vector, WHITE};
use super::pattern::{GROUP, LINES};
use crate::kernels::{COLUMNS, Column, MAX_GROUPS, Sums, WIDTH, dot, products};

/// Column of the residuals; those of the derivatives follow.
const RESIDUALS: usize = 0;

/// Fixed-point value of a derivative of 1.
pub(super) const UNIT: f32 = 256.0;

/// Fixed-point value of a residual at the limit.
pub(super) const RESIDUAL: f32 = 2048.0;

/// A pixel's residual, derivatives and line.
pub(super) type Row = [f32; COLUMNS + 1];

#[derive(Debug)]
pub(super) struct PixelEquations {
    columns: Box<[Column; COLUMNS]>,
    /// The line of the pattern to which each pixel belongs.
    lines: Box<Column>,
    n_groups: usize,
    /// Buffer for a group before rounding.
    rows: [[f32; GROUP]; COLUMNS + 1],
    products: Sums,
    /// Each normal equation: its right side, then its coefficients up to the diagonal; the rest is unused.
    /// Once solved, a triangle T with the diagonal D: the matrix of the first parameters, with all others eliminated,
    /// is T^T D^-1 T.
    system: [[f32; WIDTH]; PARAMETERS],
    /// Limit of the residuals, as a share of the contrast.
    limit: f32,
}

impl Default for PixelEquations {
    fn default() -> Self {
        Self {
            columns: Box::new([[[0; GROUP]; MAX_GROUPS]; COLUMNS]),
            lines: Box::new([[0; GROUP]; MAX_GROUPS]),
            n_groups: 0,
            rows: [[0.0; GROUP]; COLUMNS + 1],
            products: [[0; WIDTH]; COLUMNS],
            system: [[0.0; WIDTH]; PARAMETERS],
            limit: 1.0,
        }
    }
}

impl PixelEquations {
    pub(super) fn clear(&mut self, limit: f32) {
        self.n_groups = 0;
        self.limit = limit;
    }

    /// Adds a group, rounded.
    #[inline(always)]
    pub(super) fn add(&mut self, row: impl Fn(usize) -> Row) {
        for i in 0..GROUP {
            let row = row(i);
            for k in 0..COLUMNS + 1 {
                self.rows[k][i] = row[k] + SHIFT;
            }
        }
        if self.n_groups < MAX_GROUPS {
            for k in 0..COLUMNS {
                for i in 0..GROUP {
                    self.columns[k][self.n_groups][i] = self.rows[k][i].to_bits() as i16;
                }
            }
            for i in 0..GROUP {
                self.lines[self.n_groups][i] = self.rows[COLUMNS][i].to_bits() as i16;
            }
            self.n_groups += 1;
        }
    }

    /// Sums up all products for this many parameters; pixels carry no information about later ones.
    pub(super) fn finish(&mut self, n_parameters: usize) {
        self.products[1 + n_parameters..].fill([0; WIDTH]);
        let columns = &self.columns[..1 + n_parameters];
        products(columns, self.n_groups, &mut self.products);
    }

    /// The Gauss-Newton step, with priors for the last parameters.
    #[inline(always)]
    pub(super) fn solve<const N: usize>(&mut self, priors: &[[f32; 2]; N]) -> Vector {
        let variance = self.residual_variance();
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
        self.eliminate()
    }

    /// Eliminates each row, from the last one on, from those before it; returns the solution. The matrix is symmetric,
    /// so its lower triangle is enough.
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

    /// D^(1/2) T^-T j: products of two such rows are the covariance of what they compute from the homography.
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

    /// Sum of the pixels' weights: with respect to black and white together, the derivative of each pixel is the root
    /// of its weight.
    fn weight(&self) -> f32 {
        let product = |i: usize, j: usize| self.products[1 + i][1 + j] as f32;
        let square = product(BLACK, BLACK) + 2.0 * product(WHITE, BLACK) + product(WHITE, WHITE);
        square / (UNIT * UNIT)
    }

    /// Variance of the residuals, in squared shares of the contrast.
    pub(super) fn residual_variance(&self) -> f32 {
        let squares = self.products[RESIDUALS][RESIDUALS] as f32;
        let freedom = (self.weight() - PARAMETERS as f32).max(1.0);
        squares * (self.limit / RESIDUAL).powi(2) / freedom
    }

    /// Updates the residuals to first order after a step.
    #[inline(always)]
    pub(super) fn take_step(&mut self, step: &Vector) {
        const BITS: i32 = 8;
        let scale = (1 << BITS) as f32 * RESIDUAL / (UNIT * self.limit);
        let (residuals, derivatives) = self.columns.split_at_mut(1);
        let residuals = &mut residuals[0][..self.n_groups];
        let mut changes = [[0_i32; GROUP]; MAX_GROUPS];
        let changes = changes[..self.n_groups].as_flattened_mut();
        for (derivatives, change) in derivatives.iter().zip(step) {
            let factor = (change * scale) as i32;
            // Parameters that no pixel depends on.
            if factor == 0 {
                continue;
            }
            for (sum, derivative) in changes.iter_mut().zip(derivatives.as_flattened()) {
                *sum = sum.wrapping_add(factor.wrapping_mul(i32::from(*derivative)));
            }
        }
        for (residual, change) in residuals.as_flattened_mut().iter_mut().zip(changes) {
            *residual = residual.wrapping_sub((*change >> BITS) as i16);
        }
        self.products[RESIDUALS][RESIDUALS] = dot(residuals, residuals);
    }

    /// Factor by which the parameters' variance exceeds that of uncorrelated residuals. Errors in the model of optics,
    /// print and light move the edges along a line of the pattern together, so each line counts as one observation: the
    /// scatter of the lines' scores J^T W r with respect to the position of the square over that of uncorrelated
    /// residuals (a cluster-robust covariance: Liang & Zeger, Biometrika 73, 1986), times the squared ratio of J^T W J
    /// to the actual change of the scores with the parameters, since weights change as well (Huber, Robust Statistics,
    /// 1981, 6.6).
    #[inline(always)]
    pub(super) fn excess(&self) -> f32 {
        /// Share of the scatter of the lines' scores that remains after fitting: one minus the leverage,
        /// 0.48 +- 0.04 over rendered images.
        const LEFT: f32 = 0.48;
        let (mut pulls, mut information) = ([0_i32; LINES], [0_i32; GROUP]);
        for group in 0..self.n_groups {
            let [x, y, residuals] = [3, 6, RESIDUALS].map(|k| &self.columns[k][group]);
            let mut pull = [0; GROUP];
            for i in 0..GROUP {
                let steepness = i32::from(x[i].wrapping_abs().wrapping_add(y[i].wrapping_abs()));
                information[i] = information[i].wrapping_add(steepness * steepness);
                pull[i] = steepness * i32::from(residuals[i]);
            }
            for (line, pull) in self.lines[group].iter().zip(pull) {
                let sum = &mut pulls[*line as usize % LINES];
                *sum = sum.wrapping_add(pull);
            }
        }
        let information = information.into_iter().fold(0, i32::wrapping_add);
        let scatter: f32 = pulls.iter().map(|pull| (*pull as f32).powi(2)).sum();
        let variance = self.residual_variance() / (self.limit * self.limit);
        let togetherness = scatter / (LEFT * information as f32 * variance * RESIDUAL * RESIDUAL);
        // For the biweight: 1 - 2 x to first order, with 1 - 6 x for the slope of its scores.
        let flattening = 1.0 / (1.0 - 5.0 * variance).max(0.3);
        (togetherness * flattening.powi(2)).max(1.0)
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
            let mut equations = PixelEquations {
                system: system(right),
                ..PixelEquations::default()
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

    #[test]
    fn residuals_after_a_step_are_less_what_the_step_explains() {
        let mut equations = PixelEquations::default();
        equations.clear(1.0);
        let derivative = |i: usize, k: usize| ((i * 7 + k * 5) % 11) as f32 - 5.0;
        for group in 0..4 {
            equations.add(|i| {
                let i = group * GROUP + i;
                let mut row: Row = std::array::from_fn(|k| UNIT / 8.0 * derivative(i, k));
                row[RESIDUALS] = RESIDUAL / 8.0 * 0.5 * derivative(i, 1 + 3);
                row
            });
        }
        equations.finish(PARAMETERS);
        let mut step = [0.0; PARAMETERS];
        step[3] = 0.5;
        equations.take_step(&step);
        let residuals = equations.columns[RESIDUALS][..4].as_flattened();
        assert!(residuals.iter().all(|residual| residual.abs() <= 1));
    }
}
