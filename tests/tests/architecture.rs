//! The dependency rule: arrows between the workspace's packages go down only, never sideways.
//!
//! The floors are those of ARCHITECTURE.md. A package that stands on no floor fails the test, so that a new one is
//! placed on purpose.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use syn::{Item, UseTree, Visibility};
use system_tests::workspace_root;

/// From the ground up; a package may depend on packages of lower floors only.
const FLOORS: &[&[&str]] = &[
    &[
        "sextant-contract",
        "sextant-geometry",
        "sextant-tag-families",
        "sextant-drp-circuits",
    ],
    &["sextant-apriltag", "sextant-site-model"],
    &[
        "sextant-adjustment",
        "sextant-mistakes",
        "sextant-site-report",
        "sextant-simulator",
    ],
    &["sextant-estimator", "sextant-proto", "sextant-calibrator"],
    &["sextant-site-mirror"],
    &["sextant-queue", "sextant-ros2"],
    &[
        "sextant-iceoryx-images",
        "sextant-zenoh-bus",
        "sextant-site-files",
        "sextant-recordings",
        "sextant-process",
        "sextant-election",
        "sextant-rza2m",
        "sextant-pose-files",
        "sextant-pose-streams",
        "sextant-test-needs",
    ],
    &[
        "node-camera",
        "node-fusion",
        "node-viewer-bridge",
        "sextant-client",
        "sextant-drawing",
        "sextant-gateways",
        "sextant-replay",
        "sextant-sheets",
        "sextant-site-keys",
        "sextant-web",
    ],
    &["sextant-evaluation", "sextant-explain", "sextant-fleet"],
    &["sextant"],
    &[
        "site-simulation",
        "system-tests",
        "sextant-benches",
        "sextant-examine",
        "sextant-tidy",
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
    ("sextant-site-mirror", TRANSPORT),
    ("sextant-election", TRANSPORT),
];
const TRANSPORT: &[&str] = &["zenoh", "iceoryx2", "tokio", "axum", "tracing", "libc"];

/// Packages that run fusion. All others use the data of `sextant-site-model` and `sextant-site-report`.
const RUN_FUSION: &[&str] = &[
    "node-fusion",
    "sextant-replay",
    "sextant",
    "site-simulation",
    "system-tests",
    "sextant-examine",
];

fn floor_of(package: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&package))
}

/// Every workspace package with the names of what it depends on, for use and for its own build (not for its tests).
fn dependencies() -> BTreeMap<String, Vec<String>> {
    dependencies_where(|kind| kind != "dev")
}

/// The same for dependencies of some kinds: `null` (for use), `"build"` and `"dev"`.
fn dependencies_where(is_wanted: impl Fn(&Value) -> bool) -> BTreeMap<String, Vec<String>> {
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
                .filter(|d| is_wanted(&d["kind"]))
                .map(|d| text(&d["name"]))
                .collect();
            (text(&package["name"]), wanted)
        })
        .collect()
}

/// The release profile compiles most packages fast; those that compute are on its list of packages that are fast.
#[test]
fn packages_that_compute_are_compiled_to_be_fast() {
    let manifest = fs::read_to_string(workspace_root().join("Cargo.toml")).expect("a manifest");
    let dependencies = dependencies();
    for package in FLOORS[..4].concat() {
        if dependencies[package].iter().any(|name| name == "nalgebra") {
            let entry = format!("\n{package} = {{ opt-level = 3");
            assert!(
                manifest.contains(&entry),
                "{package} is not in [profile.release.package]"
            );
        }
    }
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

/// Who reads a pose or a fault compiles no fusion, not even for tests.
#[test]
fn only_who_runs_fusion_depends_on_the_estimator() {
    let all = dependencies_where(|_| true);
    let users: BTreeSet<&str> = all
        .iter()
        .filter(|(_, wanted)| wanted.iter().any(|name| name == "sextant-estimator"))
        .map(|(package, _)| package.as_str())
        .collect();
    assert!(users.contains("node-fusion"), "{users:?}");
    let others: Vec<_> = users
        .iter()
        .filter(|user| !RUN_FUSION.contains(user))
        .collect();
    assert!(others.is_empty(), "{others:?} must not know the estimator");
}

#[test]
fn the_estimator_re_exports_no_other_crate() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/estimator/src");
    let files = source_files(&src);
    assert!(files.len() > 50, "{files:?}");
    for path in files {
        let text = fs::read_to_string(&path).expect("a source file");
        let foreign = foreign_exports(&text);
        assert!(
            foreign.is_empty(),
            "{} re-exports {foreign:?}: import them from there",
            path.display()
        );
    }
}

#[test]
fn a_re_export_of_another_crate_is_found() {
    let text = "mod fault; pub use fault::Fault; pub use self::fault::Other; pub use crate::Item;
        use nalgebra::Vector3; pub(crate) use std::fmt;
        pub use sextant_site_model::{Rig, TagId}; pub use {fault::More, nalgebra::Point2};
        pub extern crate serde;";
    assert_eq!(
        foreign_exports(text),
        ["sextant_site_model", "nalgebra", "serde"]
    );
}

/// Every `.rs` file of a folder and of those in it.
fn source_files(src: &Path) -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![src.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                files.push(path);
            }
        }
    }
    files
}

/// The crates whose names a file makes public: first words of `pub use` that are no module of the file.
fn foreign_exports(text: &str) -> Vec<String> {
    let file = syn::parse_file(text).expect("a Rust file");
    let mut own = BTreeSet::from(["crate", "self", "super"].map(str::to_owned));
    own.extend(file.items.iter().filter_map(|item| match item {
        Item::Mod(module) => Some(module.ident.to_string()),
        _ => None,
    }));
    let mut exported = Vec::new();
    for item in &file.items {
        match item {
            Item::Use(item) if matches!(item.vis, Visibility::Public(_)) => {
                first_words(&item.tree, &mut exported);
            }
            Item::ExternCrate(item) if matches!(item.vis, Visibility::Public(_)) => {
                exported.push(item.ident.to_string());
            }
            _ => {}
        }
    }
    exported.retain(|name| !own.contains(name));
    exported
}

fn first_words(tree: &UseTree, words: &mut Vec<String>) {
    match tree {
        UseTree::Path(path) => words.push(path.ident.to_string()),
        UseTree::Name(name) => words.push(name.ident.to_string()),
        UseTree::Rename(renamed) => words.push(renamed.ident.to_string()),
        UseTree::Group(group) => group.items.iter().for_each(|one| first_words(one, words)),
        UseTree::Glob(_) => {}
    }
}
