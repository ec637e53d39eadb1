//! Heartbeats of the fusion nodes of a site, by which one of them publishes poses and the others stand by, or each
//! publishes its share, and by which all of them come to work from the same models.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::ids::NodeId;
use crate::limits::{MAX_OBJECTS, MAX_PEERS};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::ObjectId;

/// Greatest counter of a version: files and other languages have signed numbers, and one more is never too many.
const MAX_VERSION_COUNTER: u64 = 1 << 62;

/// A sign of life of a fusion node, 20 times a second.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// The node, equal to that of the key.
    pub node: NodeId,
    /// When it was sent, ns by a clock of the node's own that is never set.
    pub sent_ns: u64,
    /// Epoch of the poses that the node publishes; none while it stands by. Of nodes that share the objects one has an
    /// epoch as well, and takes care of what concerns the whole site.
    pub epoch: Option<u64>,
    /// The newest epoch that the node knows of.
    pub newest: u64,
    /// The last heartbeat that the node has received of each other one.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_PEERS>")]
    pub heard: Vec<HeardBeat>,
    /// The node's share of the objects; none where one node publishes the poses of all of them.
    pub sharing: Option<Sharing>,
    /// The rig, the objects and the settings that the node works from.
    pub models: ModelsState,
}

/// Which models a fusion node works from.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelsState {
    /// Their version; none of files that have not been compared with those of other nodes yet, which are older than all
    /// versions.
    pub version: Option<ModelsVersion>,
    /// [`crate::models_fingerprint`] of the payloads that carry them.
    pub fingerprint: u64,
}

/// A version of the models of a site: rig, objects and settings together. The greater one is newer, compared field by
/// field.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ModelsVersion {
    /// Changes since the first version.
    pub counter: u64,
    /// When the last change was made, ns since the Unix epoch.
    pub t_ns: u64,
    /// The fusion node that made it.
    pub author: NodeId,
}

/// A heartbeat that was received.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeardBeat {
    /// Its sender.
    pub node: NodeId,
    /// As in the heartbeat.
    pub sent_ns: u64,
}

/// What a node does where the objects are shared among the fusion nodes of a site.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sharing {
    /// How many nodes besides the publisher track an object, in the order of the nodes' weights; none where its file
    /// names its objects.
    pub standbys: Option<u32>,
    /// The objects that the node tracks.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECTS>")]
    pub objects: Vec<Share>,
}

/// A node's part in one object.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Share {
    /// The object.
    pub object: ObjectId,
    /// The node's part in it.
    pub part: Part,
}

/// What a node that tracks an object does with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// It has not seen the object for long enough to publish its poses.
    Preparing,
    /// It may publish its poses.
    Ready,
    /// It publishes its poses under this epoch.
    Publishing(u64),
}

impl Message for Heartbeat {
    const KIND: MessageKind = MessageKind::Heartbeat;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.heard.len() <= MAX_PEERS, "heard")?;
        let n_objects = self.sharing.as_ref().map_or(0, |one| one.objects.len());
        holds(n_objects <= MAX_OBJECTS, "sharing.objects")?;
        let version = self.models.version.as_ref();
        let counter = version.map_or(0, |one| one.counter);
        holds(counter <= MAX_VERSION_COUNTER, "models.version.counter")?;
        check::time(version.map_or(0, |one| one.t_ns), "models.version.t_ns")
    }
}
