//! What is compiled for one command is not compiled again for the next: `cargo test --workspace`, `cargo demo` and
//! `cargo build` turn on the same features of every crate that they share. Were one different, zenoh and all that
//! depends on it would be built twice.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use std::collections::BTreeSet;
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
    let config = std::fs::read_to_string(workspace_root().join(".cargo/config.toml"));
    let config = config.expect("cargo's configuration");
    let demo = config.lines().find(|line| line.starts_with("demo = "));
    let demo = demo.expect("the alias `demo`");
    assert!(demo.contains("--bin sextant"), "{demo}");
    assert!(
        !demo.contains("--package") && !demo.contains("-p "),
        "{demo}"
    );
}
