//! Subscribes to a Sextant site: which cameras and objects there are, the pose of each object as it moves, at a time,
//! and relative to another object.
//!
//! ```no_run
//! use sextant_client::Site;
//!
//! fn main() -> Result<(), sextant_client::Error> {
//!     let site = Site::connect("tcp/127.0.0.1:7447", "demo")?;
//!     for pose in site.poses("cuboid")? {
//!         println!("{} {:?} {}", pose.t_ns, pose.state, pose.position);
//!     }
//!     Ok(())
//! }
//! ```
//!
//! [`Site`] is the place to start. A connection that breaks is made again without help, and subscriptions go on. Every
//! queue has a bound and counts what it drops ([`Messages::counts`]). Metres, radians, nanoseconds since the Unix epoch
//! by the clock of the cameras; `a_from_b` maps points of b into a.
//!
//! Threads: a [`Site`] is shared by reference or in an `Arc`. Its methods block for as long as their docs say; only
//! [`MessageStream`] is asynchronous, and it works with any executor.

mod connect;
mod error;
mod history;
mod interpolation;
mod inventory;
mod messages;
mod pose;
mod relative;
mod site;

pub use connect::SiteOptions;
pub use error::Error;
pub use inventory::{Camera, Node, Object};
pub use messages::{Counts, MessageStream, Messages};
pub use pose::{Pose, State};
pub use relative::Transform;
pub use sextant_proto::{
    CameraConfig, CameraStatus, FusionStatus, NodeKind, ObjectConfig, Observations, TagObservation,
};
pub use site::Site;

/// Compiles the examples of the guide.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/subscribe.md")]
struct Guide;
