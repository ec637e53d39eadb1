//! A running site in other tools. Each gateway subscribes to the site, holds a mirror of it (`sextant-site-mirror`) and
//! passes it on in the protocol of the tool: `sextant-recordings`, `sextant-ros2` and `sextant-pose-streams` define
//! which message becomes what.
//!
//! - [`site`]: the session on a site that every tool has.
//! - [`foxglove`], [`ros2`]: everything that a site publishes.
//! - [`pose_feed`]: poses only, for [`osc`], [`mavlink`], [`vrpn`], [`natnet`], [`mqtt`], [`nt4`], [`psn`] and
//!   [`camera_tracking`], and for anything that implements [`PoseReceiver`].
//!
//! A gateway never waits for a slow reader. What a person should know while it runs goes to a [`Reporter`]; nothing is
//! printed here.

pub mod camera_tracking;
pub mod datagrams;
pub mod foxglove;
pub mod listening;
pub mod mavlink;
pub mod mqtt;
pub mod natnet;
pub mod nt4;
pub mod osc;
pub mod pose_feed;
pub mod psn;
mod relay;
mod report;
pub mod ros2;
pub mod site;
pub mod vrpn;

pub use pose_feed::PoseReceiver;
pub use report::{Notice, Reporter};
pub use site::SiteSession;
