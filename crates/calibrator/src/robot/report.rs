//! The report on a calibrated robot.

use super::solution::RobotSolution;
use super::{RobotError, RobotSession};
use crate::verdict::Verdict;
use nalgebra::{Matrix6, Vector3};
use serde::Serialize;
use sextant_adjustment::{Arm, ArmPose, KeptParameter, Mount};
use sextant_geometry::{Pose, PoseParts, so3};

/// Result of a hand-eye calibration, with its accuracy.
#[derive(Clone, Debug)]
pub struct CalibratedRobot {
    /// Maps points of the world into the robot's base. Where the hand carries the camera, the world is the frame of the
    /// object that lies still.
    pub base_from_world: Pose,
    /// Its covariance (x, y, z, rx, ry, rz) along the base's axes, m and rad; a step of FRAMES.md.
    pub base_covariance: Matrix6<f64>,
    /// Maps points of what the hand carries, an object or a camera, into the hand.
    pub hand_from_carried: Pose,
    /// Its covariance along the hand's axes.
    pub hand_covariance: Matrix6<f64>,
    /// Accuracy and verdict.
    pub report: RobotReport,
}

/// Accuracy and verdict of a calibrated robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobotReport {
    /// Images received.
    pub images: usize,
    /// Poses of the robot that were used.
    pub poses: usize,
    /// Image numbers (from 0) of poses that contradict the others and have almost no weight.
    pub outliers: Vec<usize>,
    /// Maps points of the world into the robot's base.
    pub base_from_world: PoseParts,
    /// Maps points of what the hand carries into the hand.
    pub hand_from_carried: PoseParts,
    /// Root mean square over the axes of the base's standard deviation at the middle of the poses or, where the hand
    /// carries the camera, of the tags that it sees; millimetres and degrees.
    pub base_sigma_mm: f64,
    /// See [`Self::base_sigma_mm`].
    pub base_sigma_deg: f64,
    /// Root mean square over the axes of the standard deviation of what the hand carries, millimetres and degrees.
    pub hand_sigma_mm: f64,
    /// See [`Self::hand_sigma_mm`].
    pub hand_sigma_deg: f64,
    /// Standard deviation per axis of the robot's poses, as far as images and robot disagree, millimetres and degrees.
    pub robot_sigma_mm: f64,
    /// See [`Self::robot_sigma_mm`].
    pub robot_sigma_deg: f64,
    /// Errors of poses that were left out.
    pub held_out: Option<HeldOut>,
    /// The robot's clock minus that of the images, ms; `None` for poses by image or of exactly the images' times.
    pub clock_offset_ms: Option<f64>,
    /// Its standard deviation, ms; `None` where too few poses move.
    pub clock_sigma_ms: Option<f64>,
    /// Corners of all tags, px.
    pub rms_px: f64,
    /// What the motions do not determine, with the remedy.
    pub undetermined: Vec<String>,
    /// The verdict.
    pub verdict: Verdict,
}

/// Root mean squares of the errors of poses that a robot solved without them predicts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// Number of poses.
    pub poses: usize,
    /// Distance, millimetres.
    pub rms_mm: f64,
    /// Angle, degrees.
    pub rms_deg: f64,
    /// Distance of the corners in the image, px.
    pub rms_px: f64,
    /// Median distance, millimetres, which no single wrong pose moves.
    pub median_mm: f64,
    /// Median angle, degrees.
    pub median_deg: f64,
}

impl HeldOut {
    /// From distances (m), angles (rad) and corners (px).
    pub(super) fn from_errors(errors: &[[f64; 3]]) -> Option<Self> {
        let n = errors.len();
        let of = |part: usize| {
            let mut values: Vec<f64> = errors.iter().map(|error| error[part]).collect();
            values.sort_by(f64::total_cmp);
            let squares: f64 = values.iter().map(|value| value * value).sum();
            Some(((squares / n as f64).sqrt(), *values.get(n / 2)?))
        };
        let (distance, angle, corners) = (of(0)?, of(1)?, of(2)?);
        Some(Self {
            poses: n,
            rms_mm: 1e3 * distance.0,
            rms_deg: angle.0.to_degrees(),
            rms_px: corners.0,
            median_mm: 1e3 * distance.1,
            median_deg: angle.1.to_degrees(),
        })
    }
}

impl RobotSession {
    pub(super) fn finish(&self, solution: RobotSolution) -> Result<CalibratedRobot, RobotError> {
        let arm = solution.arm()?;
        let covariance = &solution.adjusted.solution.covariance;
        let of = |pose| covariance.arm(pose).unwrap_or_else(Matrix6::zeros);
        let (base, hand) = (of(ArmPose::Base), of(ArmPose::Hand));
        let (base_sigma_mm, base_sigma_deg) = sigmas(&at_middle(&base, &solution, arm));
        let (hand_sigma_mm, hand_sigma_deg) = sigmas(&hand);
        let delay_sigma_s = covariance.sigma(KeptParameter::ArmDelay);
        let mut report = RobotReport {
            images: self.n_received(),
            poses: solution.used().count(),
            outliers: solution.outliers(),
            base_from_world: (&arm.base_from_site).into(),
            hand_from_carried: (&arm.hand_from_carried).into(),
            base_sigma_mm,
            base_sigma_deg,
            hand_sigma_mm,
            hand_sigma_deg,
            robot_sigma_mm: 1e3 * arm.sigma.position_m,
            robot_sigma_deg: arm.sigma.orientation_rad.to_degrees(),
            held_out: self.held_out(&solution),
            clock_offset_ms: (arm.delay_s != 0.0).then_some(1e3 * arm.delay_s),
            clock_sigma_ms: delay_sigma_s.map(|sigma_s| 1e3 * sigma_s),
            rms_px: solution.adjusted.solution.rms_px,
            undetermined: Vec::new(),
            verdict: Verdict::new(),
        };
        self.judge(&solution, arm, &mut report);
        Ok(CalibratedRobot {
            base_from_world: arm.base_from_site,
            base_covariance: base,
            hand_from_carried: arm.hand_from_carried,
            hand_covariance: hand,
            report,
        })
    }
}

/// The covariance of the base as that of the middle of the poses, or of the tags that lie still, in the base: the
/// site's origin may be far away, and turns of the base move it.
fn at_middle(base: &Matrix6<f64>, solution: &RobotSolution, arm: &Arm) -> Matrix6<f64> {
    let bundle = &solution.adjusted.solution.bundle;
    let positions: Vec<Vector3<f64>> = match arm.mount {
        Mount::Object => solution
            .agreeing_hands(arm)
            .map(|hand| {
                (hand.base_from_hand * arm.hand_from_carried)
                    .translation
                    .vector
            })
            .collect(),
        Mount::Camera => {
            let seen = bundle.images.iter().flat_map(|image| &image.tags);
            seen.map(|seen| {
                (arm.base_from_site * bundle.tags[seen.tag].object_from_tag)
                    .translation
                    .vector
            })
            .collect()
        }
    };
    let middle = positions.iter().sum::<Vector3<f64>>() / positions.len().max(1) as f64;
    let lever = middle - arm.base_from_site.translation.vector;
    let mut by_step = Matrix6::identity();
    by_step
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-so3::hat(&lever));
    by_step * base * by_step.transpose()
}

/// Root mean squares over the axes, mm and degrees.
fn sigmas(covariance: &Matrix6<f64>) -> (f64, f64) {
    let of = |first: usize| {
        let sum: f64 = (first..first + 3).map(|k| covariance[(k, k)]).sum();
        (sum / 3.0).max(0.0).sqrt()
    };
    (1e3 * of(0), of(3).to_degrees())
}
