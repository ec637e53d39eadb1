//! Shutters that roll: every row of an image has its own time.
//!
//! A corner in row v was taken (v - (rows - 1) / 2) line delays after the capture time, which is that of the middle
//! row: the middle of the whole exposure. The object went on by its twist meanwhile
//! ([`sextant_adjustment::shutter`]), so that the corner informs about the twist as well.

use nalgebra::{Matrix6, Point2, Vector6};
use sextant_geometry::Pose;

use crate::measurement::whitening::{PoseRows, Rows, product};

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
    /// The equations of whitened rows by the pose, with the residuals, and by the twist.
    pub fn from_rows(by_pose: &PoseRows, by_twist: &Rows<6>) -> Self {
        let with_rows = product(by_pose, by_twist);
        Self {
            with_pose: with_rows.fixed_rows::<6>(0).into_owned(),
            information: product(by_twist, by_twist),
            gradient: with_rows.row(6).transpose(),
        }
    }

    /// Sums the equations with those of another view of the link.
    pub fn sum(&self, other: &Self) -> Self {
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
