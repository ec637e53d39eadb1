//! The residuals of a robot's poses ([`crate::Arm`]) in the normal equations.

use crate::arm::{Arm, ArmResidual, Hand, HandError, KERNEL};
use crate::layout::{Layout, stepped_pose};
use crate::node::Node;
use crate::values::Bundle;
use nalgebra::{DMatrix, DVector, Matrix6, SMatrix};

impl Arm {
    /// After a step of the kept parameters.
    pub(crate) fn stepped(&self, layout: &Layout, kept: &[f64]) -> Self {
        let pose = layout.arm.pose;
        let delay_step = layout.arm.delay.map_or(0.0, |at| kept[at]);
        Self {
            base_from_site: stepped_pose(&self.base_from_site, pose, kept),
            hand_from_carried: stepped_pose(&self.hand_from_carried, pose.map(|at| at + 6), kept),
            delay_s: self.delay_s + delay_step,
            hands: self
                .hands
                .iter()
                .map(|hand| hand.map(|hand| hand.after(delay_step)))
                .collect(),
            ..self.clone()
        }
    }

    /// Each instant with a pose of the hand, and its error.
    fn errors<'a>(
        &'a self,
        bundle: &'a Bundle,
    ) -> impl Iterator<Item = (usize, &'a Hand, HandError)> {
        let hands = self.hands.iter().zip(&bundle.instants).enumerate();
        hands.filter_map(|(at, (hand, instant))| {
            let hand = hand.as_ref()?;
            let error = self.error(&hand.base_from_hand, &instant.world_from_object);
            Some((at, hand, error))
        })
    }

    /// The errors at the solution, whose nodes are given.
    pub(crate) fn residuals<const D: usize>(
        &self,
        bundle: &Bundle,
        nodes: &[Node<D>],
    ) -> Vec<ArmResidual> {
        let information = self.information();
        let residuals = self.errors(bundle).map(|(instant, _, found)| {
            let own = nodes[instant].own.fixed_view::<6, 6>(0, 0);
            let of_object = own.into_owned().cholesky().map(|factor| factor.inverse());
            let by_object = self.by_object(&found, &bundle.instants[instant].world_from_object);
            ArmResidual {
                instant,
                error: found.error,
                covariance: of_object
                    .map_or_else(Matrix6::zeros, |c| by_object * c * by_object.transpose()),
                chi_square: found.error.dot(&(information * found.error)),
            }
        });
        residuals.collect()
    }
}

/// Adds the residuals of the robot's poses; returns the sum of their robust squares.
pub(crate) fn add<const D: usize>(
    bundle: &Bundle,
    layout: &Layout,
    kept: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
    nodes: &mut [Node<D>],
) -> f64 {
    let (Some(arm), Some(first)) = (&bundle.arm, layout.arm.pose) else {
        return 0.0;
    };
    let n = layout.arm.all().count();
    let information = arm.information();
    let mut sum = arm.reach_square();
    for axis in 0..3 {
        let at = first + 6 + axis;
        let precision = arm.reach_m.powi(-2);
        kept[(at, at)] += precision;
        gradient[at] += arm.hand_from_carried.translation.vector[axis] * precision;
    }
    for (at, hand, found) in arm.errors(bundle) {
        let square = found.error.dot(&(information * found.error));
        sum += KERNEL.rho(square);
        let weights = information * KERNEL.weight(square);
        let by_object = arm.by_object(&found, &bundle.instants[at].world_from_object);
        let by_instant = SMatrix::<f64, 6, D>::from_fn(|row, column| match column {
            0..6 => by_object[(row, column)],
            _ => 0.0,
        });
        let by_kept = hand.by_kept(&found);
        let by_kept = by_kept.columns(0, n);
        let weighted = weights * by_kept;
        let node = &mut nodes[at];
        node.own += by_instant.transpose() * weights * by_instant;
        node.gradient += by_instant.transpose() * (weights * found.error);
        let start = node.local(first);
        let mut coupling = node.coupling.columns_mut(start, n);
        coupling += by_instant.transpose() * &weighted;
        let mut own = kept.view_mut((first, first), (n, n));
        own += by_kept.transpose() * &weighted;
        let mut pull = gradient.rows_mut(first, n);
        pull += weighted.transpose() * found.error;
    }
    sum
}

/// The sum of the robust squares alone.
pub(crate) fn rho(bundle: &Bundle) -> f64 {
    let Some(arm) = &bundle.arm else { return 0.0 };
    let information = arm.information();
    let squares = arm.errors(bundle);
    squares
        .map(|(_, _, found)| KERNEL.rho(found.error.dot(&(information * found.error))))
        .sum::<f64>()
        + arm.reach_square()
}
