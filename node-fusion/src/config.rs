//! `fusion.toml`: what a person sets of a fusion node. Paths are relative to the file's folder.

use serde::{Deserialize, Serialize};
use sextant_proto::{NodeId, SiteId};
use sextant_zenoh_bus::BusOptions;
use std::path::PathBuf;

/// The file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FusionConfig {
    /// The site whose cameras are fused; the middle of every key.
    pub site: SiteId,
    /// This node's name among the site's fusion nodes.
    #[serde(default = "default_node")]
    pub node: NodeId,
    /// The cameras: a rig file.
    pub rig: PathBuf,
    /// The objects: object files.
    #[serde(default)]
    pub objects: Vec<PathBuf>,
    /// Whether changes of rig and objects that come over the network are written into these files, so that they outlive
    /// this process. Default false: they hold until it ends. The former file stays as `<name>.former`.
    #[serde(default)]
    pub keep_changes: bool,
    /// How to reach the network; by default this node is the site's router on port 7447 of the loopback interface.
    #[serde(default = "default_network")]
    pub network: BusOptions,
}

fn default_node() -> NodeId {
    #[allow(clippy::expect_used, reason = "a literal of the right form")]
    NodeId::new("fusion").expect("an id")
}

fn default_network() -> BusOptions {
    BusOptions::router_on("tcp/127.0.0.1:7447")
}
