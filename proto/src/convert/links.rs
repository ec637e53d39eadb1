//! Articulated objects and their estimates to messages, and the objects back.

use crate::convert::covariance;
use crate::messages::articulated_config::{ArticulatedConfig, JointConfig, LinkTagConfig};
use crate::messages::config::{ObjectTagConfig, PoseConfig};
use crate::messages::object_links::{JointState, LinkPose, ObjectLinks};
use crate::messages::object_pose::ObjectPose;
use sextant_estimator::{
    Articulation, Joint, LinkEstimate, ObjectError, ObjectEstimate, ObjectModel, ObjectTag,
};
use sextant_geometry::Pose;

impl ObjectLinks {
    /// The message beside the pose of the same estimate; none where the object is rigid.
    #[must_use]
    pub fn from_estimate(estimate: &ObjectEstimate, pose: &ObjectPose) -> Option<Self> {
        let posture = estimate.posture.as_deref()?;
        let joints = posture.joints.iter().map(|joint| JointState {
            joint: joint.joint.clone(),
            value: joint.value,
            variance: joint.variance.clamp(0.0, f64::INFINITY),
            velocity: joint.velocity,
            velocity_variance: joint.velocity_variance.clamp(0.0, f64::INFINITY),
        });
        Some(Self {
            object: pose.object.clone(),
            sequence: pose.sequence,
            capture_ns: pose.capture_ns,
            published_ns: pose.published_ns,
            state: pose.state,
            links: posture.links.iter().map(LinkPose::from).collect(),
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
    /// `world_from_link`.
    #[must_use]
    pub fn world_from_link(&self) -> Pose {
        Pose::from(&PoseConfig {
            position: self.position,
            orientation: self.orientation,
        })
    }
}

impl ArticulatedConfig {
    /// The message of an object; none where it is rigid.
    #[must_use]
    pub fn of(object: &ObjectModel) -> Option<Self> {
        let tree = object.articulation()?;
        let tags = object.tags().iter().enumerate().map(|(index, tag)| {
            let link = object.link_of(index).unwrap_or(0);
            LinkTagConfig {
                link: u8::try_from(link).unwrap_or(u8::MAX),
                tag: ObjectTagConfig::from(tag),
            }
        });
        Some(Self {
            id: object.id().clone(),
            links: tree.links().to_vec(),
            joints: tree.joints().iter().map(JointConfig::from).collect(),
            tags: tags.collect(),
        })
    }
}

impl From<&Joint> for JointConfig {
    fn from(joint: &Joint) -> Self {
        Self {
            id: joint.id.clone(),
            kind: joint.kind,
            parent: joint.parent.clone(),
            child: joint.child.clone(),
            axis: joint.axis.into(),
            parent_from_joint: PoseConfig::from(&joint.parent_from_joint),
            limits: joint.limits,
            max_speed: joint.max_speed,
        }
    }
}

impl TryFrom<&ArticulatedConfig> for ObjectModel {
    type Error = ObjectError;

    fn try_from(message: &ArticulatedConfig) -> Result<Self, ObjectError> {
        let joints = message.joints.iter().map(|joint| Joint {
            id: joint.id.clone(),
            kind: joint.kind,
            parent: joint.parent.clone(),
            child: joint.child.clone(),
            axis: joint.axis.into(),
            parent_from_joint: Pose::from(&joint.parent_from_joint),
            limits: joint.limits,
            max_speed: joint.max_speed,
        });
        let tree = Articulation::new(message.links.clone(), joints.collect());
        let tree = tree.map_err(|error| ObjectError::Articulation {
            object: message.id.clone(),
            error,
        })?;
        // A checked message's tags are on links that are there.
        let on_links = message.tags.iter().filter_map(|one| {
            let link = message.links.get(usize::from(one.link))?;
            Some((link.clone(), ObjectTag::from(&one.tag)))
        });
        Self::articulated(message.id.clone(), tree, on_links.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::samples::lidded_box;

    #[test]
    fn an_articulated_object_survives_the_way_there_and_back() {
        let object = lidded_box();
        let message = ArticulatedConfig::of(&object).unwrap();
        assert_eq!(ObjectModel::try_from(&message), Ok(object));
    }
}
