//! The normal equations of a linearised problem, summed residual by residual.

use super::Kernel;
use nalgebra::{SMatrix, SVector};

/// `H = sum w J' W J`, `g = sum w J' W r` and the cost `1/2 sum rho(r' W r)`.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalEquations<const N: usize> {
    information: SMatrix<f64, N, N>,
    gradient: SVector<f64, N>,
    cost: f64,
    n_residuals: usize,
}

impl<const N: usize> Default for NormalEquations<N> {
    fn default() -> Self {
        Self {
            information: SMatrix::zeros(),
            gradient: SVector::zeros(),
            cost: 0.0,
            n_residuals: 0,
        }
    }
}

impl<const N: usize> NormalEquations<N> {
    /// Adds a residual of `M` numbers with its derivative by the step and its own information (inverse covariance).
    pub fn add<const M: usize>(
        &mut self,
        residual: &SVector<f64, M>,
        jacobian: &SMatrix<f64, M, N>,
        information: &SMatrix<f64, M, M>,
        kernel: Kernel,
    ) {
        let weighted_residual = information * residual;
        let squared = residual.dot(&weighted_residual);
        let weight = kernel.weight(squared);
        let weighted_jacobian = information * jacobian * weight;
        self.information += jacobian.transpose() * weighted_jacobian;
        self.gradient += jacobian.transpose() * weighted_residual * weight;
        self.cost += 0.5 * kernel.rho(squared);
        self.n_residuals += M;
    }

    /// Adds a residual of `M` numbers with unit variance each.
    pub fn add_unweighted<const M: usize>(
        &mut self,
        residual: &SVector<f64, M>,
        jacobian: &SMatrix<f64, M, N>,
    ) {
        self.information += jacobian.transpose() * jacobian;
        self.gradient += jacobian.transpose() * residual;
        self.cost += 0.5 * residual.norm_squared();
        self.n_residuals += M;
    }

    /// Sum of the weighted `J' W J`.
    pub fn information(&self) -> &SMatrix<f64, N, N> {
        &self.information
    }

    /// Derivative of the cost by the step.
    pub fn gradient(&self) -> &SVector<f64, N> {
        &self.gradient
    }

    /// Half the sum of the robust squares.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// How many numbers were added as residuals.
    pub fn n_residuals(&self) -> usize {
        self.n_residuals
    }

    /// The step `-(H + damping D)^-1 g`, `D` the diagonal of `H`; `None` if nothing is determined.
    pub fn damped_step(&self, damping: f64) -> Option<SVector<f64, N>> {
        let mut damped = self.information;
        // An entry without information gets a trace of the largest, so that the system stays solvable.
        let floor = self.information.diagonal().max() * 1e-9;
        for i in 0..N {
            damped[(i, i)] += damping * self.information[(i, i)].max(floor);
        }
        let step = -damped.cholesky()?.solve(&self.gradient);
        step.iter().all(|s| s.is_finite()).then_some(step)
    }

    pub(super) fn expected_decrease(&self, step: &SVector<f64, N>) -> f64 {
        -(self.gradient.dot(step) + 0.5 * step.dot(&(self.information * step)))
    }

    pub(super) fn is_finite(&self) -> bool {
        let numbers = self.information.iter().chain(self.gradient.iter());
        self.cost.is_finite() && numbers.copied().all(f64::is_finite)
    }
}
