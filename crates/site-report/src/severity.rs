//! Whether a finding calls for action.

use serde::{Deserialize, Serialize};

/// How much a finding of a node matters. A [`Fault`](crate::Fault) is a fault; an [`Imperfection`](crate::Imperfection)
/// is information, since no file is exact and poses allow for it; a notice or camera notice of the network's contract
/// states its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Poses are missing, late or worse than published until somebody acts.
    Fault,
    /// The site works; acting may improve it.
    Information,
}
