//! Objects to messages and back.

use crate::messages::object_config::{JointConfig, ObjectConfig, ObjectTagConfig};
use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use sextant_geometry::Pose;
use sextant_site_model::{Articulation, Joint, ObjectError, ObjectModel, ObjectTag, TagId};

impl From<&ObjectModel> for ObjectConfig {
    fn from(object: &ObjectModel) -> Self {
        let tree = object.articulation();
        let joints = tree.map_or(&[][..], Articulation::joints);
        let tags = object.tags().iter().enumerate();
        Self {
            id: object.id().clone(),
            links: tree.map_or_else(Vec::new, |tree| tree.links().to_vec()),
            joints: joints.iter().map(JointConfig::from).collect(),
            tags: tags
                .map(|(index, tag)| ObjectTagConfig {
                    family: tag.tag.family,
                    id: tag.tag.id,
                    size_m: tag.size_m,
                    size_sigma_m: object.size_sigma_m(&tag.tag),
                    // An object has at most 32 links.
                    link: object.link_of(index).map(|link| link as u8),
                    object_from_tag: tag.object_from_tag.as_ref().map(PoseConfig::from),
                    object_from_tag_sigma: object.tag_sigma(&tag.tag).map(SigmaConfig::from),
                })
                .collect(),
        }
    }
}

impl TryFrom<&ObjectConfig> for ObjectModel {
    type Error = ObjectError;

    fn try_from(message: &ObjectConfig) -> Result<Self, ObjectError> {
        let pose_sigmas = message.tags.iter().filter_map(|tag| {
            let sigma = tag.object_from_tag_sigma?;
            Some((TagId::from(tag), sigma.into()))
        });
        let size_sigmas = message
            .tags
            .iter()
            .filter_map(|tag| Some((TagId::from(tag), tag.size_sigma_m?)));
        without_sigmas(message)?
            .with_tag_sigmas(pose_sigmas)?
            .with_size_sigmas(size_sigmas)
    }
}

fn without_sigmas(message: &ObjectConfig) -> Result<ObjectModel, ObjectError> {
    let id = message.id.clone();
    if message.links.is_empty() {
        return ObjectModel::new(id, message.tags.iter().map(ObjectTag::from).collect());
    }
    let joints = message.joints.iter().map(Joint::from).collect();
    let tree = Articulation::new(message.links.clone(), joints);
    let tree = tree.map_err(|error| ObjectError::Articulation {
        object: id.clone(),
        error,
    })?;
    // The tags of a checked message are on links that exist.
    let on_links = message.tags.iter().filter_map(|tag| {
        let link = message.links.get(usize::from(tag.link?))?;
        Some((link.clone(), ObjectTag::from(tag)))
    });
    ObjectModel::articulated(id, tree, on_links.collect())
}

impl From<&ObjectTagConfig> for TagId {
    fn from(message: &ObjectTagConfig) -> Self {
        Self {
            family: message.family,
            id: message.id,
        }
    }
}

impl From<&ObjectTagConfig> for ObjectTag {
    fn from(message: &ObjectTagConfig) -> Self {
        Self {
            tag: TagId::from(message),
            size_m: message.size_m,
            object_from_tag: message.object_from_tag.as_ref().map(Pose::from),
        }
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
