//! What a node of rmw_zenoh puts on the network beside data: where each topic's messages go, and the liveliness tokens
//! of which `ros2 node list` and `ros2 topic list` are made.
//!
//! Data keys are `<domain>/<topic>/<type>/<hash>`, tokens
//! `@ros2_lv/<domain>/<session>/<node>/<entity>/<kind>/<enclave>/<namespace>/<name>`, a publisher's with
//! `/<topic>/<type>/<hash>/<qos>` behind; in a token's parts `%` stands for `/`. Source: rmw_zenoh_cpp,
//! `liveliness_utils.cpp`.

use std::str::FromStr;

use xxhash_rust::xxh3::xxh3_128;

use crate::names::Namespace;
use crate::topic::Topic;

/// Identifier of the node itself; its publishers have the numbers behind.
const NODE_ID: u32 = 0;
/// Name of the node.
const NODE: &str = "bridge";
/// What rmw_zenoh of Humble writes for a hash.
const NO_HASH: &str = "TypeHashNotSupported";

/// A release of ROS 2, as far as the protocol differs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// Has no type hashes.
    Humble,
    /// Jazzy with rmw_zenoh 0.2.4 or later, Kilted, and what follows.
    Hashed,
}

/// No release of ROS 2 whose rmw_zenoh is known.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is no release with rmw_zenoh: humble, jazzy, kilted, lyrical or rolling")]
pub struct UnknownDistribution(String);

impl FromStr for Distribution {
    type Err = UnknownDistribution;

    fn from_str(name: &str) -> Result<Self, UnknownDistribution> {
        match name {
            "humble" => Ok(Self::Humble),
            "jazzy" | "kilted" | "lyrical" | "rolling" => Ok(Self::Hashed),
            other => Err(UnknownDistribution(other.to_owned())),
        }
    }
}

/// The node and its session, as the graph of ROS shows them.
#[derive(Debug, Clone)]
pub struct Graph {
    /// `ROS_DOMAIN_ID`.
    pub domain: u32,
    /// The release that is spoken to.
    pub distribution: Distribution,
    /// The zenoh session's identifier, as zenoh prints it.
    pub session: String,
    /// The node's namespace.
    pub namespace: Namespace,
}

/// Global identifier of a publisher: XXH3-128 of its token, little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gid(pub [u8; 16]);

/// A publisher on the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Endpoint {
    /// The key of its messages.
    pub key: String,
    /// Its liveliness token.
    pub token: String,
    /// What its attachments name it.
    pub gid: Gid,
}

impl Graph {
    /// The node's liveliness token.
    #[must_use]
    pub fn node_token(&self) -> String {
        self.token(NODE_ID, "NN")
    }

    /// The publisher of a topic; `number` counts the node's publishers from 1.
    #[must_use]
    pub fn publisher(&self, number: u32, topic: &Topic) -> Endpoint {
        let (name, kind) = (topic.name.as_str(), topic.kind);
        let type_name = dds_name(kind.type_name());
        let hash = match self.distribution {
            Distribution::Humble => NO_HASH.to_owned(),
            Distribution::Hashed => kind.type_hash(),
        };
        let key = format!(
            "{}/{}/{type_name}/{hash}",
            self.domain,
            name.trim_matches('/')
        );
        let token = format!(
            "{}/{}/{type_name}/{hash}/{}",
            self.token(number, "MP"),
            mangled(name),
            kind.qos().token()
        );
        let gid = Gid(xxh3_128(token.as_bytes()).to_le_bytes());
        Endpoint { key, token, gid }
    }

    fn token(&self, entity: u32, kind: &str) -> String {
        // The enclave is that of no security: `/`.
        format!(
            "@ros2_lv/{}/{}/{NODE_ID}/{entity}/{kind}/%/{}/{NODE}",
            self.domain,
            self.session,
            mangled(self.namespace.absolute())
        )
    }
}

fn mangled(name: &str) -> String {
    name.replace('/', "%")
}

/// `tf2_msgs/msg/TFMessage` as DDS names it: `tf2_msgs::msg::dds_::TFMessage_`.
fn dds_name(ros: &str) -> String {
    let (package, name) = ros.rsplit_once('/').unwrap_or(("", ros));
    format!("{}::dds_::{name}_", package.replace('/', "::"))
}
