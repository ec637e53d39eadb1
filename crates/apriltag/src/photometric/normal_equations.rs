//! Weighted least squares by its normal equations.

use super::blurred_pattern::CROSSINGS;

/// Homography 8, black 3, white 3, blur 3, gain 1.
pub(super) const PARAMETERS: usize = 18;

/// Residuals beyond this many scales count less and less, and nothing at all beyond it (Tukey's biweight).
const TUKEY: f32 = 4.7;

type Matrix = [[f32; PARAMETERS]; PARAMETERS];

/// J^T W J (its lower half), J^T W r, and the sums that tell the residuals' scale.
#[derive(Clone, Debug)]
pub(super) struct NormalEquations {
    matrix: Matrix,
    right: [f32; PARAMETERS],
    squares: f32,
    weights: f32,
    /// J^T W r of the pixels around each crossing of the pattern's edges.
    groups: [[f32; PARAMETERS]; CROSSINGS],
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self {
            matrix: [[0.0; PARAMETERS]; PARAMETERS],
            right: [0.0; PARAMETERS],
            squares: 0.0,
            weights: 0.0,
            groups: [[0.0; PARAMETERS]; CROSSINGS],
        }
    }
}

impl NormalEquations {
    #[inline]
    pub(super) fn add(
        &mut self,
        jacobian: &[f32; PARAMETERS],
        residual: f32,
        scale: f32,
        group: usize,
    ) {
        let strays = residual / (TUKEY * scale);
        let weight = (1.0 - strays * strays).max(0.0).powi(2);
        self.squares += weight * residual * residual;
        self.weights += weight;
        for i in 0..PARAMETERS {
            let weighted = weight * jacobian[i];
            self.right[i] += weighted * residual;
            self.groups[group][i] += weighted * residual;
            for (sum, value) in self.matrix[i].iter_mut().zip(&jacobian[..=i]) {
                *sum += weighted * value;
            }
        }
    }

    /// Standard deviation of the residuals, in grey levels; never below that of rounding to whole grey levels.
    pub(super) fn residual_scale(&self) -> f32 {
        const ROUNDING: f32 = 0.29;
        let freedom = (self.weights - PARAMETERS as f32).max(1.0);
        (self.squares / freedom).sqrt().max(ROUNDING)
    }

    pub(super) fn is_determined(&self) -> bool {
        self.weights > 2.0 * PARAMETERS as f32
    }

    /// The blur's covariance is near the usual one, give or take as much, and the gain near 0: matters only where the
    /// pixels don't tell.
    pub(super) fn add_priors(&mut self, blur: [f32; 3], usual: f32, gain: f32) {
        const FIRST: usize = PARAMETERS - 4;
        const USUAL_GAIN: f32 = 0.3;
        let scale = self.residual_scale();
        let priors = [
            (usual - blur[0], usual),
            (-blur[1], usual),
            (usual - blur[2], usual),
            (-gain, USUAL_GAIN),
        ];
        for (i, (away, spread)) in priors.into_iter().enumerate() {
            let weight = (scale / spread).powi(2);
            self.matrix[FIRST + i][FIRST + i] += weight;
            self.right[FIRST + i] += weight * away;
        }
    }

    /// The step that the equations ask for.
    pub(super) fn solve(&self) -> Option<[f32; PARAMETERS]> {
        let (factor, scales) = self.factorise()?;
        let mut step: [f32; PARAMETERS] = std::array::from_fn(|i| self.right[i] * scales[i]);
        substitute(&factor, &mut step);
        for (value, scale) in step.iter_mut().zip(scales) {
            *value *= scale;
        }
        step.iter().all(|value| value.is_finite()).then_some(step)
    }

    /// Covariance of the parameters: residual variance times the inverse matrix, times how much more than noise the
    /// residuals pull together.
    pub(super) fn covariance(&self) -> Option<Matrix> {
        let (factor, scales) = self.factorise()?;
        let variance = self.residual_scale().powi(2) * self.togetherness(&factor, &scales);
        let mut covariance = [[0.0; PARAMETERS]; PARAMETERS];
        for (i, column) in covariance.iter_mut().enumerate() {
            column[i] = 1.0;
            substitute(&factor, column);
            for (value, scale) in column.iter_mut().zip(scales) {
                *value *= scale * scales[i] * variance;
            }
        }
        Some(covariance)
    }

    /// How much larger the scatter of the groups' pulls g is than with independent residuals, for which
    /// sum(g^T A^-1 g) / (variance * parameters) is 1 on average, or a little less as the fit has made the pulls cancel:
    /// the trace of the cluster-robust covariance (Liang & Zeger, Biometrika 73, 1986) against that of the usual one.
    fn togetherness(&self, factor: &Matrix, scales: &[f32; PARAMETERS]) -> f32 {
        let (mut pull, mut n_groups) = (0.0, 0.0);
        for group in self
            .groups
            .iter()
            .filter(|group| group.iter().any(|&value| value != 0.0))
        {
            let mut whitened: [f32; PARAMETERS] = std::array::from_fn(|i| group[i] * scales[i]);
            forward(factor, &mut whitened);
            pull += whitened.iter().map(|value| value * value).sum::<f32>();
            n_groups += 1.0;
        }
        let parameters = PARAMETERS as f32;
        let expected = parameters * (1.0 - parameters / f32::max(n_groups, 2.0 * parameters));
        (pull / (expected * self.residual_scale().powi(2))).max(1.0)
    }

    /// Cholesky factor of the matrix scaled to a unit diagonal, and the scales.
    fn factorise(&self) -> Option<(Matrix, [f32; PARAMETERS])> {
        const LEAST_PIVOT: f32 = 1e-6;
        let scales: [f32; PARAMETERS] = std::array::from_fn(|i| 1.0 / self.matrix[i][i].sqrt());
        let mut factor = [[0.0; PARAMETERS]; PARAMETERS];
        for i in 0..PARAMETERS {
            for j in 0..=i {
                let dot: f32 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
                let rest = self.matrix[i][j] * scales[i] * scales[j] - dot;
                factor[i][j] = if i == j {
                    rest.max(LEAST_PIVOT).sqrt()
                } else {
                    rest / factor[j][j]
                };
            }
        }
        factor[PARAMETERS - 1]
            .iter()
            .all(|value| value.is_finite())
            .then_some((factor, scales))
    }
}

/// Solves L x = b in place.
fn forward(factor: &Matrix, x: &mut [f32; PARAMETERS]) {
    for i in 0..PARAMETERS {
        let dot: f32 = (0..i).map(|k| factor[i][k] * x[k]).sum();
        x[i] = (x[i] - dot) / factor[i][i];
    }
}

/// Solves L L^T x = b in place.
fn substitute(factor: &Matrix, x: &mut [f32; PARAMETERS]) {
    forward(factor, x);
    for i in (0..PARAMETERS).rev() {
        let dot: f32 = (i + 1..PARAMETERS).map(|k| factor[k][i] * x[k]).sum();
        x[i] = (x[i] - dot) / factor[i][i];
    }
}
