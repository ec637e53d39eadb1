//! Weighted least squares by its normal equations, in whole numbers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: exact sums, the same in any order and on
//! any processor, by vector instructions that all of them have. What rounding changes in the derivatives leaves the estimate
//! where it is, as sums of residuals times anything but themselves are zero on average where the model holds.

use super::SHIFT;
use super::parameters::{BLACK, HOMOGRAPHY, PARAMETERS, Vector, WHITE};
use super::pattern::{GROUP, LINES};
use crate::kernels::{COLUMNS, Column, MAX_GROUPS, Sums, WIDTH, dot, products};

/// The column of the residuals; those of the derivatives come after it.
const RESIDUALS: usize = 0;

/// What derivatives of 1 are in the columns.
pub(super) const UNIT: f32 = 256.0;

/// What residuals as large as the limit are.
pub(super) const RESIDUAL: f32 = 2048.0;

/// A pixel's residual, derivatives and line.
pub(super) type Row = [f32; COLUMNS + 1];

#[derive(Debug)]
pub(super) struct Equations {
    columns: Box<[Column; COLUMNS]>,
    /// On which of the pattern's lines each pixel is.
    lines: Box<Column>,
    n_groups: usize,
    /// Room for a group, before it is rounded.
    rows: [[f32; GROUP]; COLUMNS + 1],
    products: Sums,
    /// Of each of the normal equations its right side and then what stands up to the diagonal; what stands after it is nothing.
    /// When solved, a triangle T with the diagonal D: of what is left of them for the first parameters when all else is
    /// eliminated, T^T D^-1 T is the matrix.
    system: [[f32; WIDTH]; PARAMETERS],
    /// Limit of the residuals, as a part of the contrast.
    limit: f32,
}

impl Default for Equations {
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

    /// Adds everything up, for as many parameters; pixels tell nothing of those after them.
    pub(super) fn finish(&mut self, n_parameters: usize) {
        self.products[1 + n_parameters..].fill([0; WIDTH]);
        let columns = &self.columns[..1 + n_parameters];
        products(columns, self.n_groups, &mut self.products);
    }

    /// The Gauss-Newton step, with what is known of the last parameters beforehand.
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

    /// Of the residuals, in parts of the contrast squared.
    pub(super) fn residual_variance(&self) -> f32 {
        let squares = self.products[RESIDUALS][RESIDUALS] as f32;
        let freedom = (self.weight() - PARAMETERS as f32).max(1.0);
        squares * (self.limit / RESIDUAL).powi(2) / freedom
    }

    /// Makes the residuals what they are after a step.
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
            // What but one edge at a place does not tell.
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

    /// By how much the parameters' variance is larger than residuals without relation to each other would make it. What the
    /// model does not know of optics, print and light moves the edges along a line of the pattern alike, so each line counts
    /// once: the scatter of the lines' pulls J^T W r on the square's place against that of such residuals (as in a
    /// cluster-robust covariance: Liang & Zeger, Biometrika 73, 1986), times the square of how much less pulls change with the
    /// parameters than J^T W J says, as weights change too (Huber, Robust Statistics, 1981, 6.6).
    #[inline(always)]
    pub(super) fn excess(&self) -> f32 {
        /// Share of the scatter of the lines' pulls that the parameters leave, as they give way to them: one less the leverage,
        /// 0.48 +- 0.04 over drawn pictures.
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
        // Of the biweight, 1 - 2 x to first order, with 1 - 6 x for its pulls' slope.
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

    #[test]
    fn residuals_after_a_step_are_less_what_the_step_explains() {
        let mut equations = Equations::default();
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
