//! The pose of an object.

use nalgebra::{Isometry3, Matrix6, Quaternion, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::unit_quaternion;
use sextant_proto::ObjectPose;
/// How much an estimate can be trusted.
pub use sextant_proto::State;

/// Pose of an object in the world at one instant: `world_from_object`, with covariance and motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// The object.
    pub object: String,
    /// Which fusion node published it, of those that a site has in turn: each has a greater epoch than those before it.
    pub epoch: u64,
    /// Number of this pose since the fusion node started; gaps within an epoch are messages that were lost.
    pub sequence: u64,
    /// The instant that the pose is for, ns since the Unix epoch: the middle of an exposure, by the clock of the
    /// cameras.
    pub t_ns: u64,
    /// When the fusion node published it, ns since the Unix epoch by its own clock.
    pub published_ns: u64,
    /// How much it can be trusted. Of an object that is `Lost` this is the last prediction.
    pub state: State,
    /// The object's origin in the world, metres.
    pub position: Vector3<f64>,
    /// The object's axes in the world.
    pub orientation: UnitQuaternion<f64>,
    /// Covariance over (x, y, z, rx, ry, rz), m and rad, in world axes, about the object's origin: the estimated
    /// attitude is `exp(r)` times the true one.
    pub covariance: Matrix6<f64>,
    /// Velocity of the object's origin, world axes, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity, world axes, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Cameras that saw the object at or shortly before this instant.
    pub cameras: u16,
    /// Tags that entered the estimate.
    pub tags: u16,
    /// Root mean square reprojection error of their corners, pixels.
    pub rms_px: f32,
}

impl Pose {
    /// The rigid motion that maps points of the object into the world.
    #[must_use]
    pub fn world_from_object(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.position), self.orientation)
    }
}

impl From<ObjectPose> for Pose {
    fn from(message: ObjectPose) -> Self {
        let [x, y, z, w] = message.orientation;
        let [vx, vy, vz, wx, wy, wz] = message.twist;
        Self {
            object: message.object.to_string(),
            epoch: message.epoch,
            sequence: message.sequence,
            t_ns: message.capture_ns,
            published_ns: message.published_ns,
            state: message.state,
            position: message.position.into(),
            orientation: unit_quaternion(Quaternion::new(w, x, y, z)),
            covariance: Matrix6::from_row_slice(&message.covariance),
            velocity: Vector3::new(vx, vy, vz),
            angular_velocity: Vector3::new(wx, wy, wz),
            cameras: message.cameras,
            tags: message.tags,
            rms_px: message.rms_px,
        }
    }
}
