//! Quality of service of each stream when the network is congested.

use zenoh::qos::{CongestionControl, Priority};

/// The class of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Qos {
    /// Observations of images: high priority, sent without batching, dropped when congested.
    Observation,
    /// Poses of objects: as observations.
    Pose,
    /// Preview pictures: lowest priority, dropped when congested. Publish them from their own thread: a picture
    /// may wait up to 50 ms for room.
    Preview,
    /// Status: normal priority, dropped when congested (the next follows within a second).
    Status,
    /// Configuration: normal priority, blocks when congested.
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
