//! Tests of the command line. All files of this folder are modules of one test program: each program of its own would
//! link the whole workspace again.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod arm;
mod arm_recording;
mod calibrate_lens;
mod calibrate_rig;
mod calibrate_robot;
mod carried;
mod detect;
mod foxglove;
mod keys;
mod learn;
mod natnet;
mod outputs;
mod play;
mod posing_site;
mod recording;
mod replay;
mod ros2_bag;
mod shutter;
mod simulate;
mod tools;
mod vrpn;
mod wrong_input;

use std::path::Path;

/// A file without its line above would never be tested.
#[test]
fn every_file_is_a_module_of_this_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let root = include_str!("commands.rs");
    for file in std::fs::read_dir(folder).unwrap().flatten() {
        let name = file.file_name().into_string().unwrap();
        let Some(module) = name.strip_suffix(".rs") else {
            continue;
        };
        let is_module = root.lines().any(|line| line == format!("mod {module};"));
        assert!(is_module || module == "commands", "{name}");
    }
}
