//! Requests for changes of the site, as opposed to what a fusion node announces to be in force.

use crate::models::Change;
use crate::proposing::Proposals;
use crate::refusals::undecodable;
use crate::replica::{Origin, Request};
use sextant_proto::{ANNOUNCED, DecodeError, KeyRef, Keys, Proposal, Refusal, decode, fingerprint};
use sextant_zenoh_bus::{Item, Payload};

/// The request of a message; none where it is no request. It may name a proposal of this node.
pub fn parse(keys: &Keys, item: &Item, proposals: &Proposals) -> Option<Request> {
    let about = keys.parse(&item.key)?;
    let is_announced = |sender: &str| sender.starts_with(ANNOUNCED);
    if !about.is_config() || item.sender.as_deref().is_some_and(is_announced) {
        return None;
    }
    Some(Request {
        key: Keys::below_site(&item.key).to_owned(),
        fingerprint: item.bytes().map_or(0, fingerprint),
        changes: match &item.payload {
            Payload::Bytes(bytes) => changes(&about, bytes, proposals),
            Payload::TooLong(length) => Err(undecodable(DecodeError::TooLong(*length))),
        },
        origin: Origin::Request {
            about,
            sender: item.sender.clone(),
        },
    })
}

/// The changes that a payload asks for. One without models names those that a node has proposed, by the node and the
/// number.
fn changes(about: &KeyRef, payload: &[u8], proposals: &Proposals) -> Result<Vec<Change>, Refusal> {
    if *about == KeyRef::ConfigModels
        && let Ok(named) = decode::<Proposal>(payload)
        && named.is_empty()
    {
        return proposals.changes(&named.node, named.t_ns);
    }
    Change::read_all(about, payload)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ModelPayload, NodeId, ObjectConfig, encode};
    use sextant_site_files::parse_object;
    use std::path::Path;

    fn parsed(keys: &Keys, item: &Item) -> Option<Request> {
        parse(keys, item, &Proposals::new(NodeId::new("main").unwrap()))
    }

    fn keys() -> Keys {
        Keys::new("lab").unwrap()
    }

    fn cube() -> ObjectConfig {
        let text = "id = \"cube\"\n[[tag]]\nfamily = \"tag36h11\"\nid = 1\nsize = 0.04\n";
        ObjectConfig::from(&parse_object(Path::new("o"), text).unwrap())
    }

    fn item(key: &str, payload: Vec<u8>, sender: Option<&str>) -> Item {
        Item {
            key: format!("sextant/v1/lab/config/{key}"),
            payload: Payload::Bytes(payload),
            sender: sender.map(str::to_owned),
        }
    }

    #[test]
    fn announcements_and_other_keys_are_no_requests() {
        let payload = encode(&cube()).unwrap();
        let announced = item("object/cube", payload.clone(), Some("fusion/other"));
        let elsewhere = item("else", payload.clone(), None);
        assert_eq!(parsed(&keys(), &announced), None);
        assert_eq!(parsed(&keys(), &elsewhere), None);
        let request = parsed(&keys(), &item("object/cube", payload, Some("ann@desk"))).unwrap();
        assert_eq!(request.key, "config/object/cube");
        assert_eq!(request.changes.unwrap().len(), 1);
    }

    #[test]
    fn a_proposal_is_several_changes_and_garbage_is_a_refusal() {
        let mut proposal = Proposal::none(NodeId::new("main").unwrap(), 1);
        let removal = ObjectConfig::removal("box".parse().unwrap());
        proposal.objects = [removal, cube()]
            .iter()
            .map(|one| ModelPayload::encode(one).unwrap())
            .collect();
        let asked = item("models", encode(&proposal).unwrap(), None);
        let changes = parsed(&keys(), &asked).unwrap().changes.unwrap();
        assert!(matches!(
            &changes[..],
            [Change::Removal(_), Change::Object(_)]
        ));
        let named = Proposal::none(NodeId::new("main").unwrap(), 7);
        let named = parsed(&keys(), &item("models", encode(&named).unwrap(), None)).unwrap();
        assert!(matches!(named.changes, Err(Refusal::Other { .. })));
        let garbage = parsed(&keys(), &item("rig", vec![1], None)).unwrap();
        assert!(matches!(garbage.changes, Err(Refusal::Undecodable { .. })));
        let long = Item {
            payload: Payload::TooLong(1 << 20),
            ..asked
        };
        let long = parsed(&keys(), &long).unwrap();
        assert!(matches!(long.changes, Err(Refusal::Undecodable { .. })));
    }
}
