//! Weighted least squares by its normal equations.

use super::factor::Factor;
use super::group_sums::{BASICS, MADE_OF, Rows, Sums, moments};
use super::lanes::{LANES, sum};
use super::pixels::MAX_BLOCKS;
use super::state::{State, USUAL_BLUR_PX, USUAL_GAIN};
use crate::kernels::Kernels;

/// Homography 8, black 3, white 3, blur 3, gain 1.
pub(super) const PARAMETERS: usize = 18;

/// Parameters with a prior: the last four.
const PRIORS: usize = 4;

/// Standard deviation of what rounding to whole grey levels adds.
pub(super) const ROUNDING: f32 = 0.29;

pub(super) type Matrix = [Vector; PARAMETERS];
pub(super) type Vector = [f32; PARAMETERS];

/// Sums for all groups, and what they add up to.
#[derive(Debug)]
pub(super) struct Equations {
    rows: Rows,
    blocks: Vec<Sums>,
    /// Blocks in use.
    n: usize,
    weights: f32,
    roots: f32,
    squares: f32,
    /// J^T W J, its lower half, and J^T W r.
    matrix: Matrix,
    right: Vector,
    /// The last step.
    step: Vector,
    /// Strength of each prior and how far from it the parameter is.
    priors: [(f32, f32); PRIORS],
}

impl Default for Equations {
    fn default() -> Self {
        Self {
            rows: Rows::NONE,
            blocks: vec![Sums::NOTHING; MAX_BLOCKS],
            n: 0,
            weights: 0.0,
            roots: 0.0,
            squares: 0.0,
            matrix: [[0.0; PARAMETERS]; PARAMETERS],
            right: [0.0; PARAMETERS],
            step: [0.0; PARAMETERS],
            priors: [(0.0, 0.0); PRIORS],
        }
    }
}

impl Equations {
    pub(super) fn clear(&mut self) {
        self.n = 0;
    }

    /// Adds a block of groups whose first `n_rows` rows `fill` writes.
    #[inline(always)]
    pub(super) fn add(&mut self, n_rows: usize, fill: impl FnOnce(&mut Rows)) {
        self.rows.weights = [0.0; LANES];
        self.rows.places = [[0.0; LANES]; 2];
        self.rows.roots = [0.0; LANES];
        fill(&mut self.rows);
        if let Some(sums) = self.blocks.get_mut(self.n) {
            sums.gather(&self.rows, n_rows);
            self.n += 1;
        }
    }

    /// Adds the blocks up.
    #[inline(always)]
    pub(super) fn finish(&mut self) {
        let blocks = &self.blocks[..self.n];
        let total = |lanes: fn(&Sums) -> &[f32; LANES]| -> f32 {
            blocks.iter().map(|block| sum(lanes(block))).sum()
        };
        self.weights = total(|block| &block.weights);
        self.roots = total(|block| &block.roots);
        self.squares = total(|block| &block.products[BASICS][BASICS]);
        let moments = moments(blocks);
        for (i, (a, factor_a)) in MADE_OF.into_iter().enumerate() {
            self.right[i] = moments[BASICS][a][factor_a as usize];
            for (j, (b, factor_b)) in MADE_OF.into_iter().enumerate().take(i + 1) {
                self.matrix[i][j] = moments[a.max(b)][a.min(b)][factor_a.times(factor_b) as usize];
            }
        }
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
    #[inline(always)]
    pub(super) fn right(&self) -> Vector {
        let mut right = self.right;
        for (value, (strength, away)) in right[PARAMETERS - PRIORS..].iter_mut().zip(self.priors) {
            *value += strength * away;
        }
        right
    }

    /// J^T W J, factorised.
    #[inline(always)]
    pub(super) fn factorise(&self) -> Option<Factor> {
        let mut matrix = self.matrix;
        for (i, (strength, _)) in (PARAMETERS - PRIORS..).zip(self.priors) {
            matrix[i][i] += strength;
        }
        Factor::of(&matrix)
    }

    /// Makes the residuals what they should be after a step.
    #[inline(always)]
    pub(super) fn take_step(&mut self, step: &Vector) {
        let mut change = 0.0;
        for (i, row) in self.matrix.iter().enumerate() {
            let below: f32 = row[..i].iter().zip(step).map(|(a, b)| a * b).sum();
            change += step[i] * (2.0 * (below - self.right[i]) + row[i] * step[i]);
        }
        self.squares = (self.squares + change).max(0.0);
        self.step = *step;
    }

    /// By this the inverse matrix becomes the parameters' covariance: the residuals' variance, times how much more than
    /// noise they pull together, times the square of how much less the pulls change with the parameters than J^T W J says,
    /// as weights change too (Huber, Robust Statistics, 1981, 6.6).
    pub(super) fn variance(&self, factor: &Factor, kernels: &Kernels) -> f32 {
        // The biweight w = (1 - x)^2 has d(w r) / dr = (1 - x) (1 - 5 x) = 5 w - 4 sqrt(w).
        let slopes = 5.0 * self.weights - 4.0 * self.roots;
        let flattening = self.weights / slopes.max(0.3 * self.weights);
        let excess = self.togetherness(factor, kernels) * flattening.powi(2);
        self.residual_scale().powi(2) * excess.max(1.0)
    }

    /// How much larger the scatter of the groups' pulls g = J^T W r is than with independent residuals: the trace of the
    /// cluster-robust covariance (Liang & Zeger, Biometrika 73, 1986) against that of the usual one, A^-1. On average
    /// sum(g^T A^-1 g) / variance is the trace of (1 - H) H, where H has the groups' leverages in its diagonal blocks;
    /// that trace is taken to be as small as it can be, as if each group pulled in one way only.
    fn togetherness(&self, factor: &Factor, kernels: &Kernels) -> f32 {
        let mut scatter = [0.0; LANES];
        let blocks = &self.blocks[..self.n];
        kernels.run(
            #[inline(always)]
            || {
                for block in blocks {
                    factor.add_whitened_squares(block.pulls(&self.step), &mut scatter);
                }
            },
        );
        let used = |block: &Sums| block.weights.iter().filter(|&&weight| weight > 0.0).count();
        let n_groups = blocks.iter().map(used).sum::<usize>().max(1) as f32;
        let parameters = PARAMETERS as f32;
        let leverage = (parameters / n_groups).min(0.5);
        let expected = parameters * (1.0 - leverage);
        sum(&scatter) / (expected * self.residual_scale().powi(2))
    }
}
