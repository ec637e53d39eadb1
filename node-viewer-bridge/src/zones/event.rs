//! What happened, as it is published.

use serde::Serialize;
use sextant_site_model::ObjectId;

/// An event of an object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Event {
    /// Number of the event since the bridge started.
    pub(crate) sequence: u64,
    /// Capture time of the image that decided it, ns since the Unix epoch.
    pub(crate) t_ns: u64,
    pub(crate) object: ObjectId,
    #[serde(flatten)]
    pub(crate) kind: EventKind,
    /// The object's origin in the world at that time, metres.
    pub(crate) position: [f64; 3],
}

/// What an object did.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub(crate) enum EventKind {
    Entered { zone: String },
    Left { zone: String },
    Fell { cause: FallCause },
}

/// What shows a fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FallCause {
    /// It lost height faster than it would be put down.
    Drop,
    /// It tipped over where it stood.
    Tilt,
}
