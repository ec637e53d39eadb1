//! Rigid motions and estimates to messages, and poses back.

use crate::convert::covariance;
use crate::messages::config::PoseConfig;
use crate::messages::object_pose::ObjectPose;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use sextant_estimator::ObjectEstimate;
use sextant_geometry::Pose;

impl From<&Pose> for PoseConfig {
    fn from(a_from_b: &Pose) -> Self {
        let q = a_from_b.rotation.quaternion();
        Self {
            position: a_from_b.translation.vector.into(),
            orientation: [q.i, q.j, q.k, q.w],
        }
    }
}

impl From<&PoseConfig> for Pose {
    /// The quaternion is normalised; a checked message's is close to it already.
    fn from(pose: &PoseConfig) -> Self {
        let [x, y, z, w] = pose.orientation;
        Self::from_parts(
            Translation3::from(pose.position),
            UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
        )
    }
}

impl ObjectPose {
    /// The message of an estimate: the `sequence`-th of its object, handed to the network at `published_ns`. Its covariance is the
    /// nearest positive semi-definite one.
    #[must_use]
    pub fn from_estimate(estimate: &ObjectEstimate, sequence: u64, published_ns: u64) -> Self {
        let pose = PoseConfig::from(&estimate.world_from_object);
        Self {
            object: estimate.object.clone(),
            sequence,
            capture_ns: estimate.capture_ns,
            published_ns,
            state: estimate.state,
            position: pose.position,
            orientation: pose.orientation,
            covariance: covariance::published(&estimate.covariance),
            twist: estimate.twist.into(),
            cameras: u16::try_from(estimate.cameras).unwrap_or(u16::MAX),
            tags: u16::try_from(estimate.tags).unwrap_or(u16::MAX),
            rms_px: estimate.rms_px as f32,
        }
    }

    /// `world_from_object`.
    #[must_use]
    pub fn world_from_object(&self) -> Pose {
        Pose::from(&PoseConfig {
            position: self.position,
            orientation: self.orientation,
        })
    }
}
