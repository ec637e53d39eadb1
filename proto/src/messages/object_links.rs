//! Where the links of an articulated object are, and its joints; beside the object's pose of the same instant.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::{MAX_JOINTS, MAX_LINKS};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::{JointId, LinkId, ObjectId};
use sextant_site_report::State;

/// Links and joints of an object at one capture time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectLinks {
    /// The object; the same as in the key.
    pub object: ObjectId,
    /// That of the [`crate::ObjectPose`] of the same instant.
    pub epoch: u64,
    /// That of the [`crate::ObjectPose`] of the same instant.
    pub sequence: u64,
    /// The instant: middle of the exposure, ns since the Unix epoch.
    pub capture_ns: u64,
    /// When the fusion node handed it to the network, ns since the Unix epoch by the fusion node's clock.
    pub published_ns: u64,
    /// That of the object; on the wire the number of the variant, from 0.
    pub state: State,
    /// Every link, in the order of the object's file; the base's pose is the object's.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_LINKS>")]
    pub links: Vec<LinkPose>,
    /// Every joint that moves, in the order of the object's file.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_JOINTS>")]
    pub joints: Vec<JointState>,
}

/// Pose of a link, `world_from_link`, with its covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LinkPose {
    /// Which link.
    pub link: LinkId,
    /// The link's origin in the world, metres.
    pub position: [f64; 3],
    /// The link's axes in the world, x, y, z, w.
    pub orientation: [f64; 4],
    /// As an object's, about the link's origin.
    #[serde(with = "wire::array")]
    pub covariance: [f64; 36],
}

/// A joint's value; rad or m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Which joint.
    pub joint: JointId,
    /// Within the joint's limits.
    pub value: f64,
    /// Of the value.
    pub variance: f64,
    /// Per second.
    pub velocity: f64,
    /// Of the velocity.
    pub velocity_variance: f64,
}

impl Message for ObjectLinks {
    const KIND: MessageKind = MessageKind::ObjectLinks;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        check::time(self.published_ns, "published_ns")?;
        holds(self.links.len() <= MAX_LINKS, "links")?;
        holds(self.joints.len() <= MAX_JOINTS, "joints")?;
        self.links.iter().try_for_each(LinkPose::check)?;
        self.joints.iter().try_for_each(JointState::check)
    }
}

impl LinkPose {
    fn check(&self) -> Result<(), OutOfRange> {
        check::position(self.position, "links[].position")?;
        check::orientation(self.orientation, "links[].orientation")?;
        check::finite(&self.covariance, "links[].covariance")?;
        let mut variances = self.covariance.iter().step_by(7);
        holds(variances.all(|v| *v >= 0.0), "links[].covariance")
    }
}

impl JointState {
    fn check(&self) -> Result<(), OutOfRange> {
        check::finite(&[self.value], "joints[].value")?;
        check::amount(self.variance, "joints[].variance")?;
        check::finite(&[self.velocity], "joints[].velocity")?;
        check::amount(self.velocity_variance, "joints[].velocity_variance")
    }
}
