//! Whether a robot's poses are written otherwise than they are read: of the base in the hand, with the scalar of the
//! quaternion first, in other units of length, or shifted against the images.
//!
//! Poses that contradict the images are read in each of these ways and solved in full. A way explains them where both
//! the position and the attitude left are less, one of them by several times, and the likelihood by far more than its
//! odds.

use super::poses::RobotPoses;
use super::solution::RobotMisfit;
use super::{RobotError, RobotSession};
use nalgebra::{Quaternion, UnitQuaternion};
use sextant_geometry::Pose;
use std::fmt;

/// A way to read a robot's poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseReading {
    /// Whether they are of the base in the hand, not of the hand in the base.
    pub is_inverse: bool,
    /// Whether the first number of their quaternions is the scalar.
    pub is_scalar_first: bool,
    /// Metres in a unit of length.
    pub metres: f64,
    /// By how many poses they come after those of their images; negative for before.
    pub late: i64,
}

impl PoseReading {
    /// As they are asked for.
    pub const AS_GIVEN: Self = Self {
        is_inverse: false,
        is_scalar_first: false,
        metres: 1.0,
        late: 0,
    };
}

/// Units of length that are tried, m: metres, and numbers in millimetres read as metres, and in metres as millimetres.
const UNITS: [f64; 3] = [1.0, 1e-3, 1e3];
/// Most poses by which they may be shifted.
const MOST_SHIFT: i64 = 3;
/// Logarithm of the odds against each peculiarity, and of the gain that decides.
const ODDS: f64 = 3.0;
const DECISIVE: f64 = 7.0;
/// What is left of position or attitude is less by this factor.
const SEVERAL_TIMES: f64 = 4.0;
/// Fewer poses fit in many ways.
const LEAST_POSES: usize = 6;
/// Misfits below these are no reason to read otherwise, mm and degrees.
const CONTRADICTING: [f64; 2] = [2.0, 0.4];
/// Least misfits that count, mm and degrees: of numbers with few digits.
const LEAST_MISFIT: [f64; 2] = [0.01, 0.001];

impl RobotSession {
    /// The way of reading that explains poses which contradict the images as they are read; `None` if they do not, or
    /// nothing explains them.
    pub(super) fn other_reading(
        &self,
        poses: &RobotPoses,
        as_given: Option<RobotMisfit>,
    ) -> Option<RobotError> {
        let is_fine =
            |found: &RobotMisfit| found.mm < CONTRADICTING[0] && found.deg < CONTRADICTING[1];
        if as_given.as_ref().is_some_and(is_fine) {
            return None;
        }
        let as_given = as_given.unwrap_or(RobotMisfit::WORST);
        let found = readings().filter_map(|reading| {
            let misfit = self.misfit(&reading.read(poses)).ok()?;
            let gain = misfit.gain_over(&as_given)? - ODDS * reading.n_peculiarities();
            (gain > DECISIVE).then_some((gain, reading, misfit))
        });
        let (_, reading, misfit) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(RobotError::OtherReading {
            reading,
            mm: misfit.mm,
            deg: misfit.deg,
            mm_as_given: as_given.mm,
            deg_as_given: as_given.deg,
        })
    }
}

impl RobotMisfit {
    /// Where nothing fits.
    const WORST: Self = Self {
        poses: usize::MAX,
        mm: 1e3,
        deg: 180.0,
    };

    /// Gain of the logarithm of the likelihood; `None` where the other one is not worse by several times.
    fn gain_over(&self, other: &Self) -> Option<f64> {
        let least = |value: f64, at: usize| value.max(LEAST_MISFIT[at]);
        let ratios = [
            least(other.mm, 0) / least(self.mm, 0),
            least(other.deg, 1) / least(self.deg, 1),
        ];
        let enough =
            self.poses >= LEAST_POSES && 2 * self.poses > other.poses.min(2 * self.poses - 1);
        let [worse, better] = [ratios[0].min(ratios[1]), ratios[0].max(ratios[1])];
        let gain = 3.0 * self.poses as f64 * ratios.iter().map(|ratio| ratio.ln()).sum::<f64>();
        (enough && worse > 0.5 && better > SEVERAL_TIMES).then_some(gain)
    }
}

/// Every other way: of one pose at a time alone or with others, shifts alone.
fn readings() -> impl Iterator<Item = PoseReading> {
    let flags = [false, true];
    let written = flags.into_iter().flat_map(move |is_inverse| {
        flags.into_iter().flat_map(move |is_scalar_first| {
            UNITS.map(|metres| PoseReading {
                is_inverse,
                is_scalar_first,
                metres,
                late: 0,
            })
        })
    });
    let shifts = (-MOST_SHIFT..=MOST_SHIFT).map(|late| PoseReading {
        late,
        ..PoseReading::AS_GIVEN
    });
    written
        .chain(shifts)
        .filter(|reading| *reading != PoseReading::AS_GIVEN)
}

impl PoseReading {
    fn n_peculiarities(&self) -> f64 {
        let flags = [
            self.is_inverse,
            self.is_scalar_first,
            self.metres != 1.0,
            self.late != 0,
        ];
        flags.into_iter().filter(|is| *is).count() as f64
    }

    fn read(&self, poses: &RobotPoses) -> RobotPoses {
        let (RobotPoses::ByTime(own) | RobotPoses::ByImage(own)) = poses;
        let keys: Vec<u64> = own.keys().copied().collect();
        let key = |at: usize| {
            keys.get(at.checked_add_signed(-self.late as isize)?)
                .copied()
        };
        let read = own.values().enumerate();
        let read = read.filter_map(|(at, pose)| Some((key(at)?, self.pose(pose))));
        match poses {
            RobotPoses::ByTime(_) => RobotPoses::ByTime(read.collect()),
            RobotPoses::ByImage(_) => RobotPoses::ByImage(read.collect()),
        }
    }

    fn pose(&self, given: &Pose) -> Pose {
        let mut pose = *given;
        pose.translation.vector *= self.metres;
        if self.is_scalar_first {
            let [w, x, y, z]: [f64; 4] = given.rotation.coords.into();
            pose.rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        }
        match self.is_inverse {
            true => pose.inverse(),
            false => pose,
        }
    }
}

impl fmt::Display for PoseReading {
    /// What is the matter, and what to do.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mut what, mut remedy) = (Vec::new(), Vec::new());
        if self.is_inverse {
            what.push("of the base in the hand (inverse)".to_owned());
            remedy.push("write those of the hand in the base".to_owned());
        }
        if self.is_scalar_first {
            what.push("with w as the first number of the quaternion".to_owned());
            remedy.push("name the columns qw,qx,qy,qz in this order, or write x,y,z,w".to_owned());
        }
        if self.metres < 1.0 {
            what.push("in millimetres".to_owned());
            remedy
                .push("name the columns `x [mm]`, `y [mm]`, `z [mm]`, or write metres".to_owned());
        }
        if self.metres > 1.0 {
            what.push("in metres, not in millimetres".to_owned());
            remedy.push("name the columns `x [m]`, `y [m]`, `z [m]`".to_owned());
        }
        if self.late != 0 {
            let n = self.late.abs();
            let (poses, side) = (
                if n == 1 { "pose" } else { "poses" },
                if self.late > 0 { "after" } else { "before" },
            );
            what.push(format!("each {n} {poses} {side} that of its image"));
            remedy.push(
                "write beside each the number of its image, from 0, with those that show nothing"
                    .to_owned(),
            );
        }
        write!(f, "{}: {}", what.join(", and "), remedy.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector3};
    use std::collections::BTreeMap;

    #[test]
    fn each_reading_is_tried_once() {
        let all: Vec<PoseReading> = readings().collect();
        assert_eq!(all.len(), 11 + 6);
        assert!(!all.contains(&PoseReading::AS_GIVEN));
    }

    #[test]
    fn poses_that_are_late_are_moved_to_the_images_before() {
        let pose = |k: u64| Isometry3::translation(k as f64, 0.0, 0.0);
        let late: BTreeMap<u64, Pose> = (1..9).map(|k| (k, pose(k - 1))).collect();
        let reading = PoseReading {
            late: 1,
            ..PoseReading::AS_GIVEN
        };
        let RobotPoses::ByImage(read) = reading.read(&RobotPoses::ByImage(late)) else {
            panic!("other keys")
        };
        assert!(read.iter().all(|(k, found)| *found == pose(*k)), "{read:?}");
    }

    #[test]
    fn a_scalar_first_quaternion_is_put_in_order() {
        let truth = Isometry3::new(Vector3::z(), Vector3::new(0.3, -0.2, 0.9));
        let [x, y, z, w]: [f64; 4] = truth.rotation.coords.into();
        let mut given = truth;
        given.rotation = UnitQuaternion::from_quaternion(Quaternion::new(z, w, x, y));
        let reading = PoseReading {
            is_scalar_first: true,
            ..PoseReading::AS_GIVEN
        };
        assert!(reading.pose(&given).rotation.angle_to(&truth.rotation) < 1e-12);
    }
}
