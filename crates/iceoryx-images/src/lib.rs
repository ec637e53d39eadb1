//! The images of one camera in shared memory: one process publishes, up to four others read without a copy, and a slow
//! reader gets the newest image. Wraps iceoryx2, whose types do not appear in this interface. Knows grey pixels and
//! their header, but no cameras, tags or network.
//!
//! Invariant: the publisher never waits for a subscriber, and a process that crashes blocks no other.

mod domain;
mod error;
mod folder;
mod header;
mod leftovers;
mod options;
mod publisher;
mod service;
mod subscriber;

pub use domain::companion_file;
pub use error::ImagesError;
pub use folder::open_own_folder;
pub use header::{ClockSource, FORMAT_GREY8, ImageHeader};
pub use leftovers::{Leftovers, remove_dead};
pub use options::IceoryxOptions;
pub use publisher::{BlankImage, ImagePublisher};
pub use service::MAX_SUBSCRIBERS;
pub use subscriber::{ImageSubscriber, LentImage};
