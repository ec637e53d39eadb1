//! Weighted least squares by its normal equations, in whole numbers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: exact sums, the same in any order and on
//! any processor, by vector instructions that all of them have. What rounding changes in the derivatives leaves the estimate
//! where it is, as sums of residuals times anything but themselves are zero on average where the model holds.

use crate::kernels::{self, Kernels};

/// Homography 8, black, white, light 2, blur 3, gain.
pub(super) const PARAMETERS: usize = 16;

/// Derivatives, then the residual.
pub(super) const COLUMNS: usize = PARAMETERS + 1;

/// Most pixels.
pub(super) const MAX_PIXELS: usize = 1280;

/// Pixels that are worked on together, and neighbours.
pub(super) const GROUP: usize = 16;

/// What derivatives of 1, and weights of 1, are in the columns.
pub(super) const UNIT: f32 = 256.0;

/// What residuals as large as the limit are.
pub(super) const RESIDUAL: f32 = 2048.0;

pub(super) type Vector = [f32; PARAMETERS];
pub(super) type Matrix = [Vector; PARAMETERS];

/// The column of residuals.
const RESIDUALS: usize = PARAMETERS;

/// What is known of a parameter beforehand: how far it is away from there, give or take the spread.
pub(super) struct Prior {
    pub(super) parameter: usize,
    pub(super) away: f32,
    pub(super) spread: f32,
}

#[derive(Debug)]
pub(super) struct Equations {
    columns: Vec<[i16; MAX_PIXELS]>,
    /// Roots of the weights.
    roots: Vec<i16>,
    /// Room for a group, before it is rounded.
    rows: [[f32; GROUP]; COLUMNS + 1],
    /// Pixels in use.
    n: usize,
    /// Sum of the weights.
    weight: f32,
    /// Sums of products of each column with itself and those before it.
    products: [[i32; COLUMNS]; COLUMNS],
    /// Limit of the residuals, as a part of the contrast.
    limit: f32,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            columns: vec![[0; MAX_PIXELS]; COLUMNS],
            roots: vec![0; MAX_PIXELS],
            rows: [[0.0; GROUP]; COLUMNS + 1],
            n: 0,
            weight: 0.0,
            products: [[0; COLUMNS]; COLUMNS],
            limit: 1.0,
        }
    }
}

/// Adding it leaves the nearest whole number in the lowest bits.
const SHIFT: f32 = 12_582_912.0;

impl Equations {
    pub(super) fn clear(&mut self, limit: f32) {
        self.n = 0;
        self.limit = limit;
    }

    /// Adds a group: rows and roots of weights.
    #[inline(always)]
    pub(super) fn add(&mut self, row: impl Fn(usize) -> ([f32; COLUMNS], f32)) {
        for i in 0..GROUP {
            let (row, root) = row(i);
            for k in 0..COLUMNS {
                self.rows[k][i] = row[k] + SHIFT;
            }
            self.rows[COLUMNS][i] = root + SHIFT;
        }
        let group = self.n / GROUP;
        for (column, row) in self.columns.iter_mut().zip(&self.rows) {
            put(column, group, row);
        }
        put(&mut self.roots, group, &self.rows[COLUMNS]);
        self.n = (self.n + GROUP).min(MAX_PIXELS);
    }

    fn column(&self, k: usize) -> &[i16] {
        &self.columns[k][..self.n]
    }

    /// Adds everything up.
    #[inline(always)]
    pub(super) fn finish(&mut self, kernels: &Kernels) {
        const TOGETHER: usize = kernels::COLUMNS;
        for i in 0..COLUMNS {
            for first in (0..=i.min(PARAMETERS - 1)).step_by(TOGETHER) {
                let others = std::array::from_fn(|k| self.column(first + k));
                let products = kernels.products(self.column(i), others);
                self.products[i][first..first + TOGETHER].copy_from_slice(&products);
            }
        }
        let residuals = self.column(RESIDUALS);
        self.products[RESIDUALS][RESIDUALS] = dot(residuals, residuals);
        let roots = &self.roots[..self.n];
        self.weight = dot(roots, roots) as f32 / (UNIT * UNIT);
    }

    /// The Gauss-Newton step, and (J^T W J)^-1 with what is known beforehand, of derivatives in parts of the contrast.
    #[inline(always)]
    pub(super) fn solve(&self, priors: &[Prior]) -> Option<(Vector, Matrix)> {
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
        for prior in priors {
            let strength = variance / (prior.spread * prior.spread);
            matrix[prior.parameter][prior.parameter] += strength;
            right[prior.parameter] += strength * prior.away;
        }
        let inverse = inverse(&matrix)?;
        let step = inverse.map(|row| row.iter().zip(&right).map(|(a, b)| a * b).sum());
        Some((step, inverse))
    }

    pub(super) fn is_determined(&self) -> bool {
        self.weight > 2.0 * PARAMETERS as f32
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
        let mut changes = [0_i32; MAX_PIXELS];
        let changes = &mut changes[..self.n];
        for (derivatives, change) in derivatives.iter().zip(step) {
            let factor = (change * scale) as i32;
            for (sum, derivative) in changes.iter_mut().zip(derivatives) {
                *sum = sum.wrapping_add(factor.wrapping_mul(i32::from(*derivative)));
            }
        }
        let residuals = &mut rest[0][..self.n];
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
        const HOMOGRAPHY: usize = 8;
        let residuals = self.column(RESIDUALS).as_chunks::<GROUP>().0;
        let leverage = (PARAMETERS as f32 / residuals.len() as f32).min(0.5);
        let mut togetherness = 0.0;
        for k in 0..HOMOGRAPHY {
            let column = self.column(k).as_chunks::<GROUP>().0;
            let pulls = column.iter().zip(residuals);
            let scatter: f32 = pulls.map(|(a, b)| (dot(a, b) as f32).powi(2)).sum();
            togetherness += scatter / (self.products[k][k] as f32 * HOMOGRAPHY as f32);
        }
        let variance = self.residual_variance() * (RESIDUAL / self.limit).powi(2);
        let togetherness = togetherness / ((1.0 - leverage) * variance);
        // The biweight w = (1 - x)^2 has d(w r) / dr = (1 - x) (1 - 5 x) = 5 w - 4 sqrt(w).
        let roots: i32 = self.roots[..self.n]
            .iter()
            .map(|&root| i32::from(root))
            .sum();
        let slopes = 5.0 * self.weight - 4.0 * roots as f32 / UNIT;
        let flattening = self.weight / slopes.max(0.3 * self.weight);
        (togetherness * flattening.powi(2)).max(1.0)
    }
}

/// Sets a group of whole numbers, to which `SHIFT` was added.
#[inline(always)]
fn put(column: &mut [i16], group: usize, shifted: &[f32; GROUP]) {
    if let Some(numbers) = column.as_chunks_mut::<GROUP>().0.get_mut(group) {
        for i in 0..GROUP {
            numbers[i] = shifted[i].to_bits() as i16;
        }
    }
}

/// Sum of products.
#[inline(always)]
fn dot(a: &[i16], b: &[i16]) -> i32 {
    a.iter().zip(b).fold(0, |sum: i32, (&a, &b)| {
        sum.wrapping_add(i32::from(a) * i32::from(b))
    })
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
                let mut row: [f32; COLUMNS] =
                    std::array::from_fn(|k| UNIT / 8.0 * derivative(i, k));
                row[RESIDUALS] = RESIDUAL / 8.0 * 0.5 * derivative(i, 3);
                (row, UNIT)
            });
        }
        equations.finish(&Kernels::SCALAR);
        let mut step = [0.0; PARAMETERS];
        step[3] = 0.5;
        equations.take_step(&step);
        assert!(
            equations
                .column(RESIDUALS)
                .iter()
                .all(|residual| residual.abs() <= 1)
        );
    }
}
