//! `CONTRACT.md` says what the code does: keys, kinds, lengths, and the type of every message down to its last field
//! and variant.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod traced;

use sextant_contract::{Contract, KindRow};
use sextant_proto::*;
use std::collections::BTreeSet;
use std::path::Path;
use traced::trace;

/// Each enum takes variant `round` modulo its number of variants: so many rounds reach every variant, nested ones
/// included.
const ROUNDS: usize = 400;

fn contract() -> Contract {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("CONTRACT.md");
    Contract::read(&std::fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn every_key_of_the_contract_holds_the_message_that_the_code_expects() {
    let keys = Keys::new("lab").unwrap();
    let mut kinds = BTreeSet::new();
    for row in contract().keys {
        let key = row.key.replace("<kind>", "fusion").replace(['<', '>'], "");
        if key.starts_with("holder/") {
            continue;
        }
        let parsed = keys.parse(&format!("sextant/v1/lab/{key}"));
        let kind = parsed.unwrap_or_else(|| panic!("{key}")).kind();
        let expected = kind.map(|kind| (format!("{kind:?}"), kind as u8));
        assert_eq!(row.message, expected, "{key}");
        kinds.extend(kind);
    }
    assert_eq!(kinds, BTreeSet::from(MessageKind::ALL));
}

#[test]
fn every_kind_of_the_contract_is_as_long_as_the_code_allows() {
    let rows = MessageKind::ALL.map(|kind| KindRow {
        number: kind as u8,
        message: format!("{kind:?}"),
        max_bytes: kind.max_bytes(),
    });
    assert_eq!(contract().kinds, rows);
}

#[test]
fn every_message_of_the_contract_has_the_fields_and_variants_of_the_code() {
    let contract = contract();
    for kind in MessageKind::ALL {
        let trace = match kind {
            MessageKind::Observations => trace::<Observations>,
            MessageKind::Preview => trace::<Preview>,
            MessageKind::DetectionReport => trace::<DetectionReport>,
            MessageKind::CameraStatus => trace::<CameraStatus>,
            MessageKind::ObjectPose => trace::<ObjectPose>,
            MessageKind::ObjectLinks => trace::<ObjectLinks>,
            MessageKind::ObjectTruth => trace::<ObjectTruth>,
            MessageKind::FusionStatus => trace::<FusionStatus>,
            MessageKind::ClockReport => trace::<ClockReport>,
            MessageKind::ConfigAnswer => trace::<ConfigAnswer>,
            MessageKind::Proposal => trace::<Proposal>,
            MessageKind::RigConfig => trace::<RigConfig>,
            MessageKind::ObjectConfig => trace::<ObjectConfig>,
            MessageKind::FusionInputs => trace::<FusionInputs>,
            MessageKind::CameraSettings => trace::<CameraSettings>,
            MessageKind::Heartbeat => trace::<Heartbeat>,
        };
        for round in 0..ROUNDS {
            trace(&contract, &format!("{kind:?}"), round);
        }
    }
}
