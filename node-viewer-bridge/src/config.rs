//! `viewer.toml`: what a person sets of a viewer bridge.

use serde::{Deserialize, Serialize};
use sextant_proto::{NodeId, SiteId};
use sextant_zenoh_bus::{BusError, BusOptions, Identity, Role, Security, SecurityOptions};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

/// The file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerConfig {
    /// The site to show; the middle of every key.
    pub site: SiteId,
    /// This bridge's name among the site's bridges.
    #[serde(default = "default_node")]
    pub node: NodeId,
    /// Where to serve the page, `address:port`. Default `127.0.0.1:8600`: this machine only. `0.0.0.0:8600` serves the
    /// whole network: by TLS and to those with a token, unless the profile is open.
    #[serde(default = "default_listen")]
    pub listen: SocketAddr,
    /// Names under which browsers reach this bridge, besides `localhost` and addresses, such as `viewer.lab`. Requests
    /// under other names are refused, so that no foreign web page can read the site through a visitor's browser.
    #[serde(default)]
    pub host_names: Vec<String>,
    /// Where the wizards keep what they found, beside this file or absolute: `rig.toml`, and `objects/<object>.toml` for each
    /// learned object; what was there is kept as `FILE.former`, older versions are numbered. Without it they keep results on the running site only.
    #[serde(default)]
    pub folder: Option<PathBuf>,
    /// How to reach the network; by default a client of the router on port 7447 of this machine.
    #[serde(default)]
    pub network: BusOptions,
    /// How the network and the page are protected; by default by being this machine's own.
    #[serde(default)]
    pub security: SecurityOptions,
}

impl ViewerConfig {
    /// The network's protection, with the keys read and checked; `folder` is that of the file.
    ///
    /// # Errors
    /// Keys and endpoints that do not go with the profile.
    pub(crate) fn network_protection(&self, folder: &Path) -> Result<Security, BusError> {
        let identity = Identity {
            site: self.site.as_str(),
            name: self.node.as_str(),
            roles: &[Role::Viewer, Role::Operator],
        };
        self.security.load(folder, identity, &self.network)
    }
}

fn default_node() -> NodeId {
    #[allow(clippy::expect_used, reason = "a literal of the right form")]
    NodeId::new("viewer").expect("an id")
}

fn default_listen() -> SocketAddr {
    SocketAddr::from((Ipv4Addr::LOCALHOST, 8600))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_files::parse_toml;
    use std::path::Path;

    fn read(text: &str) -> Result<ViewerConfig, String> {
        parse_toml(Path::new("viewer.toml"), text, |_: &ViewerConfig| Ok(()))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn a_site_is_enough_and_means_loopback() {
        let config = read("site = \"demo\"").unwrap();
        assert_eq!(config.listen.to_string(), "127.0.0.1:8600");
        assert!(config.host_names.is_empty());
    }

    #[test]
    fn an_unknown_key_is_refused_by_name() {
        let error = read("site = \"demo\"\nlisten_on = \"127.0.0.1:1\"").unwrap_err();
        assert!(error.contains("listen_on"), "{error}");
    }
}
