//! Which of a site's fusion nodes publishes, and when another takes over.
//!
//! Input: heartbeats of the other nodes, their liveliness, the state of this node's link, and time. Output: heartbeats,
//! and whether this node may publish, under which epoch. Knows no network and no clock.
//!
//! - Each node sends a heartbeat 20 times a second. A standby that hears no publisher for 200 ms takes an epoch greater
//!   than all it knows of and publishes. Of several standbys the first by name goes first; each further one waits 50 ms
//!   longer.
//! - When two publishers receive each other's heartbeats, as after a partition, the one with the older epoch becomes a
//!   standby. A publisher that was replaced remains a standby until it is needed again.
//! - A node that was stopped, suspended or cut off may have been replaced without knowing. It notices by its own clock
//!   or its link, and publishes again only after every other node has answered a heartbeat sent after the interruption.
//!   The answer proves that what the other node said before has been received. It does not wait for nodes that were
//!   silent before, and for the others for half a second.
//! - A standby that was interrupted restarts its timeout: the silence may have been its own.
//!
//! [`Sharding`] divides the objects of a site among its fusion nodes, by the heartbeats and the presence that the
//! election knows of.

mod election;
mod sharding;

pub use election::{Company, Election, Input, Link, Moment};
pub use sharding::{Assignment, Sharding, ranking};
