//! Rigid motions and estimates to messages, and poses back.

use crate::convert::covariance;
use crate::messages::object_pose::ObjectPose;
use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use nalgebra::{Matrix6, Quaternion, Translation3};
use sextant_geometry::{Pose, unit_quaternion};
use sextant_site_model::PoseSigma;
use sextant_site_report::ObjectEstimate;

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
    /// The quaternion is normalised; that of a checked message is nearly so already.
    fn from(pose: &PoseConfig) -> Self {
        let [x, y, z, w] = pose.orientation;
        Self::from_parts(
            Translation3::from(pose.position),
            unit_quaternion(Quaternion::new(w, x, y, z)),
        )
    }
}

impl From<PoseSigma> for SigmaConfig {
    fn from(sigma: PoseSigma) -> Self {
        Self {
            position_m: sigma.position_m,
            orientation_rad: sigma.orientation_rad,
        }
    }
}

impl From<SigmaConfig> for PoseSigma {
    fn from(message: SigmaConfig) -> Self {
        Self {
            position_m: message.position_m,
            orientation_rad: message.orientation_rad,
        }
    }
}

impl ObjectPose {
    /// The message of an estimate: the `sequence`-th of its object, by the fusion node of this epoch, handed to the
    /// network at `published_ns`. Its covariance is the nearest positive semi-definite one.
    #[must_use]
    pub fn from_estimate(
        estimate: &ObjectEstimate,
        epoch: u64,
        sequence: u64,
        published_ns: u64,
    ) -> Self {
        let pose = PoseConfig::from(&estimate.world_from_object);
        Self {
            object: estimate.object.clone(),
            epoch,
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

    /// Pose of the object, `world_from_object`.
    #[must_use]
    pub fn world_from_object(&self) -> Pose {
        Pose::from(&PoseConfig {
            position: self.position,
            orientation: self.orientation,
        })
    }
}

impl From<&ObjectPose> for ObjectEstimate {
    /// What a published pose says of the estimate: of an articulated object, the pose of its base.
    fn from(pose: &ObjectPose) -> Self {
        Self {
            object: pose.object.clone(),
            capture_ns: pose.capture_ns,
            world_from_object: pose.world_from_object(),
            covariance: Matrix6::from_row_slice(&pose.covariance),
            twist: pose.twist.into(),
            state: pose.state,
            cameras: pose.cameras.into(),
            tags: pose.tags.into(),
            rms_px: pose.rms_px.into(),
            articulated: None,
        }
    }
}
