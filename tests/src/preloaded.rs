//! Libraries in C that a test preloads into a process.

use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Compiles a source of this folder to a library in a folder of its own.
///
/// # Panics
/// Without a C compiler (`cc`).
pub(crate) fn compiled(source: &str, library: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-O2", "-o"]);
    compiler
        .arg(folder.path().join(library))
        .arg(sources.join(source));
    assert!(compiler.status().expect("cc runs").success());
    folder
}
