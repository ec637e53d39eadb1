//! Tests of the whole system. All files of this folder but `board.rs` are modules of one test program: each program of
//! its own would link the whole workspace again. `cargo xtask system` runs them one module after the other, since many
//! measure latencies.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

mod architecture;
mod camera_settings;
mod carried;
mod changes;
mod control_plane;
mod demo;
mod deploy_guide;
mod doctor;
mod documentation;
mod doors;
mod faults;
mod fleet;
mod from_nothing;
mod full_disk;
mod hostile_input;
mod hosts;
mod import_cycles;
mod joined_sites;
mod live_procedures;
mod namesakes;
mod network;
mod one_build;
mod page;
mod page_doors;
mod page_edits;
mod phone;
mod play;
mod recordings;
mod refinement;
mod ros2;
mod rust_client;
mod units;
mod wizards;

use std::path::Path;

/// A file without its line above would never be tested.
#[test]
fn every_file_is_a_module_of_this_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let root = include_str!("system.rs");
    for file in std::fs::read_dir(folder).expect("a folder").flatten() {
        let name = file.file_name().into_string().expect("UTF-8");
        let Some(module) = name.strip_suffix(".rs") else {
            continue;
        };
        let is_module = root.lines().any(|line| line == format!("mod {module};"));
        assert!(is_module || ["board", "system"].contains(&module), "{name}");
    }
}
