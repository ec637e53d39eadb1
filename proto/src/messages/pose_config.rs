//! Poses and their standard deviations, as rigs and objects give them.

use crate::check::{self, OutOfRange};
use serde::{Deserialize, Serialize};

/// A rigid motion `a_from_b`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseConfig {
    /// b's origin in a, metres.
    pub position: [f64; 3],
    /// b's axes in a, x, y, z, w.
    pub orientation: [f64; 4],
}

/// Standard deviations of a pose, the same along each axis; 0 where the pose is exact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SigmaConfig {
    /// Of the position, metres.
    pub position_m: f64,
    /// Of the orientation, radians.
    pub orientation_rad: f64,
}

impl PoseConfig {
    pub(crate) fn check(pose: Option<Self>, field: &'static str) -> Result<(), OutOfRange> {
        let Some(pose) = pose else { return Ok(()) };
        check::placement(pose.position, field)?;
        check::orientation(pose.orientation, field)
    }
}

impl SigmaConfig {
    pub(crate) fn check(sigma: Option<Self>, field: &'static str) -> Result<(), OutOfRange> {
        let Some(sigma) = sigma else { return Ok(()) };
        check::amount(sigma.position_m, field)?;
        check::amount(sigma.orientation_rad, field)
    }
}
