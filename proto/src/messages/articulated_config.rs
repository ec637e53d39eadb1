//! An object of links and joints, as the site's fusion node last read it; in place of the [`crate::ObjectConfig`] of a rigid
//! one.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Kind, Message};
use crate::limits::{MAX_LINKS, MAX_OBJECT_TAGS};
use crate::messages::config::{ObjectTagConfig, PoseConfig};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_estimator::{JointId, JointKind, LinkId, ObjectId};

/// One object of links.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ArticulatedConfig {
    /// Its id.
    pub id: ObjectId,
    /// Its links, in the order of its file.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub links: Vec<LinkId>,
    /// Its joints, in the order of its file, those that don't move among them; with the links they make a tree.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub joints: Vec<JointConfig>,
    /// Its tags, in the order of its file.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECT_TAGS>")]
    pub tags: Vec<LinkTagConfig>,
}

/// One joint: `parent_from_child = parent_from_joint * motion(value)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointConfig {
    /// Its id.
    pub id: JointId,
    /// How it moves; on the wire the number of the variant, from 0.
    pub kind: JointKind,
    /// The link that carries it.
    pub parent: LinkId,
    /// The link that it moves.
    pub child: LinkId,
    /// Unit vector in the joint's frame.
    pub axis: [f64; 3],
    /// Where it sits on the parent.
    pub parent_from_joint: PoseConfig,
    /// Lowest and highest value, rad or m.
    pub limits: Option<[f64; 2]>,
    /// Highest speed, rad/s or m/s.
    pub max_speed: Option<f64>,
}

/// One tag of a link; its `object_from_tag` is `link_from_tag`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinkTagConfig {
    /// Place of its link in the list, from 0.
    pub link: u8,
    /// The tag.
    pub tag: ObjectTagConfig,
}

impl Message for ArticulatedConfig {
    const KIND: Kind = Kind::ArticulatedConfig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.links.len() <= MAX_LINKS, "links")?;
        holds(self.joints.len() <= MAX_LINKS, "joints")?;
        holds(self.tags.len() <= MAX_OBJECT_TAGS, "tags")?;
        self.joints.iter().try_for_each(JointConfig::check)?;
        self.tags.iter().try_for_each(|one| {
            holds(usize::from(one.link) < self.links.len(), "tags[].link")?;
            one.tag.check()
        })
    }
}

impl JointConfig {
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        check::finite(&self.axis, "joints[].axis")?;
        PoseConfig::check(Some(self.parent_from_joint), "joints[].parent_from_joint")?;
        let [lowest, highest] = self.limits.unwrap_or([0.0, 1.0]);
        check::finite(&[lowest, highest], "joints[].limits")?;
        holds(lowest < highest, "joints[].limits")?;
        let speed = self.max_speed.unwrap_or(1.0);
        holds(speed.is_finite() && speed > 0.0, "joints[].max_speed")
    }
}
