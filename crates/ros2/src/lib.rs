//! ROS 2 without ROS: messages, their type hashes and the names of the rmw_zenoh protocol, and what of a site becomes
//! which message.
//!
//! - [`Bridge`] takes the messages of a site and returns ROS messages as bytes, each for a topic. It has no clock and
//!   no network.
//! - [`Graph`] names what rmw_zenoh puts on the network: data keys, liveliness tokens, GIDs and attachments.
//! - [`messages`] are the ROS messages; one field list for each gives struct, CDR and type hash.
//!
//! Frames follow REP 103 and 105: metres, a world with z up, cameras as optical frames (x right, y down, z forward).
//! Sextant's own conventions agree with these; [`convert`] says where a published number differs from the site's.

mod attachment;
mod bridge;
mod cdr;
pub mod convert;
mod description;
mod graph;
pub mod messages;
mod names;
mod rate;
mod topic;

pub use attachment::{ATTACHMENT_BYTES, Attachment};
pub use bridge::{Also, Bridge, BridgeCounts, BridgeOptions, Outgoing};
pub use description::{
    Field, MESSAGE_ENCODING, RosMessage, SCHEMA_ENCODING, definition, encode, type_hash,
};
pub use graph::{Distribution, Endpoint, Gid, Graph, UnknownDistribution};
pub use names::{NameError, Namespace};
pub use topic::{Durability, Qos, Reliability, Topic, TopicKind};
