//! Verdict on a calibrated robot.

use super::RobotSession;
use super::degeneracy::{Turns, axis_in_words, turns};
use super::report::RobotReport;
use super::solution::RobotSolution;
use crate::verdict::{Finding, Grade};
use sextant_adjustment::{Arm, Mount};

/// Standard deviations below which base and hand are well known (millimetres, degrees); five times as much is usable.
const WELL_KNOWN: [f64; 2] = [0.5, 0.05];
const OF_USE: f64 = 5.0;
/// Fewer poses leave little to check the result by.
const FEW_POSES: usize = 10;
/// A robot and images that disagree by more have an error that is no noise, millimetres and degrees.
const DISAGREEING: [f64; 2] = [2.0, 0.4];
/// Share of poses that contradict the others.
const MANY_OUTLIERS: f64 = 0.1;
/// A focal length that moved by more than this share was wrong.
const LENS_CHANGE: f64 = 0.003;
/// A delay of more standard deviations, and of more than this, is reported, ms.
const DELAYED: (f64, f64) = (4.0, 1.0);

impl RobotSession {
    /// Grade and findings, and what is undetermined.
    pub(super) fn judge(&self, solution: &RobotSolution, arm: &Arm, report: &mut RobotReport) {
        if let Some(cause) = undetermined(solution, arm) {
            let finding = Finding::Unplaced(cause.clone());
            report.undetermined.push(cause);
            report.verdict.add(Grade::Poor, finding);
        }
        self.judge_poses(report);
        judge_robot(report);
        self.judge_lenses(solution, report);
    }

    /// How well base and hand are known, and by how many images and poses.
    fn judge_poses(&self, report: &mut RobotReport) {
        let worst = excess(report.base_sigma_mm, report.base_sigma_deg, WELL_KNOWN).max(excess(
            report.hand_sigma_mm,
            report.hand_sigma_deg,
            WELL_KNOWN,
        ));
        let verdict = &mut report.verdict;
        if worst > 1.0 && report.undetermined.is_empty() {
            let grade = if worst > OF_USE {
                Grade::Poor
            } else {
                Grade::Usable
            };
            verdict.add(grade, Finding::UncertainRobot);
        }
        if self.not_stored > 0 {
            let finding = Finding::ImagesNotStored {
                stored: self.images.len(),
                not_stored: self.not_stored,
            };
            verdict.add(Grade::Usable, finding);
        }
        if report.poses < FEW_POSES {
            verdict.add(Grade::Usable, Finding::FewRobotPoses(report.poses));
        }
    }

    /// Focal lengths that are not those of the rig.
    fn judge_lenses(&self, solution: &RobotSolution, report: &mut RobotReport) {
        let solved = &solution.adjusted.solution.bundle.cameras;
        for (camera, solved) in self.rig.cameras().iter().zip(solved) {
            let [was, is] = [&camera.lens, &solved.lens].map(|lens| lens.intrinsics().fx);
            if (is / was - 1.0).abs() > LENS_CHANGE {
                let camera = camera.id.clone();
                let percent = 100.0 * (is / was - 1.0);
                let finding = Finding::LensDiffers { camera, percent };
                report.verdict.add(Grade::Usable, finding);
            }
        }
    }
}

/// What the turns of the hand leave open, with the remedy.
fn undetermined(solution: &RobotSolution, arm: &Arm) -> Option<String> {
    let carried = match arm.mount {
        Mount::Object => "object",
        Mount::Camera => "camera",
    };
    match turns(solution.agreeing_hands(arm)) {
        Turns::None(rad) => Some(format!(
            "the hand hardly turned ({:.1} degrees): where the {carried} is on the hand and \
             where the base is cannot be told apart; turn the hand about two axes by 30 degrees or more",
            rad.to_degrees()
        )),
        Turns::OneAxis(axis) => Some(format!(
            "the hand turned about {} only: the position of the {carried} along that axis \
             cannot be told apart from that of the base; tilt the hand by 30 degrees or more about another axis",
            axis_in_words(&axis)
        )),
        Turns::Enough => None,
    }
}

/// Agreement of the robot's poses and clock with the images.
fn judge_robot(report: &mut RobotReport) {
    let verdict = &mut report.verdict;
    if !report.outliers.is_empty() {
        let share = report.outliers.len() as f64 / report.poses.max(1) as f64;
        let grade = if share > MANY_OUTLIERS {
            Grade::Usable
        } else {
            Grade::Good
        };
        let images = report.outliers.clone();
        verdict.add(grade, Finding::RobotOutliers(images));
    }
    let (mm, deg) = (report.robot_sigma_mm, report.robot_sigma_deg);
    if excess(mm, deg, DISAGREEING) > 1.0 {
        verdict.add(Grade::Usable, Finding::RobotDisagrees { mm, deg });
    }
    if let (Some(ms), Some(sigma_ms)) = (report.clock_offset_ms, report.clock_sigma_ms)
        && ms.abs() > (DELAYED.0 * sigma_ms).max(DELAYED.1)
    {
        verdict.add(Grade::Good, Finding::RobotClock { ms, sigma_ms });
    }
}

/// Position and orientation as multiples of what they may be, the larger.
fn excess(mm: f64, deg: f64, limit: [f64; 2]) -> f64 {
    (mm / limit[0]).max(deg / limit[1])
}
