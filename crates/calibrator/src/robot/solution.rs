//! A solved robot before its report.

use super::RobotError;
use crate::adjustment::AdjustmentResult;
use crate::bundle::Arm;
use crate::image_store::ImageView;

/// A solved robot before its report.
pub(super) struct RobotSolution {
    pub views: Vec<ImageView>,
    /// Number of the image in its camera, and capture time, by instant.
    pub keys: Vec<(usize, u64)>,
    pub adjusted: AdjustmentResult,
}

impl RobotSolution {
    /// The robot, which every solution has.
    pub(super) fn arm(&self) -> Result<&Arm, RobotError> {
        let arm = self.adjusted.solution.bundle.arm.as_ref();
        arm.ok_or(RobotError::NoStart)
    }
}
