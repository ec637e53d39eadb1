//! Why a fusion node refuses a change of the configuration.

use crate::check::{self, OutOfRange};
use serde::{Deserialize, Serialize};
use sextant_site_model::{CameraId, ObjectId, TagId};

/// The cause of a refusal, with what it is about. `detail` is English text for people.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The payload is not a message of the kind that its key holds, or a value is out of range.
    #[error("{detail}")]
    Undecodable {
        /// What is wrong with it.
        detail: String,
    },
    /// The payload describes another object than its key.
    #[error("the payload describes object {described}, not that of its key")]
    WrongId {
        /// The object that it describes.
        described: ObjectId,
    },
    /// A rig without cameras.
    #[error("the rig has no camera")]
    NoCamera,
    /// A camera that no rig file could describe.
    #[error("{detail}")]
    InvalidCamera {
        /// The camera.
        camera: CameraId,
        /// What is wrong with it.
        detail: String,
    },
    /// Tags, links or joints that no object file could describe.
    #[error("{detail}")]
    InvalidObject {
        /// The tag concerned; none where a link or joint is.
        tag: Option<TagId>,
        /// What is wrong.
        detail: String,
    },
    /// A tag that its family does not have.
    #[error("{} has no tag {}; its ids are 0 to {}", .tag.family, .tag.id, .n_ids.saturating_sub(1))]
    UnknownTag {
        /// The tag.
        tag: TagId,
        /// Number of tags in the family.
        n_ids: u32,
    },
    /// A tag on two objects.
    #[error(
        "tag {tag} is on object {first} and on object {second}: print another id for one of them"
    )]
    SharedTag {
        /// The tag.
        tag: TagId,
        /// The object that has it.
        first: ObjectId,
        /// The object that claims it as well.
        second: ObjectId,
    },
    /// More objects than a site may have.
    #[error("a site has at most {limit} objects")]
    TooManyObjects {
        /// How many it may have.
        limit: u32,
    },
    /// The models after the change could not be announced.
    #[error("{detail}")]
    Unpublishable {
        /// What does not fit into a message.
        detail: String,
    },
    /// The change could not be written to the node's files.
    #[error("the change cannot be written to the node's files: {detail}")]
    NotStored {
        /// What the system says.
        detail: String,
    },
    /// Anything else.
    #[error("{detail}")]
    Other {
        /// What is wrong.
        detail: String,
    },
}

impl Refusal {
    pub(crate) fn check(&self, field: &'static str) -> Result<(), OutOfRange> {
        match self {
            Self::Undecodable { detail }
            | Self::InvalidCamera { detail, .. }
            | Self::InvalidObject { detail, .. }
            | Self::Unpublishable { detail }
            | Self::NotStored { detail }
            | Self::Other { detail } => check::detail(detail, field),
            Self::WrongId { .. }
            | Self::NoCamera
            | Self::UnknownTag { .. }
            | Self::SharedTag { .. }
            | Self::TooManyObjects { .. } => Ok(()),
        }
    }
}
