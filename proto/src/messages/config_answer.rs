//! A fusion node's answer to a change of the configuration.

use crate::check::{self, OutOfRange};
use crate::envelope::{Kind, Message};
use crate::ids::NodeId;
use crate::messages::refusal::Refusal;
use serde::{Deserialize, Serialize};

/// The answer to one payload under a `config/` key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConfigAnswer {
    /// The node; the same as in the key.
    pub node: NodeId,
    /// The changed key below the site: `config/rig` or `config/object/<object>`.
    pub key: String,
    /// [`fingerprint`] of the payload answered.
    pub fingerprint: u64,
    /// What became of it.
    pub outcome: Outcome,
}

/// What became of a change. On the wire the number of the variant, from 0.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// In force until the node ends.
    Taken,
    /// In force, and written to the node's files.
    Kept,
    /// Nothing has changed: it was in force already.
    Same,
    /// Nothing has changed.
    Refused(Refusal),
}

/// FNV-1a (64 bits) of a payload, header included: so that who published it recognises the answer.
#[must_use]
pub fn fingerprint(payload: &[u8]) -> u64 {
    payload.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

impl Message for ConfigAnswer {
    const KIND: Kind = Kind::ConfigAnswer;

    fn check(&self) -> Result<(), OutOfRange> {
        check::detail(&self.key, "key")?;
        match &self.outcome {
            Outcome::Refused(refusal) => refusal.check("outcome"),
            Outcome::Taken | Outcome::Kept | Outcome::Same => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fingerprint_is_fnv_1a() {
        assert_eq!(fingerprint(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fingerprint(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
