//! Weighted least squares by its normal equations.

use super::blurred_pattern::CROSSINGS;
use super::pixels::MAX_PIXELS;
use super::state::{State, USUAL_BLUR_PX, USUAL_GAIN};
use crate::kernels::Kernels;

/// Homography 8, black 3, white 3, blur 3, gain 1.
pub(super) const PARAMETERS: usize = 18;

type Matrix = [Vector; PARAMETERS];
type Vector = [f32; PARAMETERS];

/// Parameters with a prior: the last four.
const PRIORS: usize = 4;

/// A row for each pixel, times the root of its weight.
#[derive(Debug)]
pub(super) struct Equations {
    n: usize,
    /// Derivatives, parameter after parameter, each with room for all pixels.
    columns: Vec<[f32; MAX_PIXELS]>,
    residuals: Vec<f32>,
    groups: Vec<u16>,
    weights: f32,
    /// Strength of each prior and how far from it the parameter is.
    priors: [(f32, f32); PRIORS],
    pulls: Vec<Vector>,
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            n: 0,
            columns: vec![[0.0; MAX_PIXELS]; PARAMETERS],
            residuals: vec![0.0; MAX_PIXELS],
            groups: vec![0; MAX_PIXELS],
            weights: 0.0,
            priors: [(0.0, 0.0); PRIORS],
            pulls: vec![[0.0; PARAMETERS]; CROSSINGS],
        }
    }
}

impl Equations {
    pub(super) fn clear(&mut self) {
        (self.n, self.weights) = (0, 0.0);
    }

    /// Adds a row; those beyond the room for [`MAX_PIXELS`] are left out.
    #[inline]
    pub(super) fn push(&mut self, jacobian: &Vector, residual: f32, weight: f32, group: usize) {
        let row = self.n;
        if row >= MAX_PIXELS {
            return;
        }
        let root = weight.sqrt();
        for (column, value) in self.columns.iter_mut().zip(jacobian) {
            column[row] = root * value;
        }
        self.residuals[row] = root * residual;
        self.groups[row] = group as u16;
        self.weights += weight;
        self.n += 1;
    }

    fn column(&self, parameter: usize) -> &[f32] {
        &self.columns[parameter][..self.n]
    }

    fn residuals(&self) -> &[f32] {
        &self.residuals[..self.n]
    }

    /// Makes the residuals what they should be after a step.
    pub(super) fn take_step(&mut self, step: &Vector) {
        for (column, change) in self.columns.iter().zip(step) {
            for (residual, derivative) in self.residuals[..self.n].iter_mut().zip(column) {
                *residual -= change * derivative;
            }
        }
    }

    pub(super) fn is_determined(&self) -> bool {
        self.weights > 2.0 * PARAMETERS as f32
    }

    /// Standard deviation of the residuals, in grey levels; never below that of rounding to whole grey levels.
    pub(super) fn residual_scale(&self) -> f32 {
        const ROUNDING: f32 = 0.29;
        let squares: f32 = self
            .residuals()
            .iter()
            .map(|residual| residual * residual)
            .sum();
        let freedom = (self.weights - PARAMETERS as f32).max(1.0);
        (squares / freedom).sqrt().max(ROUNDING)
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
    pub(super) fn right(&self, kernels: &Kernels) -> Vector {
        let mut right = std::array::from_fn(|i| kernels.dot(self.column(i), self.residuals()));
        for (value, (strength, away)) in right[PARAMETERS - PRIORS..].iter_mut().zip(self.priors) {
            *value += strength * away;
        }
        right
    }

    /// J^T W J, factorised.
    pub(super) fn factorise(&self, kernels: &Kernels) -> Option<Factor> {
        let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
        for (i, row) in matrix.iter_mut().enumerate() {
            for (j, value) in row[..=i].iter_mut().enumerate() {
                *value = kernels.dot(self.column(i), self.column(j));
            }
        }
        for (i, (strength, _)) in (PARAMETERS - PRIORS..).zip(self.priors) {
            matrix[i][i] += strength;
        }
        Factor::of(&matrix)
    }

    /// Covariance of the homography's parameters: residual variance times the inverse matrix, times how much more than noise the
    /// residuals pull together.
    pub(super) fn covariance(&mut self, factor: &Factor) -> [[f32; 8]; 8] {
        let variance = self.residual_scale().powi(2) * self.togetherness(factor);
        std::array::from_fn(|i| {
            let mut unit = [0.0; PARAMETERS];
            unit[i] = variance;
            let column = factor.solve(&unit);
            std::array::from_fn(|j| column[j])
        })
    }

    /// Standard deviation of the gain, the last parameter, as far as noise makes it uncertain.
    pub(super) fn gain_sigma(&self, factor: &Factor) -> f32 {
        let mut unit = [0.0; PARAMETERS];
        unit[PARAMETERS - 1] = 1.0;
        self.residual_scale() * factor.solve(&unit)[PARAMETERS - 1].sqrt()
    }

    /// How much larger the scatter of the groups' pulls g = J^T W r is than with independent residuals, for which
    /// sum(g^T A^-1 g) / (variance * parameters) is 1 on average, or a little less as the fit has made the pulls cancel:
    /// the trace of the cluster-robust covariance (Liang & Zeger, Biometrika 73, 1986) against that of the usual one.
    fn togetherness(&mut self, factor: &Factor) -> f32 {
        self.pulls.fill([0.0; PARAMETERS]);
        for (row, &group) in self.groups[..self.n].iter().enumerate() {
            let residual = self.residuals[row];
            for (pull, column) in self.pulls[usize::from(group)].iter_mut().zip(&self.columns) {
                *pull += residual * column[row];
            }
        }
        let (mut sum, mut n_groups) = (0.0, 0.0);
        for pull in self.pulls.iter().filter(|pull| pull[0] != 0.0) {
            sum += factor
                .whiten(pull)
                .iter()
                .map(|value| value * value)
                .sum::<f32>();
            n_groups += 1.0;
        }
        let parameters = PARAMETERS as f32;
        let expected = parameters * (1.0 - parameters / f32::max(n_groups, 2.0 * parameters));
        (sum / (expected * self.residual_scale().powi(2))).max(1.0)
    }
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
