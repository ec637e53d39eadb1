//! What is wrong for good: errors of the cameras' poses, of their lenses and of the tags' places, which no number of images
//! averages away (consider parameters; Schmidt 1966, Application of state-space methods to navigation problems).
//!
//! They are not estimated. How much the state would be off by a given error e of a source is carried along, S = d state / d e:
//! S' = F S in a prediction, S' = S - G (L H S + K) in an update with its gain G, the information L of all corners and
//! K = J^T W dr/de of those that the source displaces. The covariance that is published is P + S C Sᵀ over all sources, P being as large
//! as Fisher's information of the last views makes it ([`ObjectState::covariance_inflation`]).

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

/// How the errors act on the state.
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
    /// `None` for a rigid object. Joints hang together with the pose so closely that it would run away without them, and so do clocks
    /// while little is known of them.
    pub(crate) of_joints: Option<Box<JointSensitivity>>,
    pub(crate) of_clocks: Option<Box<ClockSensitivity>>,
}

/// An update, as far as the sensitivities need it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UpdateGain<const D: usize> {
    /// As [`crate::filter::update::Updated::gain`] has it.
    pub with: CrossCovariance<D>,
    /// Place of the camera's clock and seconds by which what was seen lies before the state, where that is estimated.
    pub clock: Option<(usize, f64)>,
    /// Of the configuration.
    pub rates: SVector<f64, D>,
    /// Of all corners.
    pub information: SMatrix<f64, D, D>,
}

impl ConsiderStates {
    pub fn carry(&mut self, turn: &Matrix3<f64>, gain: &Matrix3<f64>, dt: f64) {
        for acting in &mut self.sources {
            carry(&mut acting.sensitivity, turn, gain, dt);
            if let Some(of_joints) = &mut acting.of_joints {
                let gone = of_joints.fixed_rows::<MOST_JOINTS>(MOST_JOINTS) * dt;
                let mut values = of_joints.fixed_rows_mut::<MOST_JOINTS>(0);
                values += gone;
            }
        }
    }

    /// About another root; `by_motion` and `by_joints` are what the former one's motion and the joints do to it.
    pub fn rooted(&mut self, by_motion: &Covariance, by_joints: &JointCross) {
        for acting in &mut self.sources {
            acting.sensitivity = by_motion * acting.sensitivity;
            if let Some(of_joints) = &acting.of_joints {
                acting.sensitivity += by_joints * **of_joints;
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
        for acting in &mut self.sources {
            let mut pull = gain.information * acting.seen_in(gain);
            if let Some(part) = parts.iter().find(|part| part.source == acting.source) {
                pull += part.pull;
                acting.variance = part.variance;
            }
            acting.sensitivity -= gain.with.motion.tr_mul(&pull);
            if let Some(of_joints) = &mut acting.of_joints {
                **of_joints -= gain.with.joints.tr_mul(&pull);
            }
            if let Some(clocks) = clocks {
                let of_clocks = acting.of_clocks.get_or_insert_default();
                **of_clocks -= clocks.differences_only(&gain.with.clocks.tr_mul(&pull));
            }
        }
    }

    /// Forgets sources that act no more, next to the variances of the state.
    pub(crate) fn forget<const D: usize>(
        &mut self,
        variances: &SMatrix<f64, 12, 1>,
        parts: &[BiasGradient<D>],
    ) {
        self.sources.retain(|acting| {
            let squares = acting.sensitivity.map(|slope| slope * slope);
            let caused = squares * acting.variance;
            parts.iter().any(|part| part.source == acting.source)
                || (0..12).any(|row| caused[row] > FORGOTTEN * variances[row])
        });
    }

    /// Covariance of the configuration by them.
    pub(crate) fn covariance<const D: usize>(&self) -> SMatrix<f64, D, D> {
        let caused = |acting: &ConsiderState| {
            let mut seen = acting.seen::<D>(0.0);
            for (mut column, variance) in seen.column_iter_mut().zip(&acting.variance) {
                column *= variance.sqrt();
            }
            seen * seen.transpose()
        };
        self.sources.iter().map(caused).sum()
    }
}

impl ConsiderState {
    /// Of what an update is about.
    pub(crate) fn seen_in<const D: usize>(&self, gain: &UpdateGain<D>) -> SMatrix<f64, D, 6> {
        self.seen_by(gain.clock, &gain.rates)
    }

    /// Of what a camera sees whose clock has that place and offset, at those rates.
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

    /// Of what is seen so many seconds before the state.
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
