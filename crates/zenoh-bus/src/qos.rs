//! How each stream is treated when the network is slow.

use zenoh::qos::{CongestionControl, Priority};

/// The class of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Qos {
    /// Observations of images: high priority, not held back for batching, dropped when congested.
    Observation,
    /// Poses of objects: as observations.
    Pose,
    /// Preview pictures: behind everything else, dropped when congested. Publish them from their own thread: a picture
    /// may wait up to 50 ms for room.
    Preview,
    /// Status: ordinary, dropped when congested (the next comes in a second).
    Status,
    /// Configuration: ordinary, waits for room.
    Config,
}

impl Qos {
    pub(crate) fn priority(self) -> Priority {
        match self {
            Self::Observation | Self::Pose => Priority::InteractiveHigh,
            Self::Status | Self::Config => Priority::Data,
            Self::Preview => Priority::Background,
        }
    }

    pub(crate) fn congestion(self) -> CongestionControl {
        if self == Self::Config {
            CongestionControl::Block
        } else {
            CongestionControl::Drop
        }
    }

    pub(crate) fn is_express(self) -> bool {
        matches!(self, Self::Observation | Self::Pose)
    }
}
