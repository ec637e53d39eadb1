//! The defaults in docs/models.md are those of the code.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_site_model::default_sigmas;

#[test]
fn documented_default_sigmas_are_those_of_the_code() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/models.md");
    let text = std::fs::read_to_string(page).expect("a page");
    let table = text.split_once("|---|---|---|\n").expect("a table").1;
    let rows: Vec<&str> = table
        .lines()
        .take_while(|line| line.starts_with('|'))
        .collect();
    let expected = default_sigmas();
    let expected = expected
        .iter()
        .map(|row| format!("| {} | {} | {} |", row.number, row.sigma, row.as_if));
    assert_eq!(rows, expected.collect::<Vec<_>>(), "{page}");
}
