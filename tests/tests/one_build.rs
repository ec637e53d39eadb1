//! What is compiled for one command is not compiled again for the next: `cargo test --workspace`, `cargo demo` and
//! `cargo build` turn on the same features of every crate that they share. Were one different, zenoh and all that
//! depends on it would be built twice.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use system_tests::workspace_root;

/// Every crate of the whole workspace with its version and features, over these kinds of dependencies.
fn crates(kinds: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args([
            "tree",
            "--workspace",
            "--offline",
            "--locked",
            "--no-dedupe",
        ])
        .args(["--prefix", "none", "--format", "{p} {f}", "--edges", kinds])
        .current_dir(workspace_root())
        .output()
        .expect("cargo tree runs");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    text.lines()
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect()
}

#[test]
fn tests_turn_on_no_feature_that_the_programs_do_without() {
    let (built, tested) = (crates("normal,build"), crates("normal,build,dev"));
    assert!(built.iter().any(|line| line.starts_with("zenoh v")));
    let compiled_again: Vec<_> = built.difference(&tested).collect();
    assert!(
        compiled_again.is_empty(),
        "other features in tests: {compiled_again:#?}\nadd what brings them to the dependencies of sextant-benches"
    );
}

/// Cargo turns on the features that the selected packages want; `--package sextant` alone would select fewer.
#[test]
fn the_demo_is_built_as_a_part_of_the_whole_workspace() {
    let config = fs::read_to_string(workspace_root().join(".cargo/config.toml"));
    let config = config.expect("cargo's configuration");
    let demo = config.lines().find(|line| line.starts_with("demo = "));
    let demo = demo.expect("the alias `demo`");
    assert!(demo.contains("--bin sextant"), "{demo}");
    assert!(
        !demo.contains("--package") && !demo.contains("-p "),
        "{demo}"
    );
}

/// Libraries and programs without tests of their own are marked with `test = false`, so that no empty test program is
/// linked.
#[test]
fn what_is_built_without_tests_has_none() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--locked", "--no-deps"])
        .args(["--format-version", "1"])
        .current_dir(workspace_root())
        .output()
        .expect("cargo metadata runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let targets = packages
        .iter()
        .flat_map(|package| package["targets"].as_array().expect("targets"));
    let mut untested = 0;
    for target in targets.filter(|target| target["test"] == false) {
        let source = PathBuf::from(target["src_path"].as_str().expect("a path"));
        let files = match target["kind"][0].as_str() {
            Some("lib") => sources(source.parent().expect("a folder")),
            Some("bin") => vec![source],
            _ => continue,
        };
        untested += 1;
        for file in files {
            let text = fs::read_to_string(&file).expect("a source");
            assert!(!text.contains("#[test]"), "{}", file.display());
        }
    }
    assert!(untested > 0, "nothing is built without tests");
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    entries
        .flat_map(|entry| match entry.path() {
            path if path.is_dir() => sources(&path),
            path => vec![path],
        })
        .filter(|path| path.extension().is_some_and(|end| end == "rs"))
        .collect()
}
