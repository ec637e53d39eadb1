//! A solved robot before its report.

use super::RobotError;
use crate::adjustment::AdjustmentResult;
use crate::image_store::ImageView;
use sextant_adjustment::{Arm, ArmResidual, Hand};

/// A solved robot before its report.
pub(super) struct RobotSolution {
    pub views: Vec<ImageView>,
    /// Number of each view among the images of its camera.
    pub numbers: Vec<usize>,
    pub adjusted: AdjustmentResult,
}

/// What is left of a robot's poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RobotMisfit {
    /// Poses that agree with one another.
    pub poses: usize,
    /// Standard deviation per axis, millimetres.
    pub mm: f64,
    /// Standard deviation per axis, degrees.
    pub deg: f64,
}

/// Chi-square of six numbers above which a pose of the robot contradicts the others: five sigma.
const OUTLIER: f64 = 45.0;

impl RobotSolution {
    /// The robot, which every solution has.
    pub(super) fn arm(&self) -> Result<&Arm, RobotError> {
        let arm = self.adjusted.solution.bundle.arm.as_ref();
        arm.ok_or(RobotError::NoStart)
    }

    /// What is left of its poses.
    pub(super) fn misfit(&self) -> Result<RobotMisfit, RobotError> {
        let arm = self.arm()?;
        Ok(RobotMisfit {
            poses: self.agreeing_hands(arm).count(),
            mm: 1e3 * arm.sigma.position_m,
            deg: arm.sigma.orientation_rad.to_degrees(),
        })
    }

    /// Poses of the robot with an image of which a tag is used, in order of their instants.
    pub(super) fn used(&self) -> impl Iterator<Item = &ArmResidual> + Clone {
        let residuals = self.adjusted.solution.arm.iter();
        residuals.filter(|residual| {
            let mut images = self.adjusted.used();
            images.any(|image| image.instant == residual.instant)
        })
    }

    /// The hands of poses that agree with the others.
    pub(super) fn agreeing_hands<'a>(
        &'a self,
        arm: &'a Arm,
    ) -> impl Iterator<Item = &'a Hand> + Clone {
        let agreeing = self.used().filter(|pose| pose.chi_square <= OUTLIER);
        agreeing.filter_map(|pose| arm.hands[pose.instant].as_ref())
    }

    /// Numbers of the images of poses that contradict the others.
    pub(super) fn outliers(&self) -> Vec<usize> {
        let outliers = self.used().filter(|pose| pose.chi_square > OUTLIER);
        let numbers = outliers.filter_map(|pose| {
            let mut images = self.adjusted.used();
            let image = images.find(|image| image.instant == pose.instant)?;
            Some(self.numbers[image.view])
        });
        numbers.collect()
    }
}
