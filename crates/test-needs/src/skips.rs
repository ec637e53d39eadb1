//! The report of what was skipped.

use std::fs::OpenOptions;
use std::io::{Write, stderr};

/// The environment variable that names the file in which skips are noted, one a line. `cargo xtask` sets it and shows
/// them at the end.
pub const SKIPS: &str = "SEXTANT_SKIPS";

/// Whether this is continuous integration, where everything must run.
#[must_use]
pub fn is_ci() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty() && value != "false")
}

/// Says that something was skipped and why, past the test harness, which keeps the output of a passed test to itself.
pub fn note_skip(what: &str, why: &str) {
    // A skip that nobody hears of is no failure.
    let _ = writeln!(stderr(), "SKIPPED: {what}: {why}");
    let file =
        std::env::var_os(SKIPS).map(|file| OpenOptions::new().append(true).create(true).open(file));
    if let Some(Ok(mut file)) = file {
        let _ = writeln!(file, "{what}: {why}");
    }
}
