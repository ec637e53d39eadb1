//! Browsers as cameras of the site: a page sends what it detects, and this bridge publishes it as a camera node would.
//!
//! - [`clock`]: offset and drift of a browser's clock by round trips.
//! - [`session`]: one browser's messages: checked, converted to this host's time, counted. Sans-I/O.
//! - [`registry`]: which browser has which camera's name, and what waits for the network.
//! - [`network`]: names, liveliness and messages on the site's network, by a thread of its own.
//! - [`socket`]: the WebSocket.

mod clock;
pub(crate) mod network;
pub(crate) mod registry;
mod session;
pub(crate) mod socket;
