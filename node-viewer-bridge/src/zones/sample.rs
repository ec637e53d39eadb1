//! A pose as the judgement needs it.

use nalgebra::{Matrix3, Matrix6, Quaternion, UnitQuaternion, Vector3};
use sextant_proto::ObjectPose;
use sextant_site_report::State;

/// `world_from_object` at a capture time.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    /// Capture time, ns since the Unix epoch.
    pub(crate) t_ns: u64,
    /// The object's origin in the world, m.
    pub(crate) position: Vector3<f64>,
    pub(crate) orientation: UnitQuaternion<f64>,
    /// Over (x, y, z, rx, ry, rz) in world axes; m, rad.
    pub(crate) covariance: Matrix6<f64>,
    /// m/s.
    pub(crate) speed: f64,
    /// rad/s.
    pub(crate) angular_speed: f64,
    /// Whether an image of this time took part; otherwise the pose is predicted.
    pub(crate) is_measured: bool,
}

impl Sample {
    /// None where the attitude is ambiguous or the object is lost: nothing can be concluded from such a pose.
    pub(crate) fn from_pose(pose: &ObjectPose) -> Option<Self> {
        let is_measured = match pose.state {
            State::Tracking => true,
            State::Coasting => false,
            State::Initialising | State::Lost => return None,
        };
        let [vx, vy, vz, wx, wy, wz] = pose.twist;
        let [x, y, z, w] = pose.orientation;
        Some(Self {
            t_ns: pose.capture_ns,
            position: pose.position.into(),
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            covariance: Matrix6::from_row_slice(&pose.covariance),
            speed: Vector3::new(vx, vy, vz).norm(),
            angular_speed: Vector3::new(wx, wy, wz).norm(),
            is_measured,
        })
    }

    /// Standard deviation of the position along a unit vector of the world, m.
    pub(crate) fn sigma_along(&self, direction: &Vector3<f64>) -> f64 {
        let block: Matrix3<f64> = self.covariance.fixed_view::<3, 3>(0, 0).into();
        direction.dot(&(block * direction)).max(0.0).sqrt()
    }

    /// Standard deviation of the inclination, rad: rotations about the horizontal axes.
    pub(crate) fn sigma_inclination(&self) -> f64 {
        (self.covariance[(3, 3)] + self.covariance[(4, 4)])
            .max(0.0)
            .sqrt()
    }
}
