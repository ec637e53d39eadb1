//! The tables of `CONTRACT.md` list the keys, kinds and lengths that the code has.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use sextant_proto::{Keys, Kind};
use std::collections::BTreeSet;
use std::path::Path;

fn contract() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("CONTRACT.md");
    std::fs::read_to_string(file).unwrap()
}

/// The rows of the table with this head, without head and rule: their cells.
fn table(head: &str) -> Vec<Vec<String>> {
    let contract = contract();
    let rows = contract
        .lines()
        .skip_while(|line| !line.starts_with(head))
        .take_while(|line| line.starts_with('|'));
    let cells = |row: &str| {
        row.trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    rows.skip(2).map(cells).collect()
}

/// A kind as the tables write it.
fn written(kind: Kind) -> String {
    format!("{kind:?}, {}", kind as u8)
}

#[test]
fn every_key_of_the_contract_holds_the_message_that_the_code_expects() {
    let keys = Keys::new("lab").unwrap();
    let mut kinds = BTreeSet::new();
    for row in table("| key | message, kind |") {
        let [template, message, _] = &row[..] else {
            panic!("{row:?}");
        };
        let key = template.trim_matches('`').replace("<kind>", "fusion");
        let key = key.replace(['<', '>'], "");
        if key.starts_with("holder/") {
            continue;
        }
        let parsed = keys.parse(&format!("sextant/v1/lab/{key}"));
        let kind = parsed.unwrap_or_else(|| panic!("{key}")).kind();
        let expected = kind.map_or_else(|| "liveliness token".to_owned(), written);
        assert_eq!(*message, expected, "{key}");
        kinds.extend(kind);
    }
    assert_eq!(kinds, BTreeSet::from(Kind::ALL));
}

#[test]
fn every_kind_of_the_contract_is_as_long_as_the_code_allows() {
    let rows = Kind::ALL.map(|kind| {
        let number = (kind as u8).to_string();
        vec![number, format!("{kind:?}"), kind.max_bytes().to_string()]
    });
    assert_eq!(table("| kind | message | bytes |"), rows);
}
