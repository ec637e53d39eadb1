//! `fusion.toml`: what a person sets of a fusion node. Paths are relative to the file's folder.

use serde::{Deserialize, Serialize};
use sextant_calibrator::refinement::RefinementOptions;
use sextant_estimator::FusionOptions;
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
    /// this process. Default false: they hold until it ends. A new object goes into `objects/<object>.toml`; the former file
    /// stays as `<name>.former`, older ones are numbered.
    #[serde(default)]
    pub keep_changes: bool,
    /// Seconds by which an observation may be older than usual when it is read; older ones are dropped and counted. Also the
    /// longest wait of an observation in this process. Default 0.5, the estimator's window: what is older is no news; 0.05 to 60.
    #[serde(default = "default_max_age_s")]
    pub max_age_s: f64,
    /// Small corrections of cameras and tags while the node works, off by default.
    #[serde(default)]
    pub refinement: RefinementConfig,
    /// How to reach the network; by default this node is the site's router on port 7447 of the loopback interface.
    #[serde(default = "default_network")]
    pub network: BusOptions,
}

/// Whether the site is refined from its ordinary use, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RefinementConfig {
    /// Default false. In one fusion node of a site only: it tells the others.
    pub enabled: bool,
    /// Where changes are recorded. Default `refinements`.
    pub folder: PathBuf,
    /// Seconds from one look at what was gathered to the next. Default 60, 1 to 86400.
    pub period_s: f64,
    /// What is asked of a change.
    pub limits: RefinementOptions,
}

impl Default for RefinementConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            folder: "refinements".into(),
            period_s: 60.0,
            limits: RefinementOptions::default(),
        }
    }
}

impl FusionConfig {
    /// Whether every number is in its range.
    ///
    /// # Errors
    /// The first that is not, in words.
    pub fn check(&self) -> Result<(), String> {
        if !(0.05..=60.0).contains(&self.max_age_s) {
            return Err("max_age_s must lie between 0.05 and 60".to_owned());
        }
        self.refinement.check()
    }
}

impl RefinementConfig {
    /// Whether every number is in its range.
    ///
    /// # Errors
    /// The first that is not, in words.
    pub fn check(&self) -> Result<(), String> {
        if !(1.0..=86_400.0).contains(&self.period_s) {
            return Err("refinement.period_s must lie between 1 and 86400".to_owned());
        }
        let sound = self.limits.check();
        sound.map_err(|cause| format!("refinement.limits.{cause}"))
    }
}

fn default_node() -> NodeId {
    #[allow(clippy::expect_used, reason = "a literal of the right form")]
    NodeId::new("fusion").expect("an id")
}

fn default_max_age_s() -> f64 {
    FusionOptions::default().window_s
}

fn default_network() -> BusOptions {
    BusOptions::router_on("tcp/127.0.0.1:7447")
}
