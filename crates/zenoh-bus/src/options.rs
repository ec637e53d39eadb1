//! The `[network]` section of every node's configuration.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// How a process takes part in the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    /// Connects to one router only: the choice for every node of a site with a router.
    #[default]
    Client,
    /// Connects to the listed peers directly, without a router.
    Peer,
    /// Is the router: listens, and routes messages between clients.
    Router,
}

impl Mode {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Client => "client",
            Self::Peer => "peer",
            Self::Router => "router",
        }
    }
}

/// The network of a process. Endpoints are zenoh's: `tcp/<address>:<port>`, or `quic/<address>:<port>` with profile
/// site. There is no discovery by multicast or gossip: all endpoints are listed here.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BusOptions {
    /// client (default), peer or router.
    pub mode: Mode,
    /// Endpoints to connect to. Default: port 7447 of this host for a client, none for others.
    pub connect: Option<Vec<String>>,
    /// Endpoints to listen on; port 0 selects a free one (see [`crate::Bus::endpoints`]). Default: none.
    pub listen: Vec<String>,
    /// Silence after which a link counts as dead, in ms, 500 to 60000 (default 2000: a lost board shows within 2 s;
    /// raise it for lossy radio links).
    pub lease_ms: u32,
    /// Time limit of a query, in ms, 10 to 60000 (default 2000).
    pub query_timeout_ms: u32,
    /// Largest accepted message, in bytes, at least 65536 (default 4 MiB: zenoh's own 1 GiB exceeds the memory
    /// of a board).
    pub max_message_bytes: u32,
    /// Most simultaneous links, 1 to 1000 (default 64).
    pub max_links: u16,
    /// Further options of zenoh, path = JSON5 value: `"transport/link/tx/queue/size/background" = "8"`.
    pub overrides: BTreeMap<String, String>,
}

impl Default for BusOptions {
    fn default() -> Self {
        Self {
            mode: Mode::Client,
            connect: None,
            listen: Vec::new(),
            lease_ms: 2000,
            query_timeout_ms: 2000,
            max_message_bytes: 4 << 20,
            max_links: 64,
            overrides: BTreeMap::new(),
        }
    }
}

impl BusOptions {
    /// A client of the router at `endpoint`.
    pub fn client_of(endpoint: &str) -> Self {
        Self {
            connect: Some(vec![endpoint.to_owned()]),
            ..Self::default()
        }
    }

    /// A router that listens on `endpoint`.
    pub fn router_on(endpoint: &str) -> Self {
        Self {
            mode: Mode::Router,
            listen: vec![endpoint.to_owned()],
            ..Self::default()
        }
    }
}
