//! Estimates of the links and joints of articulated objects to messages.

use crate::convert::covariance;
use crate::messages::object_links::{JointState, LinkPose, ObjectLinks};
use crate::messages::object_pose::ObjectPose;
use crate::messages::pose_config::PoseConfig;
use sextant_geometry::Pose;
use sextant_site_report::{LinkEstimate, ObjectEstimate};

impl ObjectLinks {
    /// The message beside the pose of the same estimate; none where the object is rigid.
    #[must_use]
    pub fn from_estimate(estimate: &ObjectEstimate, pose: &ObjectPose) -> Option<Self> {
        let articulated = estimate.articulated.as_deref()?;
        let joints = articulated.joints.iter().map(|joint| JointState {
            joint: joint.joint.clone(),
            value: joint.value,
            variance: joint.variance.clamp(0.0, f64::INFINITY),
            velocity: joint.velocity,
            velocity_variance: joint.velocity_variance.clamp(0.0, f64::INFINITY),
        });
        Some(Self {
            object: pose.object.clone(),
            epoch: pose.epoch,
            sequence: pose.sequence,
            capture_ns: pose.capture_ns,
            published_ns: pose.published_ns,
            state: pose.state,
            links: articulated.links.iter().map(LinkPose::from).collect(),
            joints: joints.collect(),
        })
    }
}

impl From<&LinkEstimate> for LinkPose {
    fn from(estimate: &LinkEstimate) -> Self {
        let pose = PoseConfig::from(&estimate.world_from_link);
        Self {
            link: estimate.link.clone(),
            position: pose.position,
            orientation: pose.orientation,
            covariance: covariance::published(&estimate.covariance),
        }
    }
}

impl LinkPose {
    /// Pose of the link, `world_from_link`.
    #[must_use]
    pub fn world_from_link(&self) -> Pose {
        Pose::from(&PoseConfig {
            position: self.position,
            orientation: self.orientation,
        })
    }
}
