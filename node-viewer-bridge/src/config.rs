//! `viewer.toml`: what a person sets of a viewer bridge.

use axum::http::Uri;
use serde::{Deserialize, Serialize};
use sextant_proto::{NodeId, SiteId};
use sextant_zenoh_bus::{BusError, BusOptions, Identity, Role, Security, SecurityOptions};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

/// Longest address of a webhook, bytes.
const LONGEST_URL: usize = 2048;

/// The settings of a viewer bridge: contents of `viewer.toml`.
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
    /// Whether the page of a site without keys is served by TLS, with a certificate that the bridge makes for itself
    /// and keeps in `folder`. Browsers warn of it once; phones can be cameras then. Pages of a site with keys are
    /// served by TLS in any case.
    #[serde(default)]
    pub https: bool,
    /// Where the wizards keep what they found, beside this file or absolute: `rig.toml`, and `objects/<object>.toml`
    /// for each learned object; what was there is kept as `FILE.former`, older versions are numbered. Without it they
    /// keep results on the running site only. Zones are kept there as `zones.toml`; without it they last as long as the
    /// bridge.
    #[serde(default)]
    pub folder: Option<PathBuf>,
    /// Where events of zones are sent besides the network.
    #[serde(default)]
    pub webhook: Option<WebhookOptions>,
    /// How to reach the network; by default a client of the router on port 7447 of this machine.
    #[serde(default)]
    pub network: BusOptions,
    /// How the network and the page are protected; by default by being this machine's own.
    #[serde(default)]
    pub security: SecurityOptions,
}

/// The `[webhook]` section of `viewer.toml`: where events of zones are posted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WebhookOptions {
    /// Where events of zones are POSTed, such as `http://192.168.1.20:8080/sextant`. Plain HTTP.
    pub url: WebhookUrl,
}

/// An address that events can be sent to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct WebhookUrl(Uri);

impl TryFrom<String> for WebhookUrl {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let uri = text.parse::<Uri>().map_err(|error| error.to_string())?;
        let is_right = uri.scheme_str() == Some("http") && uri.host().is_some();
        if is_right && text.len() <= LONGEST_URL {
            Ok(Self(uri))
        } else {
            Err("write http://HOST:PORT/PATH".to_owned())
        }
    }
}

impl WebhookUrl {
    pub(crate) fn uri(&self) -> &Uri {
        &self.0
    }
}

impl From<WebhookUrl> for String {
    fn from(url: WebhookUrl) -> Self {
        url.0.to_string()
    }
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
    fn a_webhook_is_an_address_of_plain_http() {
        let with = |url: &str| read(&format!("site = \"demo\"\n[webhook]\nurl = \"{url}\""));
        assert!(with("http://127.0.0.1:9/hook").unwrap().webhook.is_some());
        let error = with("ftp://127.0.0.1/").unwrap_err();
        assert!(
            error.contains("url") && error.contains("http://"),
            "{error}"
        );
    }

    #[test]
    fn an_unknown_key_is_refused_by_name() {
        let error = read("site = \"demo\"\nlisten_on = \"127.0.0.1:1\"").unwrap_err();
        assert!(error.contains("listen_on"), "{error}");
    }

    #[test]
    fn only_plain_http_addresses_are_taken() {
        for wrong in ["https://a/", "/hook", "a:1", "http://", "file:///etc"] {
            assert!(WebhookUrl::try_from(wrong.to_owned()).is_err(), "{wrong}");
        }
        assert!(WebhookUrl::try_from("http://[::1]:8080/hook".to_owned()).is_ok());
    }
}
