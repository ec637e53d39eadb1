//! The dependency rule: arrows between the workspace's packages go down only, never sideways.
//!
//! The floors are those of ARCHITECTURE.md. A package that stands on no floor fails the test, so that a new one is placed on purpose.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::process::Command;

/// From the ground up; a package may depend on packages of lower floors only.
const FLOORS: &[&[&str]] = &[
    &[
        "sextant-contract",
        "sextant-geometry",
        "sextant-tag-families",
        "sextant-drp-circuits",
    ],
    &["sextant-apriltag", "sextant-site-model"],
    &["sextant-site-report", "sextant-simulator"],
    &["sextant-estimator", "sextant-proto", "sextant-calibrator"],
    &[
        "sextant-iceoryx-images",
        "sextant-zenoh-bus",
        "sextant-site-files",
        "sextant-recordings",
        "sextant-process",
        "sextant-election",
        "sextant-rza2m",
        "sextant-pose-formats",
        "sextant-ros2",
    ],
    &[
        "node-camera",
        "node-fusion",
        "node-viewer-bridge",
        "sextant-client",
    ],
    &["sextant"],
    &[
        "system-tests",
        "sextant-benches",
        "sextant-examine",
        "xtask",
    ],
];

/// Packages that a floor's code must never see, whatever the floor: (package, forbidden external crates).
const IGNORANT_OF: &[(&str, &[&str])] = &[
    ("sextant-contract", TRANSPORT),
    ("sextant-geometry", TRANSPORT),
    ("sextant-tag-families", TRANSPORT),
    ("sextant-drp-circuits", TRANSPORT),
    ("sextant-apriltag", TRANSPORT),
    ("sextant-site-model", TRANSPORT),
    ("sextant-site-report", TRANSPORT),
    ("sextant-estimator", TRANSPORT),
    ("sextant-simulator", TRANSPORT),
    ("sextant-proto", TRANSPORT),
    ("sextant-calibrator", TRANSPORT),
    ("sextant-election", TRANSPORT),
];
const TRANSPORT: &[&str] = &["zenoh", "iceoryx2", "tokio", "axum", "tracing", "libc"];

fn floor_of(package: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&package))
}

/// Every workspace package with the names of what it depends on, for use and for its own build (not for its tests).
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--format-version",
            "1",
            "--no-deps",
            "--offline",
        ])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo metadata runs");
    let metadata: Value =
        serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    metadata["packages"]
        .as_array()
        .expect("packages")
        .iter()
        .map(|package| {
            let wanted = package["dependencies"].as_array().expect("dependencies");
            let wanted = wanted
                .iter()
                .filter(|d| d["kind"] != "dev")
                .map(|d| text(&d["name"]))
                .collect();
            (text(&package["name"]), wanted)
        })
        .collect()
}

#[test]
fn every_package_stands_on_a_floor() {
    for package in dependencies().keys() {
        assert!(
            floor_of(package).is_some(),
            "{package} has no floor: place it in FLOORS and in ARCHITECTURE.md"
        );
    }
}

#[test]
fn arrows_go_down_only() {
    let mut broken = Vec::new();
    for (package, wanted) in dependencies() {
        for below in wanted.iter().filter(|name| floor_of(name).is_some()) {
            if floor_of(below) >= floor_of(&package) {
                broken.push(format!("{package} -> {below}"));
            }
        }
    }
    assert!(
        broken.is_empty(),
        "arrows that go sideways or up: {broken:?}"
    );
}

#[test]
fn the_core_knows_no_transport() {
    let dependencies = dependencies();
    for (package, forbidden) in IGNORANT_OF {
        let wanted = &dependencies[*package];
        let seen: Vec<_> = forbidden
            .iter()
            .filter(|name| wanted.iter().any(|w| w == *name))
            .collect();
        assert!(seen.is_empty(), "{package} must not know {seen:?}");
    }
}

/// Who subscribes to poses needs no shared memory, which exists on Linux only.
#[test]
fn the_client_brings_no_shared_memory() {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--package", "sextant-client"])
        .args(["--edges", "normal,build", "--target", "all"])
        .args(["--prefix", "none", "--format", "{p}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo tree runs");
    assert!(output.status.success(), "{output:?}");
    let tree = String::from_utf8_lossy(&output.stdout);
    let packages: Vec<&str> = tree
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert!(packages.contains(&"zenoh"), "{tree}");
    let shared_memory = |name: &&&str| name.contains("iceoryx");
    assert_eq!(packages.iter().find(shared_memory), None);
}

#[test]
fn the_simulator_never_uses_what_it_tests() {
    let wanted = &dependencies()["sextant-simulator"];
    assert!(
        !wanted
            .iter()
            .any(|name| name == "sextant-apriltag" || name == "sextant-estimator"),
        "{wanted:?}"
    );
}
