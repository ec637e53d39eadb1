//! Poses, and the one place that knows how a pose is written down: position in metres, quaternion as x, y, z, w.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// A rigid motion, named `a_from_b`: it maps points of frame b into frame a.
pub type Pose = Isometry3<f64>;

/// How far from one a written quaternion's length may be: people write 0.707.
const NORM_TOLERANCE: f64 = 0.01;

/// A length that differs from one by no more than this is rounding.
const UNIT_ROUNDING: f64 = 1e-14;

/// The rotation of a quaternion of about unit length. One that is normalised already keeps every digit, so that a pose
/// that is written and read again is the same pose.
pub fn unit_quaternion(quaternion: Quaternion<f64>) -> UnitQuaternion<f64> {
    if (quaternion.norm() - 1.0).abs() <= UNIT_ROUNDING {
        UnitQuaternion::new_unchecked(quaternion)
    } else {
        UnitQuaternion::new_normalize(quaternion)
    }
}

/// A pose as written in files and messages: `{ position = [x, y, z], orientation = [x, y, z, w] }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseParts {
    /// Metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

/// Why written numbers are no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// A position that is NaN or infinite.
    #[error("position {0:?} is not finite; write three finite numbers in metres")]
    Position([f64; 3]),
    /// A quaternion that is not finite or whose length is not one.
    #[error(
        "orientation {0:?} is not a unit quaternion; write x, y, z, w with length 1, no rotation is [0, 0, 0, 1]"
    )]
    Orientation([f64; 4]),
}

impl PoseParts {
    /// The pose, its quaternion normalised. Refuses what is not finite and a quaternion 1 % or more off unit length.
    pub fn to_pose(&self) -> Result<Pose, PoseError> {
        if !self.position.iter().all(|x| x.is_finite()) {
            return Err(PoseError::Position(self.position));
        }
        let [x, y, z, w] = self.orientation;
        let quaternion = Quaternion::new(w, x, y, z);
        let off_unit = (quaternion.norm() - 1.0).abs();
        if off_unit.is_nan() || off_unit >= NORM_TOLERANCE {
            return Err(PoseError::Orientation(self.orientation));
        }
        let rotation = unit_quaternion(quaternion);
        Ok(Isometry3::from_parts(
            Translation3::from(Vector3::from(self.position)),
            rotation,
        ))
    }
}

impl From<&Pose> for PoseParts {
    fn from(pose: &Pose) -> Self {
        let q = &pose.rotation;
        Self {
            position: pose.translation.vector.into(),
            orientation: [q.i, q.j, q.k, q.w],
        }
    }
}

impl TryFrom<PoseParts> for Pose {
    type Error = PoseError;

    fn try_from(parts: PoseParts) -> Result<Self, PoseError> {
        parts.to_pose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    #[test]
    fn parts_and_pose_are_inverse() {
        let parts = PoseParts {
            position: [1.0, -2.0, 3.0],
            orientation: [0.5, -0.5, 0.5, 0.5],
        };
        assert_eq!(PoseParts::from(&parts.to_pose().unwrap()), parts);
    }

    #[test]
    fn a_rounded_quaternion_is_normalised() {
        let parts = PoseParts {
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.707, 0.707],
        };
        let angle = parts.to_pose().unwrap().rotation.angle();
        assert!((angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_pose_is_refused() {
        let position = PoseParts {
            position: [f64::NAN, 0.0, 0.0],
            orientation: NONE,
        };
        assert!(matches!(position.to_pose(), Err(PoseError::Position(_))));
        for orientation in [
            [0.0; 4],
            [f64::NAN; 4],
            [f64::INFINITY, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 2.0],
        ] {
            let parts = PoseParts {
                position: [0.0; 3],
                orientation,
            };
            assert!(
                matches!(parts.to_pose(), Err(PoseError::Orientation(_))),
                "{orientation:?}"
            );
        }
    }

    #[test]
    fn unknown_keys_are_refused() {
        let text = "position = [0, 0, 0]\norientation = [0, 0, 0, 1]\nscale = 2";
        assert!(toml::from_str::<PoseParts>(text).is_err());
    }
}
