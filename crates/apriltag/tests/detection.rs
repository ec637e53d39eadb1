//! What the detector finds in drawn pictures. Most files of this folder are modules of one test program, which is
//! compiled and linked once.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod alternatives;
mod boards;
mod camera_processing;
mod chessboard;
mod drawing;
mod drawn_tags;
mod families_apart;
mod hard_tags;
mod photometric_fit;
mod sharp_pictures;
mod tracking;

use std::path::Path;

/// Programs of their own: what allocates is counted, and what runs on other processors is chosen by program.
const APART: [&str; 4] = [
    "any_bytes",
    "changed_pictures",
    "no_allocation",
    "processors",
];

/// A file without its line above would never be tested.
#[test]
fn every_file_is_a_module_or_a_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let root = include_str!("detection.rs");
    for file in std::fs::read_dir(folder).unwrap().flatten() {
        let name = file.file_name().into_string().unwrap();
        let Some(module) = name.strip_suffix(".rs") else {
            continue;
        };
        let is_module = root.lines().any(|line| line == format!("mod {module};"));
        assert!(
            is_module || module == "detection" || APART.contains(&module),
            "{name}"
        );
    }
}
