//! Browsers as cameras of the site: a page sends what it detects, and this bridge publishes it as a camera node would.
//!
//! - [`clock`]: offset and drift of a browser's clock by round trips.
//! - [`session`]: one browser's messages: checked, converted to this host's time, counted. Sans-I/O.
//! - [`registry`]: which browser has which camera's name, and what waits for the network.
//!
//! Knows no socket and no network: those are `camera_socket` and `camera_network`.

mod clock;
pub(crate) mod registry;
pub(crate) mod session;
