//! Weighted least squares by its normal equations, in whole numbers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: exact sums, the same in any order and on
//! any processor, by vector instructions that all of them have. What rounding changes in the derivatives leaves the estimate
//! where it is, as sums of residuals times anything but themselves are zero on average where the model holds.

use crate::kernels::{COLUMNS, Column, Kernels, MAX_GROUPS, ROWS, Sums};

/// Homography 8, black, white, light 2, blur 3, halo, gain.
pub(super) const PARAMETERS: usize = COLUMNS - 2;

/// The columns after those of the derivatives: residuals, and roots of the weights.
const RESIDUALS: usize = PARAMETERS;
const ROOTS: usize = PARAMETERS + 1;

/// Most pixels.
pub(super) const MAX_PIXELS: usize = GROUP * MAX_GROUPS;

/// Pixels that are worked on together, and neighbours.
pub(super) const GROUP: usize = ROWS;

/// What derivatives of 1, and weights of 1, are in the columns.
pub(super) const UNIT: f32 = 256.0;

/// What residuals as large as the limit are.
pub(super) const RESIDUAL: f32 = 2048.0;

pub(super) type Vector = [f32; PARAMETERS];
pub(super) type Matrix = [Vector; PARAMETERS];

/// What is known of the last parameters beforehand: how far each is away from there, give or take what.
pub(super) type Priors = [(f32, f32); 5];

/// A pixel's derivatives, residual and root of its weight.
pub(super) type Row = [f32; COLUMNS];

#[derive(Debug)]
pub(super) struct Equations {
    columns: Box<[Column; COLUMNS]>,
    n_groups: usize,
    /// Room for a group, before it is rounded.
    rows: [[f32; GROUP]; COLUMNS],
    products: Sums,
    /// Sum of the weights.
    weight: f32,
    /// Limit of the residuals, as a part of the contrast.
    limit: f32,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            columns: Box::new([[[0; GROUP]; MAX_GROUPS]; COLUMNS]),
            n_groups: 0,
            rows: [[0.0; GROUP]; COLUMNS],
            products: [[0; COLUMNS]; COLUMNS],
            weight: 0.0,
            limit: 1.0,
        }
    }
}

/// Adding it leaves the nearest whole number in the lowest bits.
const SHIFT: f32 = 12_582_912.0;

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

    /// Adds everything up.
    pub(super) fn finish(&mut self, kernels: &Kernels) {
        (kernels.products)(&self.columns, self.n_groups, &mut self.products);
        self.weight = self.products[ROOTS][ROOTS] as f32 / (UNIT * UNIT);
    }

    /// The Gauss-Newton step, and (J^T W J)^-1 with what is known beforehand, of derivatives in parts of the contrast.
    #[inline(always)]
    pub(super) fn solve(&self, priors: &Priors) -> Option<(Vector, Matrix)> {
        let per_product = 1.0 / (UNIT * UNIT);
        let per_right = self.limit / (UNIT * RESIDUAL);
        let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
        for i in 0..PARAMETERS {
            for j in 0..=i {
                matrix[i][j] = self.products[i][j] as f32 * per_product;
                matrix[j][i] = matrix[i][j];
            }
        }
        let mut right: Vector =
            std::array::from_fn(|i| self.products[RESIDUALS][i] as f32 * per_right);
        let variance = self.residual_variance();
        for (i, (away, spread)) in (PARAMETERS - priors.len()..).zip(priors) {
            let strength = variance / (spread * spread);
            matrix[i][i] += strength;
            right[i] += strength * away;
        }
        let inverse = inverse(&matrix)?;
        let step = inverse.map(|row| row.iter().zip(&right).map(|(a, b)| a * b).sum());
        Some((step, inverse))
    }

    pub(super) fn is_determined(&self) -> bool {
        self.weight > 2.0 * PARAMETERS as f32
    }

    /// Of the pixels' weight, how much counts.
    pub(super) fn share(&self) -> f32 {
        self.weight / (self.n_groups * GROUP) as f32
    }

    /// Of the residuals, in parts of the contrast squared.
    pub(super) fn residual_variance(&self) -> f32 {
        let squares = self.products[RESIDUALS][RESIDUALS] as f32;
        let freedom = (self.weight - PARAMETERS as f32).max(1.0);
        squares * (self.limit / RESIDUAL).powi(2) / freedom
    }

    /// Makes the residuals what they should be after a step.
    #[inline(always)]
    pub(super) fn take_step(&mut self, step: &Vector) {
        const BITS: i32 = 8;
        let scale = (1 << BITS) as f32 * RESIDUAL / (UNIT * self.limit);
        let (derivatives, rest) = self.columns.split_at_mut(RESIDUALS);
        let mut changes = [[0_i32; GROUP]; MAX_GROUPS];
        let changes = changes[..self.n_groups].as_flattened_mut();
        for (derivatives, change) in derivatives.iter().zip(step) {
            let factor = (change * scale) as i32;
            for (sum, derivative) in changes.iter_mut().zip(derivatives.as_flattened()) {
                *sum = sum.wrapping_add(factor.wrapping_mul(i32::from(*derivative)));
            }
        }
        let residuals = &mut rest[0].as_flattened_mut()[..changes.len()];
        for (residual, change) in residuals.iter_mut().zip(changes) {
            *residual = residual.wrapping_sub((*change >> BITS) as i16);
        }
        self.products[RESIDUALS][RESIDUALS] = dot(residuals, residuals);
    }

    /// By how much the parameters' variance is larger than residuals without relation to each other would make it: the
    /// scatter of the groups' pulls J^T W r on the homography against that of such residuals (as in a cluster-robust
    /// covariance: Liang & Zeger, Biometrika 73, 1986), times the square of how much less pulls change with the parameters
    /// than J^T W J says, as weights change too (Huber, Robust Statistics, 1981, 6.6).
    #[inline(always)]
    pub(super) fn excess(&self) -> f32 {
        /// The homography's for size and place.
        const LOOKED_AT: [usize; 4] = [0, 2, 4, 5];
        let column = |k: usize| &self.columns[k][..self.n_groups];
        // A group mostly shows one edge, which pulls one way; the homography's eight parameters give way to as many pulls.
        let leverage = (8.0 / self.n_groups as f32).min(0.5);
        let mut togetherness = 0.0;
        for k in LOOKED_AT {
            let pulls = column(k).iter().zip(column(RESIDUALS));
            let scatter: f32 = pulls.map(|(a, b)| (dot(a, b) as f32).powi(2)).sum();
            togetherness += scatter / (self.products[k][k] as f32 * LOOKED_AT.len() as f32);
        }
        let variance = self.residual_variance() * (RESIDUAL / self.limit).powi(2);
        let togetherness = togetherness / ((1.0 - leverage) * variance);
        let roots = column(ROOTS).as_flattened().iter();
        let roots: i32 = roots.map(|&root| i32::from(root)).sum();
        // The biweight w = (1 - x)^2 has d(w r) / dr = (1 - x) (1 - 5 x) = 5 w - 4 sqrt(w).
        let slopes = 5.0 * self.weight - 4.0 * roots as f32 / UNIT;
        let flattening = self.weight / slopes.max(0.3 * self.weight);
        (togetherness * flattening.powi(2)).max(1.0)
    }
}

/// Sum of products.
#[inline(always)]
fn dot(a: &[i16], b: &[i16]) -> i32 {
    let products = a.iter().zip(b).map(|(&a, &b)| i32::from(a) * i32::from(b));
    products.fold(0, i32::wrapping_add)
}

/// Of a symmetric positive matrix, scaled to a unit diagonal meanwhile: by Gauss and Jordan's elimination in place.
#[inline(always)]
fn inverse(matrix: &Matrix) -> Option<Matrix> {
    const LEAST_PIVOT: f32 = 1e-6;
    let scales: Vector = std::array::from_fn(|i| 1.0 / matrix[i][i].sqrt());
    let mut rows = *matrix;
    scale(&mut rows, &scales);
    for k in 0..PARAMETERS {
        let mut pivot = rows[k];
        let per_pivot = 1.0 / pivot[k].max(LEAST_PIVOT);
        pivot[k] = 1.0;
        for value in &mut pivot {
            *value *= per_pivot;
        }
        for row in &mut rows {
            let factor = row[k];
            row[k] = 0.0;
            for (value, pivot) in row.iter_mut().zip(&pivot) {
                *value -= factor * pivot;
            }
        }
        rows[k] = pivot;
    }
    scale(&mut rows, &scales);
    let finite = rows.as_flattened().iter().all(|value| value.is_finite());
    finite.then_some(rows)
}

#[inline(always)]
fn scale(matrix: &mut Matrix, scales: &Vector) {
    for (row, scale) in matrix.iter_mut().zip(scales) {
        for (value, other) in row.iter_mut().zip(scales) {
            *value *= scale * other;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let matrix: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let (i, j) = (i as f32, j as f32);
                (1.0 + i) * (1.0 + j) * (-0.7 * (i - j).abs()).exp()
            })
        });
        let inverse = inverse(&matrix).unwrap();
        for (i, row) in matrix.iter().enumerate() {
            for j in 0..PARAMETERS {
                let product: f32 = row.iter().zip(&inverse).map(|(a, row)| a * row[j]).sum();
                let expected = f32::from(i == j);
                assert!((product - expected).abs() < 1e-3, "{i} {j}: {product}");
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
                row[RESIDUALS] = RESIDUAL / 8.0 * 0.5 * derivative(i, 3);
                row[ROOTS] = UNIT;
                row
            });
        }
        equations.finish(&Kernels::SCALAR);
        let mut step = [0.0; PARAMETERS];
        step[3] = 0.5;
        equations.take_step(&step);
        let residuals = &equations.columns[RESIDUALS][..4];
        assert!(
            residuals
                .as_flattened()
                .iter()
                .all(|residual| residual.abs() <= 1)
        );
    }
}
