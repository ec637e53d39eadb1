//! The viewer bridge: what happens on a site's network, as a web page and as JSON on a WebSocket (`PROTOCOL.md`).
//!
//! Input: everything under the site's keys. Output: HTTP on one address, and events of zones on the network and to a
//! webhook. It changes the site only where a person keeps what a wizard found (`wizard`).
//!
//! Invariant: no client holds up another one or the network: each has one slot per message type and id, newest wins.
//! Invariant: nothing listens beyond the configured address, and no page but the bridge's own may read it.
//! Invariant: where other machines reach it, every answer about the site needs a token (`access`), unless the profile
//! is open.

mod access;
mod assets;
mod bridge;
mod camera_network;
mod camera_socket;
mod certificate;
mod changes;
mod config;
mod connections;
mod forwarder;
mod frame;
mod guard;
mod http_client;
mod hub;
mod last_seconds;
mod link_frames;
mod message;
mod metrics;
mod models;
mod network;
#[cfg(test)]
mod panic_tests;
mod phone_claims;
mod phone_links;
mod protection;
mod refusal;
mod request;
mod server;
mod session;
mod shared;
mod socket;
mod translate;
mod web_camera;
mod webhook;
mod wizard;
mod zones;

pub use bridge::run;
pub use config::{ViewerConfig, WebhookOptions, WebhookUrl};
pub use last_seconds::download::download_last_seconds;
pub use phone_links::{PhoneLink, PhoneLinks, PhonePage, phone_links, phone_page};
pub use protection::Protection;
