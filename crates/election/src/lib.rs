//! Which of a site's fusion nodes publishes, and when another takes over.
//!
//! Input: heartbeats of the other nodes, their liveliness, the state of this node's link, and time. Output: heartbeats, and whether this node may
//! publish, under which epoch. Knows no network and no clock.
//!
//! - Each node sends a heartbeat 20 times a second. A standby that hears no publisher for 200 ms takes an epoch greater than all it knows of and
//!   publishes. Of several standbys the first by name goes first; each further one waits 50 ms longer.
//! - Of two publishers that hear each other, as after the network was divided, the one with the older epoch stands by. Nobody hands a role
//!   back: a publisher that was replaced stays a standby until it is needed.
//! - A node that was stopped, suspended or cut off may have been replaced without knowing. It notices by its own clock or its link, and publishes
//!   again only after every other node has answered a heartbeat sent after the interruption. The answer proves that what the other node
//!   said before has been received. It does not wait for nodes that were silent before, and for the others for half a second.
//! - A standby that was interrupted has heard nobody for reasons of its own, and begins to listen anew.

mod election;

pub use election::{Company, Election, Input, Link, Moment};
