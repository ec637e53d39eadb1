//! Where the program under test is.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The workspace's root.
#[must_use]
pub fn workspace_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The `sextant` program of the build that this test belongs to.
///
/// # Panics
/// When it was not built: `cargo test --workspace` and `cargo xtask test` build it.
#[must_use]
pub fn sextant() -> Command {
    program("sextant")
}

/// The `node-camera` program likewise: what the package for boards has.
///
/// # Panics
/// As [`sextant`].
#[must_use]
pub fn node_camera() -> Command {
    program("node-camera")
}

/// An example of the Rust client likewise.
///
/// # Panics
/// When it was not built: `cargo test --workspace` builds it.
#[must_use]
pub fn client_example(name: &str) -> Command {
    built(&format!("examples/{name}"), "--examples")
}

fn program(name: &str) -> Command {
    built(name, &format!("--bin {name}"))
}

fn built(file: &str, what: &str) -> Command {
    let test = std::env::current_exe().expect("a test has a file");
    // target/<profile>/deps/<test> -> target/<profile>/<file>
    let program = test
        .ancestors()
        .nth(2)
        .expect("a profile's folder")
        .join(file);
    assert!(
        program.is_file(),
        "{} is missing: run `cargo build --release --workspace {what}` first",
        program.display()
    );
    Command::new(program)
}
