//! The pose of a body some time after an instant: at the capture time of an image, and at the time of a row where the
//! shutter rolls.
//!
//! With a constant twist `(v, w)` in world axes the pose `tau` seconds later is `(t + v tau, exp(w tau) R)`. For small
//! steps of the earlier pose and twist, `dt' = dt + tau dv` and `dr' = exp(w tau) dr + tau J_l(w tau) dw` (J. Sola et
//! al., A micro Lie theory, 2018, eq. 145; for shutters: L. Oth, P. Furgale, L. Kneip, R. Siegwart, Rolling shutter
//! camera calibration, CVPR 2013, with a constant twist over an image).

use nalgebra::{Matrix3, RowVector3, Vector6};
use sextant_geometry::{Pose, so3};

/// Derivatives of x and of y of a pixel by a step `(dt, dr)` of a pose, or by a twist.
pub type Slopes = [[f64; 6]; 2];

/// A body some time after an instant, with the derivatives by its pose and twist there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaterPose {
    /// World from body.
    pub pose: Pose,
    /// Derivative of the later attitude by the earlier one.
    by_attitude: Matrix3<f64>,
    /// By the angular velocity, s.
    by_rate: Matrix3<f64>,
    after_s: f64,
}

impl LaterPose {
    /// The pose `after_s` seconds later by a twist, m/s and rad/s in world axes.
    #[inline]
    pub fn new(pose: &Pose, twist: &Vector6<f64>, after_s: f64) -> Self {
        let turn = twist.fixed_rows::<3>(3) * after_s;
        let rotation = so3::exp(&turn);
        let place = pose.translation.vector + twist.fixed_rows::<3>(0) * after_s;
        Self {
            pose: Pose::from_parts(place.into(), rotation * pose.rotation),
            by_attitude: rotation.to_rotation_matrix().into_inner(),
            by_rate: so3::left_jacobian(&turn) * after_s,
            after_s,
        }
    }

    /// Derivatives by the later pose as derivatives by the pose and by the twist before.
    #[inline]
    pub fn before(&self, by_pose: &Slopes) -> (Slopes, Slopes) {
        let (mut pose, mut twist) = (*by_pose, *by_pose);
        for (axis, slopes) in by_pose.iter().enumerate() {
            let turn = RowVector3::from_row_slice(&slopes[3..]);
            let (by_attitude, by_rate) = (turn * self.by_attitude, turn * self.by_rate);
            for n in 0..3 {
                pose[axis][3 + n] = by_attitude[n];
                twist[axis][n] = slopes[n] * self.after_s;
                twist[axis][3 + n] = by_rate[n];
            }
        }
        (pose, twist)
    }
}
