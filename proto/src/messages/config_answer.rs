//! The answer to a change of the configuration, by the fusion node that publishes the poses.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::ids::NodeId;
use crate::limits::MAX_PEERS;
use crate::messages::refusal::Refusal;
use crate::wire;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The answer to one payload under a `config/` key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConfigAnswer {
    /// The node; the same as in the key.
    pub node: NodeId,
    /// The changed key below the site: `config/rig`, `config/object/<object>`, `config/camera/<camera>` or
    /// `config/models`.
    pub key: String,
    /// [`fingerprint`] of the payload answered.
    pub fingerprint: u64,
    /// What became of it.
    pub outcome: ChangeOutcome,
    /// The other fusion nodes that work from it too.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_PEERS>")]
    pub followers: Vec<NodeId>,
    /// The other fusion nodes that did not within a second, and will as soon as they can.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_PEERS>")]
    pub behind: Vec<NodeId>,
}

/// What became of a change. On the wire the number of the variant, from 0.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeOutcome {
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

/// [`fingerprint`] over all models of a site: of each the key below the site and the payload, in the order of the keys.
#[must_use]
pub fn models_fingerprint<'a>(models: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> u64 {
    let sorted: BTreeMap<&str, &[u8]> = models.into_iter().collect();
    let each = sorted.iter().flat_map(|(key, payload)| {
        let of_payload = fingerprint(payload).to_le_bytes();
        key.bytes().chain([0]).chain(of_payload)
    });
    fingerprint(&each.collect::<Vec<u8>>())
}

impl Message for ConfigAnswer {
    const KIND: MessageKind = MessageKind::ConfigAnswer;

    fn check(&self) -> Result<(), OutOfRange> {
        check::detail(&self.key, "key")?;
        holds(self.followers.len() <= MAX_PEERS, "followers")?;
        holds(self.behind.len() <= MAX_PEERS, "behind")?;
        match &self.outcome {
            ChangeOutcome::Refused(refusal) => refusal.check("outcome"),
            ChangeOutcome::Taken | ChangeOutcome::Kept | ChangeOutcome::Same => Ok(()),
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
