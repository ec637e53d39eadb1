//! The residuals of a robot's poses in the normal equations.

use super::arm::{Arm, ArmResidual, Hand, HandError, KERNEL};
use super::layout::{Layout, stepped_pose};
use super::node::Node;
use super::state::Bundle;
use nalgebra::{DMatrix, DVector, Matrix6, SMatrix};
use sextant_geometry::{se3, so3};

impl Arm {
    /// After a step of the kept parameters.
    pub(super) fn stepped(&self, layout: &Layout, kept: &[f64]) -> Self {
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
    pub(super) fn residuals<const D: usize>(
        &self,
        bundle: &Bundle,
        nodes: &[Node<D>],
    ) -> Vec<ArmResidual> {
        let information = self.information();
        let residuals = self.errors(bundle).map(|(instant, _, found)| {
            let own = nodes[instant].own.fixed_view::<6, 6>(0, 0);
            let of_object = own.into_owned().cholesky().map(|factor| factor.inverse());
            let by_object = self.by_object(&found);
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
pub(super) fn add<const D: usize>(
    bundle: &Bundle,
    layout: &Layout,
    (kept, gradient): (&mut DMatrix<f64>, &mut DVector<f64>),
    nodes: &mut [Node<D>],
) -> f64 {
    let (Some(arm), Some(first)) = (&bundle.arm, layout.arm.pose) else {
        return 0.0;
    };
    let columns: Vec<usize> = layout.arm.all().collect();
    let information = arm.information();
    let mut sum = add_reach(arm, first + 6, (&mut *kept, &mut *gradient));
    for (at, hand, found) in arm.errors(bundle) {
        let square = found.error.dot(&(information * found.error));
        sum += KERNEL.rho(square);
        let weights = information * KERNEL.weight(square);
        let mut by_kept = SMatrix::<f64, 6, 13>::zeros();
        by_kept.fixed_columns_mut::<6>(0).copy_from(&found.by_base);
        by_kept.fixed_columns_mut::<6>(6).copy_from(&found.by_hand);
        // A later robot pose is B exp(x ds): the error becomes log(exp(-x ds) E).
        let by_delay = -se3::left_jacobian_inverse(&found.error) * hand.twist;
        by_kept.column_mut(12).copy_from(&by_delay);
        let by_object = arm.by_object(&found);
        let by_instant = SMatrix::<f64, 6, D>::from_fn(|row, column| match column {
            0..6 => by_object[(row, column)],
            _ => 0.0,
        });
        let by_kept = by_kept.columns(0, columns.len());
        let weighted = weights * by_kept;
        let node = &mut nodes[at];
        node.own += by_instant.transpose() * weights * by_instant;
        node.gradient += by_instant.transpose() * (weights * found.error);
        let start = node.local(first);
        let mut coupling = node.coupling.columns_mut(start, columns.len());
        coupling += by_instant.transpose() * &weighted;
        let n = columns.len();
        let mut own = kept.view_mut((first, first), (n, n));
        own += by_kept.transpose() * &weighted;
        let mut pull = gradient.rows_mut(first, n);
        pull += weighted.transpose() * found.error;
    }
    sum
}

/// Adds the prior of the hand's reach at the columns of the hand; returns its square.
fn add_reach(
    arm: &Arm,
    at: usize,
    (kept, gradient): (&mut DMatrix<f64>, &mut DVector<f64>),
) -> f64 {
    let shift = arm.hand_from_carried.translation.vector;
    let mut by_hand = SMatrix::<f64, 3, 6>::identity();
    let mut by_turn = by_hand.fixed_columns_mut::<3>(3);
    by_turn.copy_from(&-so3::hat(&shift));
    let weighted = by_hand.transpose() / arm.reach_m.powi(2);
    let mut own = kept.fixed_view_mut::<6, 6>(at, at);
    own += weighted * by_hand;
    let mut pull = gradient.fixed_rows_mut::<6>(at);
    pull += weighted * shift;
    arm.reach_square()
}

/// The sum of the robust squares alone.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let Some(arm) = &bundle.arm else { return 0.0 };
    let information = arm.information();
    let squares = arm.errors(bundle);
    squares
        .map(|(_, _, found)| KERNEL.rho(found.error.dot(&(information * found.error))))
        .sum::<f64>()
        + arm.reach_square()
}
