//! `fusion.toml`: what a person sets of a fusion node. Paths are relative to the file's folder.

use serde::{Deserialize, Serialize};
use sextant_estimator::FusionOptions;
use sextant_proto::{NodeId, SiteId};
use sextant_site_model::ObjectId;
use sextant_zenoh_bus::{BusError, BusOptions, Identity, Role, Security, SecurityOptions};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The settings of a fusion node: contents of `fusion.toml`.
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
    /// Exposure, gain and rate of cameras, which `sextant config set camera` changes. Default `cameras.toml`; it may be
    /// missing.
    #[serde(default = "default_cameras")]
    pub cameras: PathBuf,
    /// Whether changes of rig, objects and camera settings that come over the network are written into these files, so
    /// that they outlive this process. Default false: they hold until it ends. A new object goes into
    /// `objects/<object>.toml`; the former file stays as `<name>.former`, older ones are numbered.
    #[serde(default)]
    pub keep_changes: bool,
    /// Seconds by which an observation may be older than usual when it is read; older ones are dropped and counted.
    /// Also the longest wait of an observation in this process. Default 0.5, the estimator's window: what is older is
    /// no news; 0.05 to 60.
    #[serde(default = "default_max_age_s")]
    pub max_age_s: f64,
    /// Whether a refined calibration is proposed or applied that explains the images of ordinary use better. Default
    /// `propose`.
    #[serde(default)]
    pub refinement: Refinement,
    /// Whether the fusion nodes of the site share its objects. Default: one publishes all poses and the others stand
    /// by.
    #[serde(default)]
    pub sharding: ShardingConfig,
    /// How to reach the network; by default this node is the site's router on port 7447 of the loopback interface.
    #[serde(default = "default_network")]
    pub network: BusOptions,
    /// How the network is protected; by default by being this machine's own. The node that is the router enforces it.
    #[serde(default)]
    pub security: SecurityOptions,
}

/// What the node does with a refined calibration.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Refinement {
    /// Nothing is proposed.
    Off,
    /// It is proposed, and a person may apply it.
    #[default]
    Propose,
    /// The node applies it by itself while it is the one that publishes; the others follow.
    Apply,
}

/// How the fusion nodes of a site share its objects. All of them have the same mode.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "mode", deny_unknown_fields)]
pub enum ShardingConfig {
    /// Each tracks all objects, and one publishes.
    #[default]
    Off,
    /// The nodes that are alive divide the objects among themselves.
    ByMembers {
        /// How many nodes besides the one that publishes an object track it. Default 1.
        #[serde(default = "default_standbys")]
        standbys: usize,
    },
    /// Each has the objects that its file names; of nodes that name the same object, one publishes it.
    Fixed {
        /// Ids of the objects of this node.
        objects: BTreeSet<ObjectId>,
    },
}

impl FusionConfig {
    /// The network's protection, with the keys read and checked; `folder` is that of the file.
    ///
    /// # Errors
    /// Keys and endpoints that do not go with the profile.
    pub fn protection(&self, folder: &Path) -> Result<Security, BusError> {
        let identity = Identity {
            site: self.site.as_str(),
            name: self.node.as_str(),
            roles: &[Role::Fusion],
        };
        self.security.load(folder, identity, &self.network)
    }

    /// Whether every number is in its range.
    ///
    /// # Errors
    /// The first number that is not.
    pub fn check(&self) -> Result<(), String> {
        if !(0.05..=60.0).contains(&self.max_age_s) {
            return Err("max_age_s must lie between 0.05 and 60".to_owned());
        }
        Ok(())
    }
}

fn default_standbys() -> usize {
    1
}

fn default_node() -> NodeId {
    #[allow(clippy::expect_used, reason = "a literal of the right form")]
    NodeId::new("fusion").expect("an id")
}

fn default_cameras() -> PathBuf {
    "cameras.toml".into()
}

fn default_max_age_s() -> f64 {
    FusionOptions::default().window_s
}

fn default_network() -> BusOptions {
    BusOptions::router_on("tcp/127.0.0.1:7447")
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_files::parse_toml;

    fn sharding(text: &str) -> Result<ShardingConfig, String> {
        let text = format!("site = \"lab\"\nrig = \"rig.toml\"\n{text}");
        let config = parse_toml(Path::new("f"), &text, |_: &FusionConfig| Ok(()));
        let config = config.map_err(|cause| cause.to_string());
        config.map(|config| config.sharding)
    }

    #[test]
    fn objects_are_shared_as_the_file_says() {
        assert_eq!(sharding(""), Ok(ShardingConfig::Off));
        let off = sharding("[sharding]\nmode = \"off\"");
        assert_eq!(off, Ok(ShardingConfig::Off));
        let by_members = |standbys| Ok(ShardingConfig::ByMembers { standbys });
        let text = "[sharding]\nmode = \"by-members\"\n";
        assert_eq!(sharding(text), by_members(1));
        assert_eq!(sharding(&format!("{text}standbys = 0")), by_members(0));
        let objects = ObjectId::new("cube").into_iter().collect();
        let fixed = sharding("[sharding]\nmode = \"fixed\"\nobjects = [\"cube\"]");
        assert_eq!(fixed, Ok(ShardingConfig::Fixed { objects }));
        let mixed = sharding(&format!("{text}objects = [\"cube\"]"));
        assert!(mixed.is_err_and(|cause| cause.contains("objects")));
    }
}
