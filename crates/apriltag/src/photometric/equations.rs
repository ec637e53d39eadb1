//! Weighted least squares by its normal equations, in whole numbers.
//!
//! A pixel's derivatives and residual are rounded to 16 bits and multiplied to 32: exact sums, the same in any order and on
//! any processor, by vector instructions that all of them have. What rounding changes in the derivatives leaves the estimate
//! where it is, as sums of residuals times anything but themselves are zero on average where the model holds.

use crate::kernels::{COLUMNS, Column, MAX_GROUPS, ROWS, Sums, products, vectorised};

/// Homography 8, black, white, light 2, blur 3, halo, gain, ground.
pub(super) const PARAMETERS: usize = COLUMNS - 1;

/// The column after those of the derivatives.
const RESIDUALS: usize = PARAMETERS;

/// Most pixels.
pub(super) const MAX_PIXELS: usize = GROUP * MAX_GROUPS;

/// Pixels that are worked on together, and neighbours.
pub(super) const GROUP: usize = ROWS;

/// What derivatives of 1, and weights of 1, are in the columns.
pub(super) const UNIT: f32 = 256.0;

/// What residuals as large as the limit are.
pub(super) const RESIDUAL: f32 = 2048.0;

/// The homography's parameters, which are the first.
const HOMOGRAPHY: usize = 8;

pub(super) type Vector = [f32; PARAMETERS];

/// What is known of the last parameters beforehand: how far each is away from there, give or take what.
pub(super) type Priors = [(f32, f32); 6];

/// A pixel's derivatives, residual and root of its weight.
pub(super) type Row = [f32; COLUMNS + 1];

#[derive(Debug)]
pub(super) struct Equations {
    columns: Box<[Column; COLUMNS]>,
    /// Of the pixels' weights.
    roots: Box<Column>,
    n_groups: usize,
    /// Room for a group, before it is rounded.
    rows: [[f32; GROUP]; COLUMNS + 1],
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
            roots: Box::new([[0; GROUP]; MAX_GROUPS]),
            n_groups: 0,
            rows: [[0.0; GROUP]; COLUMNS + 1],
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
                self.roots[self.n_groups][i] = self.rows[COLUMNS][i].to_bits() as i16;
            }
            self.n_groups += 1;
        }
    }

    /// Adds everything up.
    pub(super) fn finish(&mut self) {
        products(&self.columns, self.n_groups, &mut self.products);
        let roots = self.roots[..self.n_groups].as_flattened();
        let weight = vectorised(
            #[inline(always)]
            || dot(roots, roots),
        );
        self.weight = weight as f32 / (UNIT * UNIT);
    }

    /// The Gauss-Newton step and what it is worth, with what is known beforehand.
    #[inline(always)]
    pub(super) fn solve(&self, priors: &Priors) -> (Vector, Factor) {
        let per_product = 1.0 / (UNIT * UNIT);
        let per_right = self.limit / (UNIT * RESIDUAL);
        let mut system = [[0.0; WIDTH]; PARAMETERS];
        for i in 0..PARAMETERS {
            for j in 0..=i {
                system[i][j] = self.products[i][j] as f32 * per_product;
                system[j][i] = system[i][j];
            }
            system[i][PARAMETERS] = self.products[RESIDUALS][i] as f32 * per_right;
        }
        let variance = self.residual_variance();
        for (i, (away, spread)) in (PARAMETERS - priors.len()..).zip(priors) {
            let strength = variance / (spread * spread);
            system[i][i] += strength;
            system[i][PARAMETERS] += strength * away;
        }
        eliminate(&mut system);
        (step(&system), Factor::new(&system))
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
        let roots = self.roots[..self.n_groups].as_flattened().iter();
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

/// Numbers in a row of a symmetric system and its right side, filled up to whole vectors.
const WIDTH: usize = 24;

type System = [[f32; WIDTH]; PARAMETERS];

/// Leaves a triangle: nothing after the diagonal, each row from the last one on being taken off those before it.
#[inline(always)]
fn eliminate(system: &mut System) {
    const LEAST_PIVOT: f32 = 1e-6;
    let diagonal: Vector = std::array::from_fn(|i| system[i][i]);
    for k in (0..PARAMETERS).rev() {
        system[k][k] = system[k][k].max(LEAST_PIVOT * diagonal[k]);
        let row = system[k];
        let per_pivot = 1.0 / row[k];
        for other in &mut system[..k] {
            let factor = other[k] * per_pivot;
            for (value, pivot) in other.iter_mut().zip(&row) {
                *value -= factor * pivot;
            }
        }
    }
}

#[inline(always)]
fn step(system: &System) -> Vector {
    let mut step = [0.0; PARAMETERS];
    for (k, row) in system.iter().enumerate() {
        let known: f32 = row[..k].iter().zip(&step).map(|(a, b)| a * b).sum();
        step[k] = (row[PARAMETERS] - known) / row[k];
    }
    step
}

/// What is left of the normal equations for the homography when all else is eliminated, T^T D^-1 T by its triangle T, of
/// which D is the diagonal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor([[f32; HOMOGRAPHY]; HOMOGRAPHY]);

impl Factor {
    fn new(system: &System) -> Self {
        Self(std::array::from_fn(|i| {
            std::array::from_fn(|j| system[i][j])
        }))
    }

    /// D^(1/2) T^-T j: products of what this makes of two rows are the covariance of what they take from the parameters.
    pub(super) fn whiten(&self, mut row: [f32; HOMOGRAPHY]) -> [f32; HOMOGRAPHY] {
        for (k, triangle) in self.0.iter().enumerate().rev() {
            let share = row[k] / triangle[k];
            for j in 0..k {
                row[j] -= share * triangle[j];
            }
            row[k] = share * triangle[k].sqrt();
        }
        row
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(right: usize) -> System {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match j {
                ..PARAMETERS => {
                    let (i, j) = (i as f32, j as f32);
                    (1.0 + i) * (1.0 + j) * (-0.7 * (i - j).abs()).exp()
                }
                PARAMETERS => f32::from(i == right),
                _ => 0.0,
            })
        })
    }

    #[test]
    fn steps_solve_the_equations_and_show_the_covariance() {
        for right in 0..HOMOGRAPHY {
            let mut triangle = system(right);
            eliminate(&mut triangle);
            let solved = step(&triangle);
            let factor = Factor::new(&triangle);
            let unit = |k: usize| factor.whiten(std::array::from_fn(|i| f32::from(i == k)));
            for (i, row) in system(right).iter().enumerate() {
                let sum: f32 = row.iter().zip(&solved).map(|(a, b)| a * b).sum();
                assert!((sum - f32::from(i == right)).abs() < 1e-3, "{i}: {sum}");
            }
            for k in 0..HOMOGRAPHY {
                let products = unit(k).into_iter().zip(unit(right)).map(|(a, b)| a * b);
                let covariance: f32 = products.sum();
                assert!((covariance - solved[k]).abs() < 1e-3 * solved[right]);
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
                row[COLUMNS] = UNIT;
                row
            });
        }
        equations.finish();
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
