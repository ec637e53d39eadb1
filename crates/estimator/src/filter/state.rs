//! Pose, twist and their covariance; prediction with constant twist and white acceleration.
//!
//! State: `world_from_object` and the twist (velocity of the object's origin, angular velocity), all in world axes.
//! Error: (dt, dr, dv, dw) with t_estimate = t_true + dt, R_estimate = exp(dr) R_true; dt and dr as FRAMES.md has them.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use sextant_geometry::{Pose, so3};

use crate::filter::clock_states::ClockStates;
use crate::filter::consider::{ConsiderState, ConsiderStates, UpdateGain};
use crate::filter::covariance::{
    Covariance, MOST_CLOCKS, Own, carry, symmetric, white_acceleration,
};
use crate::filter::joint_states::JointStates;
use crate::filter::process_noise::ProcessNoise;
use crate::kinematics::configuration::Configuration;
use crate::measurement::biases::BiasGradient;
use crate::measurement::view_equations::OF_FISHER;
use sextant_site_report::ClockOffset;

/// How a body moves, and how well that is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObjectState {
    /// World from object, or from the root among its links.
    pub pose: Pose,
    /// Velocity of its origin in m/s, then angular velocity in rad/s, world axes.
    pub twist: Vector6<f64>,
    /// Over (dt, dr, dv, dw).
    pub covariance: Covariance,
    /// The offsets of clocks that may be off.
    pub clocks: Option<Box<ClockStates>>,
    /// The joints, where the object has links.
    pub joints: Option<Box<JointStates>>,
    /// Power spectral density of the acceleration.
    pub motion: ProcessNoise,
    /// Sensitivities of the state to errors of cameras, lenses and tags.
    pub considered: Option<Box<ConsiderStates>>,
    /// Share of the information that the last views brought.
    pub information_gain: f64,
}

impl ObjectState {
    /// The linear velocity in m/s.
    pub fn velocity(&self) -> Vector3<f64> {
        self.twist.fixed_rows::<3>(0).into_owned()
    }

    /// The angular velocity in rad/s.
    pub fn angular_velocity(&self) -> Vector3<f64> {
        self.twist.fixed_rows::<3>(3).into_owned()
    }

    /// The state after `dt` seconds.
    ///
    /// t' = t + v dt, R' = exp(w dt) R. With R_estimate = exp(dr) R_true the error follows
    /// dr' = exp(w dt) dr + J_l(w dt) dt dw (Sola et al. 2018, A micro Lie theory, eqs. 67, 71, 94).
    pub fn predicted(&self, dt: f64) -> Self {
        let process_noise_psd = self.motion.process_noise_psd(dt);
        let turn = self.angular_velocity() * dt;
        let rotation = so3::exp(&turn);
        let mut pose = self.pose;
        pose.translation.vector += self.velocity() * dt;
        pose.rotation = rotation * pose.rotation;
        pose.rotation.renormalize_fast();
        let mut state = Self {
            pose,
            ..self.clone()
        };
        state.carry(
            &rotation.to_rotation_matrix().into_inner(),
            &(so3::left_jacobian(&turn) * dt),
            dt,
        );
        state.covariance += white_acceleration(dt, process_noise_psd);
        state.motion.advance(dt);
        if let Some(clocks) = &mut state.clocks {
            clocks.wander(dt, process_noise_psd.clocks);
        }
        state
    }

    /// F P Fᵀ with F = [I 0 dt 0; 0 E 0 G; 0 0 I 0; 0 0 0 I].
    fn carry(&mut self, turn: &Matrix3<f64>, gain: &Matrix3<f64>, dt: f64) {
        if let Some(considered) = &mut self.considered {
            considered.carry(turn, gain, dt);
        }
        carry(&mut self.covariance, turn, gain, dt);
        self.covariance.transpose_mut();
        carry(&mut self.covariance, turn, gain, dt);
        self.covariance = symmetric(&self.covariance);
        if let Some(clocks) = &mut self.clocks {
            carry(&mut clocks.cross, turn, gain, dt);
        }
        if let Some(joints) = &mut self.joints {
            carry(&mut joints.cross, turn, gain, dt);
            joints.advance(dt, self.motion.persistence(dt));
        }
    }

    /// Whether every number of it is finite.
    pub fn is_finite(&self) -> bool {
        let place = self.pose.translation.vector.as_slice();
        let numbers = [
            place,
            self.pose.rotation.coords.as_slice(),
            self.twist.as_slice(),
            self.covariance.as_slice(),
        ];
        numbers.into_iter().flatten().all(|x| x.is_finite())
            && self.clocks_are_finite()
            && self.joints.as_ref().is_none_or(|joints| joints.is_finite())
    }
}

impl ObjectState {
    /// Makes the camera's offset a part of the state, if there is room and it is not one already.
    pub fn know_clock(&mut self, camera_index: usize, prior: ClockOffset) {
        let clocks = self.clocks.get_or_insert_default();
        let slot = clocks.cameras.len();
        if clocks.slot(camera_index).is_none() && slot < MOST_CLOCKS {
            clocks.cameras.push(camera_index);
            clocks.offset[slot] = prior.offset_s;
            clocks.own[(slot, slot)] = prior.sigma_s.powi(2);
        }
    }

    /// Offset and its sigma of each camera, in seconds.
    pub fn clock_offsets(&self) -> Vec<(usize, ClockOffset)> {
        let Some(clocks) = self.clocks.as_deref() else {
            return Vec::new();
        };
        let covariance = clocks.own + self.clock_bias_covariance();
        let off = |(slot, camera): (usize, usize)| {
            let offset_s = clocks.offset[slot];
            let sigma_s = covariance[(slot, slot)].max(0.0).sqrt();
            (camera, ClockOffset { offset_s, sigma_s })
        };
        clocks.cameras().enumerate().map(off).collect()
    }

    /// Whether every number of the offsets is finite.
    pub(crate) fn clocks_are_finite(&self) -> bool {
        self.clocks.as_ref().is_none_or(|clocks| clocks.is_finite())
    }
}

impl ObjectState {
    /// Where root and joints are.
    pub fn configuration(&self) -> Configuration {
        let mut at = Configuration::rigid(&self.pose);
        at.rates.twist = self.twist;
        if let Some(joints) = &self.joints {
            (at.root, at.joints) = (joints.root, joints.values);
            at.rates.speeds = joints.speeds;
        }
        at
    }
}

impl ObjectState {
    /// Updates the sensitivities to constant errors.
    pub fn consider<const D: usize>(&mut self, gain: &UpdateGain<D>, parts: &[BiasGradient<D>]) {
        let considered = self.considered.get_or_insert_default();
        considered.take(gain, parts, self.clocks.as_deref());
        considered.forget(&self.covariance.diagonal(), parts);
    }

    /// Factor from the covariance of the filter to the published one, for the share that the last views brought.
    pub fn covariance_inflation(&self) -> f64 {
        1.0 + (OF_FISHER - 1.0) * self.information_gain
    }

    /// Covariance of the pose with that of constant errors.
    pub fn pose_covariance(&self) -> Matrix6<f64> {
        let own = self.covariance.fixed_view::<6, 6>(0, 0).into_owned();
        own * self.covariance_inflation() + self.bias_covariance::<6>()
    }

    /// Covariance of the clock offsets by constant errors.
    pub(crate) fn clock_bias_covariance(&self) -> Own {
        let sources = self.considered.iter().flat_map(|all| &all.sources);
        let caused = |one: &ConsiderState| {
            let of_clocks = one.of_clocks.as_deref()?;
            Some(of_clocks * Matrix6::from_diagonal(&one.variance) * of_clocks.transpose())
        };
        sources.filter_map(caused).sum()
    }

    /// Covariance of the configuration by constant errors.
    pub fn bias_covariance<const D: usize>(&self) -> SMatrix<f64, D, D> {
        let considered = self.considered.as_ref();
        considered.map_or_else(SMatrix::zeros, |considered| considered.covariance())
    }
}
