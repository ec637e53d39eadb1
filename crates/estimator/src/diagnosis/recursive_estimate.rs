//! The parameters of a fault, as far as views tell them, and whether they foretell further views.

use nalgebra::{Cholesky, Const, SMatrix, SVector};

use crate::diagnosis::fault_model::{FaultEquations, FaultModel};
use crate::measurement::pose_innovation::{FREEDOM, USUAL};

/// Half the squared sigmas as which a single view can speak for a fault or against it: one wrong view is no fault.
const MOST: f64 = 10.0;
/// Views over which what is left is averaged, and by which factor one can exceed the mean.
const RECENT: f64 = 3.0;
const MORE: f64 = 10.0;
/// What may be left of squared residuals against the usual ones.
const EXPLAINED: f64 = 5.0;
/// Share of what was learned that is kept at a change.
const UNSETTLED: f64 = 0.05;

/// Least variance of what is stated.
const LEAST: f64 = 1e-18;

/// The parameters of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RecursiveEstimate<const D: usize> {
    /// Views after which one counts 1/e.
    memory: f64,
    /// Sigmas of what is thought possible.
    usual: SVector<f64, D>,
    information: SMatrix<f64, D, D>,
    pull: SVector<f64, D>,
    /// Variances of what may be by what is stated.
    stated: SVector<f64, D>,
    /// Mean squared residual that it leaves, against the usual one, and that there was.
    left: f64,
    found: f64,
}

impl<const D: usize> RecursiveEstimate<D> {
    /// Nothing is known yet of a fault of this kind.
    pub fn of<M: FaultModel<D>>() -> Self {
        Self {
            memory: M::MEMORY,
            usual: SVector::from(M::PRIOR),
            information: SMatrix::zeros(),
            pull: SVector::zeros(),
            stated: SVector::zeros(),
            left: 1.0,
            found: 1.0,
        }
    }

    /// The likeliest parameters.
    pub fn at(&self) -> SVector<f64, D> {
        let usual = self.usual.map(|sigma| sigma.powi(-2));
        self.likeliest(SMatrix::from_diagonal(&usual))
    }

    fn likeliest(&self, prior: SMatrix<f64, D, D>) -> SVector<f64, D> {
        let factor = Cholesky::<f64, Const<D>>::new(self.information + prior);
        factor.map_or(SVector::zeros(), |factor| factor.solve(&self.pull))
    }

    /// What the views remembered say for these parameters and against none, as a logarithm of odds.
    pub fn strength(&self) -> f64 {
        0.5 * self.pull.dot(&self.at())
    }

    /// The same for errors that are no larger than stated.
    pub fn strength_of_stated(&self) -> f64 {
        if self.stated.max() <= 0.0 {
            return 0.0;
        }
        let prior = SMatrix::from_diagonal(&self.stated.map(|of| of.max(LEAST).recip()));
        0.5 * self.pull.dot(&self.likeliest(prior))
    }

    /// How much better the parameters so far foretell a view than no fault does, as a logarithm of odds; the view is learned
    /// from after that. `square` is its weighted sum of squared residuals, of that weight.
    pub fn gain(&mut self, marginalised: &FaultEquations<D>, (square, weight): (f64, f64)) -> f64 {
        let at = self.at();
        self.stated = marginalised.given_variance;
        let gain = marginalised.gradient.dot(&at) - 0.5 * at.dot(&(marginalised.information * at));
        let left = (square - 2.0 * gain).max(0.0) / weight;
        let follow = |mean: &mut f64, square: f64| {
            *mean += ((square / USUAL).min(MORE * *mean) - *mean) / RECENT;
        };
        follow(&mut self.left, left);
        follow(&mut self.found, square.max(0.0) / weight);
        // What is alike in all views is no outlier, however large.
        let vote = (FREEDOM + USUAL) / (FREEDOM + left / self.left.max(1.0));
        self.learn(marginalised, vote.min(1.0) / weight);
        gain.clamp(-MOST, MOST)
    }

    /// Whether nothing else is needed to explain what the views show: to about their noise, or all of much but a share.
    pub fn explains(&self, rest: f64) -> bool {
        self.left < EXPLAINED.max(self.found * rest)
    }

    /// Something has changed: what was learned before it counts little.
    pub fn unsettle(&mut self) {
        self.information *= UNSETTLED;
        self.pull *= UNSETTLED;
    }

    fn learn(&mut self, marginalised: &FaultEquations<D>, vote: f64) {
        let keep = 1.0 - 1.0 / self.memory;
        self.information = self.information * keep + marginalised.information * vote;
        self.pull = self.pull * keep + marginalised.gradient * vote;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::pose_innovation::PoseInnovation;

    struct WideFault;

    impl FaultModel<1> for WideFault {
        const PRIOR: [f64; 1] = [10.0];
        const MEMORY: f64 = 30.0;
        const UNEXPLAINED: f64 = 0.1;

        fn jacobian(_: &PoseInnovation) -> SMatrix<f64, 6, 1> {
            SMatrix::zeros()
        }
    }

    /// A view that shows the parameter at 1.
    fn equations() -> FaultEquations<1> {
        FaultEquations {
            information: SMatrix::from_element(1e3),
            gradient: SVector::from_element(1e3),
            given_variance: SVector::zeros(),
        }
    }

    #[test]
    fn views_that_leave_less_than_nothing_do_not_outweigh_what_others_leave() {
        let mut estimate = RecursiveEstimate::<1>::of::<WideFault>();
        let nothing = FaultEquations {
            gradient: SVector::zeros(),
            ..equations()
        };
        for _ in 0..50 {
            estimate.gain(&nothing, (-4.0, 1.0));
        }
        // All of much but a share.
        for _ in 0..50 {
            estimate.gain(&equations(), (1040.0, 1.0));
        }
        assert!(estimate.explains(WideFault::UNEXPLAINED));
    }
}
