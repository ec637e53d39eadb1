//! Heartbeats of the fusion nodes of a site, by which one of them publishes poses and the others stand by.

use crate::check::{OutOfRange, holds};
use crate::envelope::{Kind, Message};
use crate::ids::NodeId;
use crate::limits::MAX_PEERS;
use crate::wire;
use serde::{Deserialize, Serialize};

/// A sign of life of a fusion node, 20 times a second.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// The node, equal to that of the key.
    pub node: NodeId,
    /// When it was sent, ns by a clock of the node's own that is never set.
    pub sent_ns: u64,
    /// Epoch of the poses that the node publishes; none while it stands by.
    pub epoch: Option<u64>,
    /// The newest epoch that the node knows of.
    pub newest: u64,
    /// The last heartbeat that the node has received of each other one.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_PEERS>")]
    pub heard: Vec<HeardBeat>,
}

/// A heartbeat that was received.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeardBeat {
    /// Its sender.
    pub node: NodeId,
    /// As in the heartbeat.
    pub sent_ns: u64,
}

impl Message for Heartbeat {
    const KIND: Kind = Kind::Heartbeat;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.heard.len() <= MAX_PEERS, "heard")
    }
}
