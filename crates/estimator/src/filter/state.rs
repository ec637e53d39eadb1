//! Pose, twist and their covariance; prediction with constant twist and white acceleration.
//!
//! State: `world_from_object` and the twist (velocity of the object's origin, angular velocity), all in world axes.
//! Error: (dt, dr, dv, dw) with t_estimate = t_true + dt, R_estimate = exp(dr) R_true; dt and dr as FRAMES.md has them.

use nalgebra::{Matrix3, SMatrix, Vector3, Vector6};
use sextant_geometry::{Pose, so3};

use crate::filter::clock_states::Clocks;
use crate::filter::consider::Considered;
use crate::filter::joint_states::Joints;
use crate::filter::process_noise::{Motion, Restlessness};

/// Covariance over (dt, dr, dv, dw).
pub(crate) type Covariance = SMatrix<f64, 12, 12>;

/// How a body moves, and how well that is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kinematics {
    /// World from object, or from the root among its links.
    pub pose: Pose,
    /// Velocity of its origin in m/s, then angular velocity in rad/s, world axes.
    pub twist: Vector6<f64>,
    /// Over (dt, dr, dv, dw).
    pub covariance: Covariance,
    /// The cameras' clocks, where they are not taken at their word.
    pub clocks: Option<Box<Clocks>>,
    /// The joints, where the object has links.
    pub joints: Option<Box<Joints>>,
    /// How restless the body is.
    pub motion: Motion,
    /// What errors of the cameras' poses did to it, where these are stated.
    pub considered: Option<Box<Considered>>,
    /// Share of what is known that the last views brought.
    pub news: f64,
}

impl Kinematics {
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
        let restlessness = self.motion.restlessness(dt);
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
        state.covariance += white_acceleration(dt, restlessness);
        state.motion.advance(dt);
        if let Some(clocks) = &mut state.clocks {
            clocks.wander(dt, restlessness.clocks);
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

/// F times a matrix, column by column.
pub(crate) fn carry<const N: usize>(
    matrix: &mut SMatrix<f64, 12, N>,
    turn: &Matrix3<f64>,
    gain: &Matrix3<f64>,
    dt: f64,
) {
    let columns: &mut [[f64; 12]; N] = &mut matrix.data.0;
    for column in columns {
        let dr = Vector3::new(column[3], column[4], column[5]);
        let dw = Vector3::new(column[9], column[10], column[11]);
        let turned = turn * dr + gain * dw;
        for axis in 0..3 {
            column[axis] += column[6 + axis] * dt;
            column[3 + axis] = turned[axis];
        }
    }
}

/// Integral of the white acceleration over `dt` (Bar-Shalom, Li, Kirubarajan 2001, eq. 6.2.2-4).
pub(crate) fn white_acceleration(dt: f64, restlessness: Restlessness) -> Covariance {
    let dt = dt.abs();
    let mut noise = Covariance::zeros();
    for axis in 0..6 {
        let density = if axis < 3 {
            restlessness.linear
        } else {
            restlessness.angular
        };
        noise[(axis, axis)] = density * dt.powi(3) / 3.0;
        noise[(axis, axis + 6)] = density * dt.powi(2) / 2.0;
        noise[(axis + 6, axis)] = noise[(axis, axis + 6)];
        noise[(axis + 6, axis + 6)] = density * dt;
    }
    noise
}

/// Whether a variance along some axis exceeds a limit. The trace bounds the largest eigenvalue from above and the diagonal
/// from below, so that eigenvalues are hardly ever needed.
pub(crate) fn is_wider_than(covariance: &Matrix3<f64>, limit: f64) -> bool {
    covariance.trace() > limit
        && (covariance.diagonal().max() > limit || covariance.symmetric_eigenvalues().max() > limit)
}

/// The symmetric part, so that rounding can't add up.
pub(crate) fn symmetric<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let mut symmetric = *matrix;
    for column in 0..N {
        for row in 0..column {
            let mean = (matrix[(row, column)] + matrix[(column, row)]) * 0.5;
            symmetric[(row, column)] = mean;
            symmetric[(column, row)] = mean;
        }
    }
    symmetric
}
