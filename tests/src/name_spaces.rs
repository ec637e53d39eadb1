//! Name spaces of a test's own, for mounts, network and processes (`sextant_test_needs::NAME_SPACES`).

use std::path::Path;
use std::process::Command;

/// Runs one test of this program again, by its name without its module, in name spaces that end with it, with the
/// environment variable `variable` set to `folder`.
///
/// # Panics
/// When the test fails there.
pub fn run_in_name_spaces(test: &str, variable: &str, folder: &Path) {
    // The shell is the init of the name space: it waits for what loses its parent.
    let status = Command::new("unshare")
        .args(["--mount", "--net", "--pid", "--fork"])
        .args(["--kill-child", "--mount-proc"])
        .args(["sh", "-c", "\"$@\" & wait $!", "sh"])
        .arg(std::env::current_exe().expect("a test has a file"))
        .args([test, "--nocapture"])
        .env(variable, folder)
        .status()
        .expect("unshare runs: it comes with util-linux");
    assert!(status.success(), "{status}");
}
