//! Objects to messages and back.

use crate::messages::object_config::{JointConfig, ObjectConfig, ObjectTagConfig};
use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use sextant_geometry::Pose;
use sextant_site_model::{
    Articulation, Joint, LinkId, ObjectError, ObjectModel, ObjectTag, PoseSigma, TagId,
};

impl From<&ObjectModel> for ObjectConfig {
    fn from(object: &ObjectModel) -> Self {
        let tree = object.articulation();
        let joints = tree.map_or(&[][..], Articulation::joints);
        let tags = object.tags().iter();
        Self {
            id: object.id().clone(),
            links: tree.map_or_else(Vec::new, |tree| tree.links().to_vec()),
            joints: joints.iter().map(JointConfig::from).collect(),
            tags: tags
                .map(|tag| ObjectTagConfig {
                    family: tag.tag.family,
                    id: tag.tag.id,
                    size_m: tag.size_m,
                    size_sigma_m: tag.size_prior.given(),
                    // An object has at most 32 links.
                    link: object.link_of(tag).map(|link| link as u8),
                    object_from_tag: tag.object_from_tag.as_ref().map(PoseConfig::from),
                    object_from_tag_sigma: tag.pose_prior.given().map(SigmaConfig::from),
                })
                .collect(),
            frame_sigma: object.frame_sigma().map(SigmaConfig::from),
            scale_sigma: object.scale_sigma(),
            world_from_object: object.world_from_object().map(PoseConfig::from),
        }
    }
}

impl TryFrom<&ObjectConfig> for ObjectModel {
    type Error = ObjectError;

    fn try_from(message: &ObjectConfig) -> Result<Self, ObjectError> {
        let id = message.id.clone();
        let tags: Vec<ObjectTag> = message
            .tags
            .iter()
            .map(|tag| object_tag(tag, &message.links))
            .collect();
        let object = if message.links.is_empty() {
            Self::new(id, tags)
        } else {
            let joints = message.joints.iter().map(Joint::from).collect();
            match Articulation::new(message.links.clone(), joints) {
                Ok(tree) => Self::articulated(id, tree, tags),
                Err(error) => Err(ObjectError::Articulation { object: id, error }),
            }
        };
        let frame_sigma = message.frame_sigma.map(PoseSigma::from);
        object?
            .with_frame_sigma(frame_sigma)?
            .with_scale_sigma(message.scale_sigma)?
            .with_world_from_object(message.world_from_object.as_ref().map(Pose::from))
    }
}

/// The links are those of the object; tags of a checked message are on links that exist.
fn object_tag(message: &ObjectTagConfig, links: &[LinkId]) -> ObjectTag {
    let tag = TagId {
        family: message.family,
        id: message.id,
    };
    let pose = message.object_from_tag.as_ref().map(Pose::from);
    ObjectTag {
        pose_prior: message.object_from_tag_sigma.map(PoseSigma::from).into(),
        size_prior: message.size_sigma_m.into(),
        link: message
            .link
            .and_then(|link| links.get(usize::from(link)).cloned()),
        ..ObjectTag::new(tag, message.size_m, pose)
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

impl From<&JointConfig> for Joint {
    fn from(message: &JointConfig) -> Self {
        Self {
            id: message.id.clone(),
            kind: message.kind,
            parent: message.parent.clone(),
            child: message.child.clone(),
            axis: message.axis.into(),
            parent_from_joint: Pose::from(&message.parent_from_joint),
            limits: message.limits,
            max_speed: message.max_speed,
        }
    }
}
