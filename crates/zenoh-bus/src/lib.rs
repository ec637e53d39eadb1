//! The site's network: one blocking session, publishers, bounded subscriptions, latest values for late joiners,
//! liveliness, and access control. Wraps zenoh, whose types do not appear in this interface. Knows keys and bytes; the
//! messages are defined in `proto`.
//!
//! Invariant: a zenoh callback only copies into a bounded queue (or answers a query from a stored value); no caller's
//! code that may block runs on a zenoh thread.

mod bus;
mod compiled;
mod config;
mod control_probe;
mod error;
mod history;
mod liveliness;
mod name;
mod options;
mod probe;
mod publisher;
mod qos;
mod query;
mod runtime;
mod security;
mod shelf;
mod subscription;

pub use bus::Bus;
pub use control_probe::ControlProbe;
pub use error::{BusError, SecurityError};
pub use history::{AttachedPublisher, Audience};
pub use liveliness::{AliveToken, AliveWatch, Presence};
pub use name::HeldName;
pub use options::{BusOptions, Mode};
pub use probe::{NO_SESSION, why_no_router};
pub use publisher::{Latest, Publisher, RawLatest, RawPublisher};
pub use qos::Qos;
pub use query::Question;
pub use security::{
    Identity, KeyFiles, Member, Members, NodeKeys, Profile, Role, Security, SecurityOptions,
};
pub use sextant_queue::{DropRule, QueueCounts, StreamBounds};
pub use shelf::Shelf;
pub use subscription::{CallbackSubscription, Item, Payload, Subscription};
