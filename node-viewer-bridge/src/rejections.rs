//! Payloads that the bridge could not show, by cause.

use serde::Serialize;
use sextant_proto as proto;

/// Counts since the start.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct Rejections {
    #[serde(flatten)]
    undecodable: proto::Rejections,
    wrong_id: u64,
    too_many: u64,
}

/// Why a payload is not shown.
#[derive(Debug)]
pub(crate) enum Rejection {
    /// It is no message of its key's kind.
    Undecodable(proto::DecodeError),
    /// It names another camera, object or node than its key.
    WrongId,
    /// The bridge keeps no more cameras, objects and nodes.
    TooMany,
}

impl Rejections {
    pub(crate) fn count(&mut self, why: &Rejection) {
        match why {
            Rejection::Undecodable(cause) => self.undecodable.count(cause),
            Rejection::WrongId => self.wrong_id += 1,
            Rejection::TooMany => self.too_many += 1,
        }
    }
}
