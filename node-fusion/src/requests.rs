//! Requests for changes of the site, told from what a fusion node announces to be in force.

use crate::models::Change;
use crate::refusals::undecodable;
use crate::replica::{Origin, Request};
use sextant_proto::{ANNOUNCED, DecodeError, Keys, fingerprint};
use sextant_zenoh_bus::{Item, Payload};

/// Most announcements and other messages that are passed over in one turn.
const PASSED_OVER: usize = 256;

/// The next request of a queue; what is none is passed over.
pub fn next(keys: &Keys, queue: impl FnMut() -> Option<Item>) -> Option<Request> {
    let mut items = std::iter::from_fn(queue).take(PASSED_OVER);
    items.find_map(|item| request(keys, &item))
}

fn request(keys: &Keys, item: &Item) -> Option<Request> {
    let about = keys.parse(&item.key)?;
    let is_announced = |sender: &str| sender.starts_with(ANNOUNCED);
    if !about.is_config() || item.sender.as_deref().is_some_and(is_announced) {
        return None;
    }
    Some(Request {
        key: Keys::below_site(&item.key).to_owned(),
        fingerprint: item.bytes().map_or(0, fingerprint),
        changes: match &item.payload {
            Payload::Bytes(bytes) => Change::read_all(&about, bytes),
            Payload::TooLong(length) => Err(undecodable(DecodeError::TooLong(*length))),
        },
        origin: Origin::Request {
            about,
            sender: item.sender.clone(),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ModelPayload, NodeId, ObjectConfig, Proposal, Refusal, encode};
    use sextant_site_files::parse_object;
    use std::path::Path;

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
    fn announcements_and_other_keys_are_passed_over_in_bounded_number() {
        let payload = encode(&cube()).unwrap();
        let announced = item("object/cube", payload.clone(), Some("fusion/other"));
        let elsewhere = item("else", payload.clone(), None);
        let asked = item("object/cube", payload, Some("ann@desk"));
        let mut queue = [announced.clone(), elsewhere, asked, announced.clone()].into_iter();
        let request = next(&keys(), || queue.next()).unwrap();
        assert_eq!(
            (request.key.as_str(), queue.len()),
            ("config/object/cube", 1)
        );
        assert_eq!(request.changes.unwrap().len(), 1);
        let mut flood = std::iter::repeat_n(announced, 10 * PASSED_OVER);
        assert_eq!(next(&keys(), || flood.next()), None);
        assert_eq!(flood.len(), 9 * PASSED_OVER);
    }

    #[test]
    fn a_proposal_is_several_changes_and_garbage_is_a_refusal() {
        let mut proposal = Proposal::none(NodeId::new("main").unwrap(), 1);
        let removal = ObjectConfig::removal("box".parse().unwrap());
        proposal.objects = [removal, cube()]
            .iter()
            .map(|one| ModelPayload::of(one).unwrap())
            .collect();
        let asked = item("models", encode(&proposal).unwrap(), None);
        let changes = request(&keys(), &asked).unwrap().changes.unwrap();
        assert!(matches!(
            &changes[..],
            [Change::Removal(_), Change::Object(_)]
        ));
        let garbage = request(&keys(), &item("rig", vec![1], None)).unwrap();
        assert!(matches!(garbage.changes, Err(Refusal::Undecodable { .. })));
        let long = Item {
            payload: Payload::TooLong(1 << 20),
            ..asked
        };
        let long = request(&keys(), &long).unwrap();
        assert!(matches!(long.changes, Err(Refusal::Undecodable { .. })));
    }
}
