//! Consider states: errors of camera poses, lenses and tag poses, which no number of images averages away (Schmidt
//! 1966, Application of state-space methods to navigation problems).
//!
//! They are not estimated here. The sensitivity S = d state / d e of the state to an error e is propagated: S' = F S in
//! a prediction, and in an update S is reduced by G (L H S + K), with gain G, information L of all corners and K = J^T
//! W dr/de of the corners that the source displaces. The published covariance is P + S C Sᵀ over all sources, P being
//! inflated as Fisher's information of the last views requires ([`ObjectState::covariance_inflation`]).

use nalgebra::{Matrix3, SMatrix, SVector, Vector6};

use crate::filter::clock_states::ClockStates;
use crate::filter::covariance::{
    ClockSensitivity, Covariance, CrossCovariance, JointCross, WIDTH, carry,
};
use crate::kinematics::configuration::{joint_places, rates_at};
use crate::measurement::biases::{BiasGradient, BiasSource};
use sextant_site_model::MOST_JOINTS;

type MotionSensitivity = SMatrix<f64, 12, 6>;
/// Of the joints' values and speeds.
type JointSensitivity = SMatrix<f64, WIDTH, 6>;
/// Share of a variance below which a source that no view shows any more is forgotten.
const FORGOTTEN: f64 = 1e-4;

/// Sensitivities of a state to all sources of constant errors.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ConsiderStates {
    pub(crate) sources: Vec<ConsiderState>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ConsiderState {
    pub(crate) source: BiasSource,
    /// Of each number of the error.
    pub(crate) variance: Vector6<f64>,
    pub(crate) sensitivity: MotionSensitivity,
    /// `None` for a rigid object. Joints, and clocks while they are uncertain, are so closely correlated with the pose
    /// that it would diverge without them.
    pub(crate) of_joints: Option<Box<JointSensitivity>>,
    pub(crate) of_clocks: Option<Box<ClockSensitivity>>,
}

/// An update, as far as the sensitivities need it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UpdateGain<const D: usize> {
    /// As [`crate::filter::update::Updated::gain`] has it.
    pub with: CrossCovariance<D>,
    /// Slot of the clock of the camera and its offset, s, where it is estimated.
    pub clock: Option<(usize, f64)>,
    /// Of the configuration.
    pub rates: SVector<f64, D>,
    /// Of all corners.
    pub information: SMatrix<f64, D, D>,
}

impl ConsiderStates {
    pub fn carry(&mut self, turn: &Matrix3<f64>, gain: &Matrix3<f64>, dt: f64) {
        for source in &mut self.sources {
            carry(&mut source.sensitivity, turn, gain, dt);
            if let Some(of_joints) = &mut source.of_joints {
                let gone = of_joints.fixed_rows::<MOST_JOINTS>(MOST_JOINTS) * dt;
                let mut values = of_joints.fixed_rows_mut::<MOST_JOINTS>(0);
                values += gone;
            }
        }
    }

    /// Changes the reference link; `by_motion` and `by_joints` are the derivatives of its state by that of the former
    /// one and of the joints.
    pub fn rooted(&mut self, by_motion: &Covariance, by_joints: &JointCross) {
        for source in &mut self.sources {
            source.sensitivity = by_motion * source.sensitivity;
            if let Some(of_joints) = &source.of_joints {
                source.sensitivity += by_joints * **of_joints;
            }
        }
    }

    pub(crate) fn take<const D: usize>(
        &mut self,
        gain: &UpdateGain<D>,
        parts: &[BiasGradient<D>],
        clocks: Option<&ClockStates>,
    ) {
        for part in parts {
            if !self.sources.iter().any(|one| one.source == part.source) {
                self.sources.push(ConsiderState {
                    source: part.source,
                    variance: part.variance,
                    sensitivity: MotionSensitivity::zeros(),
                    of_joints: (joint_places(D) > 0).then(|| Box::new(JointSensitivity::zeros())),
                    of_clocks: None,
                });
            }
        }
        for source in &mut self.sources {
            let mut pull = gain.information * source.seen_in(gain);
            if let Some(part) = parts.iter().find(|part| part.source == source.source) {
                pull += part.pull;
                source.variance = part.variance;
            }
            source.sensitivity -= gain.with.motion.tr_mul(&pull);
            if let Some(of_joints) = &mut source.of_joints {
                **of_joints -= gain.with.joints.tr_mul(&pull);
            }
            if let Some(clocks) = clocks {
                let of_clocks = source.of_clocks.get_or_insert_default();
                **of_clocks -= clocks.differences_only(&gain.with.clocks.tr_mul(&pull));
            }
        }
    }

    /// Drops sources whose effect is negligible next to the variances of the state.
    pub(crate) fn forget<const D: usize>(
        &mut self,
        variances: &SMatrix<f64, 12, 1>,
        parts: &[BiasGradient<D>],
    ) {
        self.sources.retain(|source| {
            let squares = source.sensitivity.map(|slope| slope * slope);
            let caused = squares * source.variance;
            parts.iter().any(|part| part.source == source.source)
                || (0..12).any(|row| caused[row] > FORGOTTEN * variances[row])
        });
    }

    /// Covariance of the configuration by them.
    pub(crate) fn covariance<const D: usize>(&self) -> SMatrix<f64, D, D> {
        let caused = |source: &ConsiderState| {
            let mut seen = source.seen::<D>(0.0);
            for (mut column, variance) in seen.column_iter_mut().zip(&source.variance) {
                column *= variance.sqrt();
            }
            seen * seen.transpose()
        };
        self.sources.iter().map(caused).sum()
    }
}

impl ConsiderState {
    /// Sensitivity of the configuration that an update is about.
    pub(crate) fn seen_in<const D: usize>(&self, gain: &UpdateGain<D>) -> SMatrix<f64, D, 6> {
        self.seen_by(gain.clock, &gain.rates)
    }

    /// Sensitivity of the configuration that a camera sees, by the slot and offset of its clock and the rates.
    pub(crate) fn seen_by<const D: usize>(
        &self,
        clock: Option<(usize, f64)>,
        rates: &SVector<f64, D>,
    ) -> SMatrix<f64, D, 6> {
        let Some((slot, offset_s)) = clock else {
            return self.seen(0.0);
        };
        let seen = self.seen(offset_s);
        match &self.of_clocks {
            Some(of_clocks) => seen - rates * of_clocks.row(slot),
            None => seen,
        }
    }

    /// Sensitivity of the configuration `offset_s` seconds before the state.
    pub(crate) fn seen<const D: usize>(&self, offset_s: f64) -> SMatrix<f64, D, 6> {
        let mut seen = SMatrix::<f64, D, 6>::zeros();
        let (pose, twist) = (
            self.sensitivity.fixed_rows::<6>(0),
            self.sensitivity.fixed_rows::<6>(6),
        );
        seen.fixed_rows_mut::<6>(0)
            .copy_from(&(pose - twist * offset_s));
        if let Some(first) = rates_at(D) {
            seen.fixed_rows_mut::<6>(first).copy_from(&twist);
        }
        let Some(of_joints) = &self.of_joints else {
            return seen;
        };
        for slot in 0..joint_places(D) {
            let (value, speed) = (of_joints.row(slot), of_joints.row(MOST_JOINTS + slot));
            seen.row_mut(6 + slot)
                .copy_from(&(value - speed * offset_s));
            if let Some(first) = rates_at(D) {
                seen.row_mut(first + 6 + slot).copy_from(&speed);
            }
        }
        seen
    }
}
