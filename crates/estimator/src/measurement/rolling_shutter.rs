//! Shutters that roll: every row of an image has its own time.
//!
//! A corner in row v was taken (v - (rows - 1) / 2) line delays after the capture time, which is that of the middle
//! row: the middle of the whole exposure. The object went on by its twist meanwhile, T' = T after exp(twist tau) as
//! predictions have it, so that the corner tells about the twist as well (Oth, Furgale, Kneip, Siegwart 2013, Rolling
//! shutter camera calibration, sec. 3, with a constant twist over the few milliseconds of an image). With dt' = dt +
//! tau dv and dr' = E dr + tau J_l(w tau) dw the derivatives follow by the chain rule.

use nalgebra::{Matrix3, Matrix6, Point2, RowVector3, Vector6};
use sextant_geometry::{Pose, so3};

use crate::measurement::whitening::{PoseRows, Rows, Slopes, product};

/// Row times of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RollingShutter {
    /// Seconds from a row to the next.
    pub line_delay_s: f64,
    /// The row whose time is the capture time.
    pub middle_row: f64,
}

impl RollingShutter {
    /// Seconds from the capture time to the time of each corner's row. That of the corner as it was found, for it
    /// misses the true one by a part of a row.
    pub fn after_s(&self, corners: &[Point2<f64>; 4]) -> [f64; 4] {
        corners.map(|corner| (corner.y - self.middle_row) * self.line_delay_s)
    }
}

/// A link and how it moves.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinkMotion {
    pub pose: Pose,
    /// m/s and rad/s, world axes; `None` where all corners have one time.
    pub twist: Option<Vector6<f64>>,
}

/// Motion of a link from the capture time to the time of a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RowPose {
    pub pose: Pose,
    /// Derivatives of the attitude reached by the attitude before and by the angular velocity.
    by_attitude: Matrix3<f64>,
    by_rate: Matrix3<f64>,
    after_s: f64,
}

impl RowPose {
    pub fn of(pose: &Pose, twist: &Vector6<f64>, after_s: f64) -> Self {
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

    /// Derivatives by the pose reached as derivatives by pose and twist before.
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

/// Normal equations of a view about the twist of its link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TwistEquations {
    /// J_pose^T W J_twist.
    pub with_pose: Matrix6<f64>,
    /// J_twist^T W J_twist.
    pub information: Matrix6<f64>,
    /// J_twist^T W r.
    pub gradient: Vector6<f64>,
}

impl TwistEquations {
    /// Of whitened rows.
    pub fn of(by_pose: &PoseRows, by_twist: &Rows<6>) -> Self {
        let with_rows = product(by_pose, by_twist);
        Self {
            with_pose: with_rows.fixed_rows::<6>(0).into_owned(),
            information: product(by_twist, by_twist),
            gradient: with_rows.row(6).transpose(),
        }
    }

    /// Sum of two.
    pub fn joined(&self, other: &Self) -> Self {
        Self {
            with_pose: self.with_pose + other.with_pose,
            information: self.information + other.information,
            gradient: self.gradient + other.gradient,
        }
    }

    /// With a weight, and a factor on the information besides.
    pub fn weighed(&self, weight: f64, certain: f64) -> Self {
        Self {
            with_pose: self.with_pose * (weight * certain),
            information: self.information * (weight * certain),
            gradient: self.gradient * weight,
        }
    }
}
