//! Small dense least squares on manifolds: Levenberg-Marquardt with robust kernels.
//!
//! `N` is the dimension of a step, known at compile time; nothing here touches the heap. Residuals are weighted by
//! their own information (inverse covariance), so costs are in units of sigma squared and the returned information
//! matrix is that of the estimate.

mod kernel;
mod normal_equations;

pub use kernel::Kernel;
pub use normal_equations::NormalEquations;

use nalgebra::{SMatrix, SVector};

/// What is minimised: the sum of squared residuals of a state that lives on a manifold.
pub trait Problem<const N: usize> {
    /// A point of the manifold.
    type State: Clone;

    /// Adds every residual at `state`; `None` if the state lies outside the problem's domain (a point behind a camera).
    fn linearise(&self, state: &Self::State, equations: &mut NormalEquations<N>) -> Option<()>;

    /// The state after a small step, whose derivatives [`Problem::linearise`] gives.
    fn step(&self, state: &Self::State, step: &SVector<f64, N>) -> Self::State;
}

/// When the minimiser stops, and how it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most linearisations after the first. Default 20.
    pub max_iterations: usize,
    /// A step that is expected to lower the cost by less than this (sigma squared), or by less than rounding shows, is
    /// the last. Default 1e-16.
    pub tolerance: f64,
    /// Marquardt's damping of the first step, as a fraction of the information's diagonal. Default 1e-6: nearly
    /// Gauss-Newton; larger where the start may be far off.
    pub initial_damping: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_iterations: 20,
            tolerance: 1e-16,
            initial_damping: 1e-6,
        }
    }
}

/// Where the minimiser came to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<S, const N: usize> {
    /// The best state found.
    pub state: S,
    /// Half the sum of the (robust) squared residuals there.
    pub cost: f64,
    /// Sum of `J' W J` there with the kernel's weights: the inverse covariance of a step about `state`.
    pub information: SMatrix<f64, N, N>,
    /// Linearisations after the first.
    pub iterations: usize,
    /// Whether the last step was within the tolerance.
    pub outcome: Termination,
}

/// Why the minimiser stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// No step improves the state by more than the tolerance.
    Converged,
    /// It could have gone on.
    OutOfIterations,
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LeastSquaresError {
    /// The start lies outside the problem's domain or its residuals are not finite.
    #[error("the start of the minimisation is outside the problem's domain")]
    BadStart,
}

impl<S, const N: usize> Solution<S, N> {
    /// The covariance of a step about the state; `None` if the residuals don't determine it.
    pub fn covariance(&self) -> Option<SMatrix<f64, N, N>> {
        let covariance = self.information.cholesky()?.inverse();
        covariance
            .iter()
            .all(|c| c.is_finite())
            .then_some(covariance)
    }
}

/// Damping never falls below this, so that a direction without information cannot run away.
const MIN_DAMPING: f64 = 1e-12;
/// Beyond this damping steps are too short to matter.
const MAX_DAMPING: f64 = 1e12;
/// How damping shrinks after a good step and grows after a bad one.
const DAMPING_FACTOR: f64 = 10.0;
/// A decrease below this part of the cost drowns in rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Minimises from `start` (K. Levenberg 1944, D. Marquardt 1963; damping scaled by the diagonal).
///
/// A rank-deficient problem is no error: what the residuals don't determine stays as it was, and
/// [`Solution::covariance`] says so.
pub fn minimise<const N: usize, P: Problem<N>>(
    problem: &P,
    start: P::State,
    options: &Options,
) -> Result<Solution<P::State, N>, LeastSquaresError> {
    let equations = linearise(problem, &start).ok_or(LeastSquaresError::BadStart)?;
    let damping = options.initial_damping.max(MIN_DAMPING);
    let mut descent = Descent {
        problem,
        state: start,
        equations,
        damping,
    };
    for iterations in 0..options.max_iterations {
        if descent.advance(options.tolerance) == Advance::Last {
            return Ok(descent.rest(iterations + 1, Termination::Converged));
        }
    }
    Ok(descent.rest(options.max_iterations, Termination::OutOfIterations))
}

/// Where the minimiser is on its way.
struct Descent<'a, const N: usize, P: Problem<N>> {
    problem: &'a P,
    state: P::State,
    equations: NormalEquations<N>,
    damping: f64,
}

#[derive(PartialEq)]
enum Advance {
    Further,
    Last,
}

impl<const N: usize, P: Problem<N>> Descent<'_, N, P> {
    /// Tries one step and takes it if it lowers the cost.
    fn advance(&mut self, tolerance: f64) -> Advance {
        let Some(step) = self.equations.damped_step(self.damping) else {
            return Advance::Last; // nothing is determined
        };
        let expected = self.equations.expected_decrease(&step);
        let negligible = tolerance + ROUNDING * self.equations.cost();
        self.take_if_better(&step);
        if expected <= negligible || self.damping > MAX_DAMPING {
            Advance::Last
        } else {
            Advance::Further
        }
    }

    fn take_if_better(&mut self, step: &SVector<f64, N>) {
        let trial = self.problem.step(&self.state, step);
        match linearise(self.problem, &trial) {
            Some(better) if better.cost() < self.equations.cost() => {
                (self.state, self.equations) = (trial, better);
                self.damping = (self.damping / DAMPING_FACTOR).max(MIN_DAMPING);
            }
            _ => self.damping *= DAMPING_FACTOR,
        }
    }

    fn rest(self, iterations: usize, outcome: Termination) -> Solution<P::State, N> {
        let (cost, information) = (self.equations.cost(), *self.equations.information());
        Solution {
            state: self.state,
            cost,
            information,
            iterations,
            outcome,
        }
    }
}

fn linearise<const N: usize, P: Problem<N>>(
    problem: &P,
    state: &P::State,
) -> Option<NormalEquations<N>> {
    let mut equations = NormalEquations::default();
    problem.linearise(state, &mut equations)?;
    equations.is_finite().then_some(equations)
}
