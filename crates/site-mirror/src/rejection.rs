//! Payloads that were refused, by cause.

use crate::bounded_map::Full;
use serde::Serialize;
use sextant_proto::{self as proto, DecodeError};

/// Why a payload is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Rejection {
    /// It is no message of its key's kind.
    #[error(transparent)]
    Undecodable(#[from] DecodeError),
    /// It names another camera, object or node than its key.
    #[error("it names another camera, object or node than its key")]
    WrongId,
    /// A rig or an object that makes no sense, and why.
    #[error("{0}")]
    InvalidModel(String),
    /// A pose or links of a fusion node that another one has replaced.
    #[error("another fusion node publishes this object")]
    Superseded,
    /// There is no room for another camera, object, tag or node.
    #[error(transparent)]
    TooMany(#[from] Full),
}

/// Counts of refused payloads. Superseded ones are counted apart, since every takeover has some.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Rejections {
    #[serde(flatten)]
    undecodable: proto::Rejections,
    wrong_id: u64,
    invalid_model: u64,
    too_many: u64,
    #[serde(skip)]
    superseded: u64,
}

impl Rejections {
    /// Counts a refused payload under its cause.
    pub(crate) fn count(&mut self, why: &Rejection) {
        let counter = match why {
            Rejection::Undecodable(cause) => return self.undecodable.count(cause),
            Rejection::WrongId => &mut self.wrong_id,
            Rejection::InvalidModel(_) => &mut self.invalid_model,
            Rejection::Superseded => &mut self.superseded,
            Rejection::TooMany(_) => &mut self.too_many,
        };
        *counter = counter.saturating_add(1);
    }

    /// Payloads that break the contract or name another id than their key.
    #[must_use]
    pub fn invalid(&self) -> u64 {
        let further = self.wrong_id.saturating_add(self.invalid_model);
        self.undecodable.total().saturating_add(further)
    }

    /// Poses and links of fusion nodes that others have replaced.
    #[must_use]
    pub fn superseded(&self) -> u64 {
        self.superseded
    }

    /// Payloads for which there was no room.
    #[must_use]
    pub fn too_many(&self) -> u64 {
        self.too_many
    }
}
