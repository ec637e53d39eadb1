//! An object of a site, rigid or of links and joints: everything that its file can say.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::{MAX_LINKS, MAX_OBJECT_TAGS};
use crate::messages::pose_config::{PoseConfig, SigmaConfig};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::{JointId, JointKind, LinkId, ObjectId};
use sextant_tag_families::Family;

/// One object and its tags.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectConfig {
    /// Its id; the same as in the key.
    pub id: ObjectId,
    /// Its links, in the order of its file; empty for a rigid object.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub links: Vec<LinkId>,
    /// Its joints, in the order of its file, fixed ones included; with the links they make a tree.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub joints: Vec<JointConfig>,
    /// Its tags, in the order of its file. An object without tags does not exist: the message removes it.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECT_TAGS>")]
    pub tags: Vec<ObjectTagConfig>,
    /// Standard deviation of its frame in its tags; none where the file gives none.
    pub frame_sigma: Option<SigmaConfig>,
    /// Standard deviation of the scale that the sizes and places of its tags share, as a share of it; none where the
    /// file gives none.
    pub scale_sigma: Option<f64>,
    /// Where it stands still in the world; none unless it is a landmark.
    pub world_from_object: Option<PoseConfig>,
}

/// One tag of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectTagConfig {
    /// Its family; on the wire the number of the variant, from 0.
    pub family: Family,
    /// Its number within the family.
    pub id: u32,
    /// Edge of its black square, metres.
    pub size_m: f64,
    /// Standard deviation of the size, metres; none where the file gives none.
    pub size_sigma_m: Option<f64>,
    /// Index of its link in [`ObjectConfig::links`]; none on a rigid object.
    pub link: Option<u8>,
    /// `object_from_tag`, or `link_from_tag` where the tag is on a link; none until learned.
    pub object_from_tag: Option<PoseConfig>,
    /// Standard deviation of that pose; none where the file gives none.
    pub object_from_tag_sigma: Option<SigmaConfig>,
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
    /// Pose of the joint on the parent link.
    pub parent_from_joint: PoseConfig,
    /// Lowest and highest value, rad or m.
    pub limits: Option<[f64; 2]>,
    /// Highest speed, rad/s or m/s.
    pub max_speed: Option<f64>,
}

impl ObjectConfig {
    /// The message that removes an object.
    #[must_use]
    pub fn removal(id: ObjectId) -> Self {
        Self {
            id,
            links: Vec::new(),
            joints: Vec::new(),
            tags: Vec::new(),
            frame_sigma: None,
            scale_sigma: None,
            world_from_object: None,
        }
    }

    /// Whether the message removes the object.
    #[must_use]
    pub fn is_removal(&self) -> bool {
        self.tags.is_empty()
    }
}

impl Message for ObjectConfig {
    const KIND: MessageKind = MessageKind::ObjectConfig;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.links.len() <= MAX_LINKS, "links")?;
        holds(self.joints.len() <= MAX_LINKS, "joints")?;
        holds(self.tags.len() <= MAX_OBJECT_TAGS, "tags")?;
        self.joints.iter().try_for_each(JointConfig::check)?;
        SigmaConfig::check(self.frame_sigma, "frame_sigma")?;
        check::amount(self.scale_sigma.unwrap_or(0.0), "scale_sigma")?;
        PoseConfig::check(self.world_from_object, "world_from_object")?;
        let n_links = self.links.len();
        self.tags.iter().try_for_each(|tag| tag.check(n_links))
    }
}

impl ObjectTagConfig {
    fn check(&self, n_links: usize) -> Result<(), OutOfRange> {
        holds(
            self.size_m.is_finite() && self.size_m > 0.0,
            "tags[].size_m",
        )?;
        check::amount(self.size_sigma_m.unwrap_or(0.0), "tags[].size_sigma_m")?;
        let is_on_link = match self.link {
            None => n_links == 0,
            Some(link) => usize::from(link) < n_links,
        };
        holds(is_on_link, "tags[].link")?;
        PoseConfig::check(self.object_from_tag, "tags[].object_from_tag")?;
        SigmaConfig::check(self.object_from_tag_sigma, "tags[].object_from_tag_sigma")
    }
}

impl JointConfig {
    fn check(&self) -> Result<(), OutOfRange> {
        check::finite(&self.axis, "joints[].axis")?;
        PoseConfig::check(Some(self.parent_from_joint), "joints[].parent_from_joint")?;
        let [lowest, highest] = self.limits.unwrap_or([0.0, 1.0]);
        check::finite(&[lowest, highest], "joints[].limits")?;
        holds(lowest < highest, "joints[].limits")?;
        let speed = self.max_speed.unwrap_or(1.0);
        holds(speed.is_finite() && speed > 0.0, "joints[].max_speed")
    }
}
