//! What a site would have calibrated and learned: the rig and the constellations, taken from the scenario.

use anyhow::Context;
use sextant_simulator::{PathJointKind, Scenario, SceneCamera, SceneObject};
use sextant_site_model::{
    Articulation, Camera, CameraId, IdError, Joint, JointId, JointKind, LinkId, ObjectId,
    ObjectModel, ObjectTag, Rig, TagId,
};

/// The cameras as a rig file has them.
pub fn rig(cameras: &[SceneCamera]) -> anyhow::Result<Rig> {
    let cameras: Result<Vec<Camera>, IdError> = cameras.iter().map(camera).collect();
    Ok(Rig::new(cameras?)?)
}

fn camera(camera: &SceneCamera) -> Result<Camera, IdError> {
    let (id, pose) = (CameraId::new(&camera.id)?, camera.world_from_camera);
    Ok(Camera {
        line_delay_s: Some(camera.line_delay_s),
        ..Camera::new(id, camera.resolution, camera.lens, Some(pose))
    })
}

/// An object for fusion: an object of the scenario, or several that joints connect as links.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    links: &'a [SceneObject],
}

/// The objects of a scenario; links follow their base.
pub fn bodies(scenario: &Scenario) -> impl Iterator<Item = Body<'_>> {
    let together = scenario
        .objects
        .chunk_by(|_, next| !next.path.joints.is_empty());
    together.map(|links| Body { links })
}

impl<'a> Body<'a> {
    /// Its id: that of its object, or what its links' ids begin with.
    pub fn id(&self) -> &'a str {
        let base = self.base().id.as_str();
        match self.links {
            [_] => base,
            _ => base.rsplit_once('-').map_or(base, |(id, _)| id),
        }
    }

    /// Its object, or the base link.
    pub fn base(&self) -> &'a SceneObject {
        &self.links[0]
    }

    /// Its links by name; none where it is rigid.
    pub fn links(&self) -> impl Iterator<Item = (&'a str, &'a SceneObject)> + use<'a> {
        let links = if self.links.len() > 1 {
            self.links
        } else {
            &[]
        };
        links.iter().map(|link| (name_of(link), link))
    }

    /// As an object file has it.
    pub fn model(&self) -> anyhow::Result<ObjectModel> {
        let id = ObjectId::new(self.id())?;
        if let [object] = self.links {
            return Ok(ObjectModel::new(id, tags(object).collect())?);
        }
        let names = self.links().map(|(name, _)| LinkId::new(name));
        let names: Vec<LinkId> = names.collect::<Result<_, _>>()?;
        let pairs = names.windows(2).zip(&self.links[1..]);
        let joints = pairs.map(|(pair, link)| joint(&pair[0], &pair[1], link));
        let tree = Articulation::new(names.clone(), joints.collect::<anyhow::Result<_>>()?)?;
        let tags = names.iter().zip(self.links).flat_map(|(name, link)| {
            tags(link).map(move |tag| ObjectTag {
                link: Some(name.clone()),
                ..tag
            })
        });
        Ok(ObjectModel::articulated(id, tree, tags.collect())?)
    }
}

/// The last part of a link's id.
fn name_of(link: &SceneObject) -> &str {
    let id = link.id.as_str();
    id.rsplit_once('-').map_or(id, |(_, name)| name)
}

/// The joint between a link and the one that it carries: the last on that one's path.
fn joint(parent: &LinkId, child: &LinkId, link: &SceneObject) -> anyhow::Result<Joint> {
    let joint = link.path.joints.last().context("a link without a joint")?;
    Ok(Joint {
        id: JointId::new(&joint.id)?,
        kind: match joint.kind {
            PathJointKind::Revolute => JointKind::Revolute,
            PathJointKind::Prismatic => JointKind::Prismatic,
        },
        parent: parent.clone(),
        child: child.clone(),
        axis: joint.axis.into(),
        parent_from_joint: joint.parent_from_joint,
        limits: Some(joint.limits),
        max_speed: None,
    })
}

fn tags(object: &SceneObject) -> impl Iterator<Item = ObjectTag> {
    object.tags.iter().map(|tag| {
        let (family, id) = (tag.family, tag.id);
        ObjectTag::new(TagId { family, id }, tag.size, Some(tag.object_from_tag))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_among_objects_is_one_object_of_links() {
        let scenario = Scenario::demo_with_arm(2, 2, 1);
        let models: Vec<ObjectModel> = bodies(&scenario)
            .map(|body| body.model().unwrap())
            .collect();
        let ids: Vec<&str> = models.iter().map(|model| model.id().as_str()).collect();
        assert_eq!(ids, ["cuboid", "prism", "arm"]);
        let tree = models[2].articulation().unwrap();
        let links: Vec<&str> = tree.links().iter().map(LinkId::as_str).collect();
        assert_eq!(links, ["base", "upper", "fore"]);
        assert_eq!(tree.joints().len(), 2);
        assert_eq!(models[2].tags().len(), 9);
    }
}
