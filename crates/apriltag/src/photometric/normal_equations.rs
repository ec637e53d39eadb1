//! Weighted least squares by its normal equations.

use super::lanes::{GROUP, GROUPS, LANES, Lanes};
use super::pixels::MAX_PIXELS;
use super::state::{State, USUAL_BLUR_PX, USUAL_GAIN};
use crate::kernels::{Kernels, PRODUCTS};

/// Homography 8, black 3, white 3, blur 3, gain 1.
pub(super) const PARAMETERS: usize = 18;

pub(super) type Matrix = [Vector; PARAMETERS];
type Vector = [f32; PARAMETERS];

/// Standard deviation of what rounding to whole grey levels adds.
pub(super) const ROUNDING: f32 = 0.29;

/// Parameters with a prior: the last four.
const PRIORS: usize = 4;

const BLOCKS: usize = MAX_PIXELS / LANES;

/// A column of derivatives for each parameter.
type Columns = [Lanes; PARAMETERS];

/// Pixels' derivatives and residuals, times the roots of their weights, and these.
pub(super) struct Rows<'a> {
    pub(super) columns: &'a mut Columns,
    pub(super) residuals: &'a mut Lanes,
    pub(super) roots: &'a mut Lanes,
}

/// Rows for all pixels, and what they add up to.
#[derive(Debug)]
pub(super) struct Equations {
    columns: Vec<Columns>,
    residuals: Vec<Lanes>,
    roots: Vec<Lanes>,
    /// Blocks of rows that are in use.
    n: usize,
    /// What groups of pixels beside each other pull at the parameters, in place of pixels' derivatives.
    pulls: Vec<Columns>,
    weights: f32,
    squares: f32,
    /// J^T W J, its lower half, and J^T W r.
    matrix: Matrix,
    right: Vector,
    /// Strength of each prior and how far from it the parameter is.
    priors: [(f32, f32); PRIORS],
}

impl Default for Equations {
    fn default() -> Self {
        const NONE: Columns = [[0.0; LANES]; PARAMETERS];
        Self {
            columns: vec![NONE; BLOCKS],
            residuals: vec![[0.0; LANES]; BLOCKS],
            roots: vec![[0.0; LANES]; BLOCKS],
            n: 0,
            pulls: vec![NONE; BLOCKS.div_ceil(GROUP)],
            weights: 0.0,
            squares: 0.0,
            matrix: [[0.0; PARAMETERS]; PARAMETERS],
            right: [0.0; PARAMETERS],
            priors: [(0.0, 0.0); PRIORS],
        }
    }
}

impl Equations {
    pub(super) fn clear(&mut self) {
        self.n = 0;
    }

    /// Room for the rows of a further block, as long as there is any.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<Rows<'_>> {
        let block = self.n;
        let rows = Rows {
            columns: self.columns.get_mut(block)?,
            residuals: self.residuals.get_mut(block)?,
            roots: self.roots.get_mut(block)?,
        };
        self.n += 1;
        Some(rows)
    }

    /// Sums the rows' products up.
    pub(super) fn multiply(&mut self, kernels: &Kernels) {
        let (columns, residuals) = (&self.columns[..self.n], &self.residuals[..self.n]);
        self.weights = sum_of_squares(&self.roots[..self.n]);
        self.squares = sum_of_squares(residuals);
        self.right = kernels.run(
            #[inline(always)]
            || right(columns, residuals),
        );
        self.matrix = lower_half(columns, kernels);
    }

    /// Makes the residuals what they should be after a step.
    pub(super) fn take_step(&mut self, step: &Vector, kernels: &Kernels) {
        let (columns, residuals) = (&self.columns[..self.n], &mut self.residuals[..self.n]);
        kernels.run(
            #[inline(always)]
            || {
                for (residuals, columns) in residuals.iter_mut().zip(columns) {
                    let mut rest = *residuals;
                    for (column, change) in columns.iter().zip(step) {
                        for lane in 0..LANES {
                            rest[lane] -= change * column[lane];
                        }
                    }
                    *residuals = rest;
                }
            },
        );
        self.squares = sum_of_squares(residuals);
    }

    pub(super) fn is_determined(&self) -> bool {
        self.weights > 2.0 * PARAMETERS as f32
    }

    /// Standard deviation of the residuals, in grey levels; never below that of rounding to whole grey levels.
    pub(super) fn residual_scale(&self) -> f32 {
        let freedom = (self.weights - PARAMETERS as f32).max(1.0);
        (self.squares / freedom).sqrt().max(ROUNDING)
    }

    /// The blur's covariance is near the usual one, give or take as much, and the gain near 0: matters only where the
    /// pixels don't tell.
    pub(super) fn add_priors(&mut self, state: &State) {
        let (scale, usual) = (self.residual_scale(), USUAL_BLUR_PX.powi(2));
        let prior = |away: f32, spread: f32| ((scale / spread).powi(2), away);
        let [xx, xy, yy] = state.blur;
        self.priors = [
            prior(usual - xx, usual),
            prior(-xy, usual),
            prior(usual - yy, usual),
            prior(-state.gain, USUAL_GAIN),
        ];
    }

    /// J^T W r.
    pub(super) fn right(&self) -> Vector {
        let mut right = self.right;
        for (value, (strength, away)) in right[PARAMETERS - PRIORS..].iter_mut().zip(self.priors) {
            *value += strength * away;
        }
        right
    }

    /// J^T W J, factorised.
    pub(super) fn factorise(&self) -> Option<Factor> {
        let mut matrix = self.matrix;
        for (i, (strength, _)) in (PARAMETERS - PRIORS..).zip(self.priors) {
            matrix[i][i] += strength;
        }
        Factor::of(&matrix)
    }

    /// Covariance of the parameters: residual variance times the inverse matrix, times how much more than noise the
    /// residuals pull together.
    pub(super) fn covariance(&mut self, factor: &Factor, kernels: &Kernels) -> Matrix {
        let mut inverse = factor.inverse();
        let variance = self.residual_scale().powi(2) * self.togetherness(&inverse, kernels);
        for value in inverse.as_flattened_mut() {
            *value *= variance;
        }
        inverse
    }

    /// How much larger the scatter of the groups' pulls g = J^T W r is than with independent residuals, for which
    /// sum(g^T A^-1 g) / (variance * parameters) is 1 on average, or a little less as the fit has made the pulls cancel:
    /// the trace of the cluster-robust covariance (Liang & Zeger, Biometrika 73, 1986) against that of the usual one.
    fn togetherness(&mut self, inverse: &Matrix, kernels: &Kernels) -> f32 {
        let (columns, residuals) = (&self.columns[..self.n], &self.residuals[..self.n]);
        let pulls = &mut self.pulls[..self.n.div_ceil(GROUP)];
        kernels.run(
            #[inline(always)]
            || gather(columns, residuals, pulls),
        );
        let scatter = lower_half(pulls, kernels);
        let n_groups = pulls
            .iter()
            .map(|pulls| pulls[0].iter().filter(|&&pull| pull != 0.0).count())
            .sum::<usize>() as f32;
        let parameters = PARAMETERS as f32;
        let expected = parameters * (1.0 - parameters / f32::max(n_groups, 2.0 * parameters));
        let sum = trace_of_product(inverse, &scatter);
        (sum / (expected * self.residual_scale().powi(2))).max(1.0)
    }
}

/// Sums of residual times derivative over each group of pixels.
#[inline(always)]
fn gather(columns: &[Columns], residuals: &[Lanes], pulls: &mut [Columns]) {
    pulls.as_flattened_mut().fill([0.0; LANES]);
    for (block, (columns, residuals)) in columns.iter().zip(residuals).enumerate() {
        let (pulls, first) = (&mut pulls[block / GROUP], block % GROUP * GROUPS);
        for (pull, column) in pulls.iter_mut().zip(columns) {
            let mut products = [0.0; LANES];
            for lane in 0..LANES {
                products[lane] = residuals[lane] * column[lane];
            }
            pull[first..first + GROUPS].copy_from_slice(&sums_of_groups(products));
        }
    }
}

/// A group's lanes lie a whole number of groups apart.
#[inline(always)]
fn sums_of_groups(mut values: Lanes) -> [f32; GROUPS] {
    let mut half = LANES / 2;
    while half >= GROUPS {
        for lane in 0..half {
            values[lane] += values[lane + half];
        }
        half /= 2;
    }
    std::array::from_fn(|group| values[group])
}

fn sum_of_squares(blocks: &[Lanes]) -> f32 {
    let mut sums = [0.0; LANES];
    for block in blocks {
        for (sum, value) in sums.iter_mut().zip(block) {
            *sum += value * value;
        }
    }
    sums.iter().sum()
}

/// The lower half of J^T J, and a little more.
fn lower_half(columns: &[Columns], kernels: &Kernels) -> Matrix {
    let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
    for i in (0..PARAMETERS).step_by(PRODUCTS) {
        for j in (0..=i).step_by(PRODUCTS) {
            let sums = kernels.products(columns.as_flattened(), PARAMETERS, [i, j]);
            for (row, values) in matrix[i..i + PRODUCTS].iter_mut().zip(sums) {
                row[j..j + PRODUCTS].copy_from_slice(&values);
            }
        }
    }
    matrix
}

/// J^T r.
#[inline(always)]
fn right(columns: &[Columns], residuals: &[Lanes]) -> Vector {
    let mut sums = [[0.0; LANES]; PARAMETERS];
    for (columns, residuals) in columns.iter().zip(residuals) {
        for (sums, column) in sums.iter_mut().zip(columns) {
            for lane in 0..LANES {
                sums[lane] += column[lane] * residuals[lane];
            }
        }
    }
    sums.map(|sums| sums.iter().sum())
}

/// Of a symmetric matrix and one given by its lower half.
fn trace_of_product(a: &Matrix, lower: &Matrix) -> f32 {
    let row = |i: usize| {
        let beside = (0..i).map(|j| a[i][j] * lower[i][j]).sum::<f32>();
        a[i][i] * lower[i][i] + 2.0 * beside
    };
    (0..PARAMETERS).map(row).sum()
}

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
    fn of(matrix: &Matrix) -> Option<Self> {
        const LEAST_PIVOT: f32 = 1e-6;
        let scales: Vector = std::array::from_fn(|i| 1.0 / matrix[i][i].sqrt());
        let (mut rows, mut columns, mut pivots) = (
            [[0.0; PARAMETERS]; PARAMETERS],
            [[0.0; PARAMETERS]; PARAMETERS],
            [0.0; PARAMETERS],
        );
        for i in 0..PARAMETERS {
            let scaled: Vector = std::array::from_fn(|j| {
                if j <= i {
                    matrix[i][j] * scales[i] * scales[j]
                } else {
                    0.0
                }
            });
            let row = whiten(scaled, &columns, &pivots, i);
            let rest = scaled[i] - row[..i].iter().map(|value| value * value).sum::<f32>();
            pivots[i] = 1.0 / rest.max(LEAST_PIVOT).sqrt();
            for j in 0..i {
                rows[i][j] = row[j];
                columns[j][i] = row[j];
            }
        }
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
    fn whiten(&self, right: &Vector) -> Vector {
        whiten(
            std::array::from_fn(|i| right[i] * self.scales[i]),
            &self.columns,
            &self.pivots,
            PARAMETERS,
        )
    }

    /// (L L^T)^-1
    fn inverse(&self) -> Matrix {
        std::array::from_fn(|i| {
            let mut unit = [0.0; PARAMETERS];
            unit[i] = 1.0;
            self.solve(&unit)
        })
    }

    /// (L L^T)^-1 b.
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

/// The first `n` elements of L^-1 x.
fn whiten(mut x: Vector, columns: &Matrix, pivots: &Vector, n: usize) -> Vector {
    for i in 0..n {
        x[i] *= pivots[i];
        let value = x[i];
        subtract(&mut x, value, &columns[i]);
    }
    x
}

/// x - factor * column
#[inline]
fn subtract(x: &mut Vector, factor: f32, column: &Vector) {
    for (value, element) in x.iter_mut().zip(column) {
        *value -= factor * element;
    }
}
