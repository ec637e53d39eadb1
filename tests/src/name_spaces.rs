//! Name spaces of a test's own, for mounts, network and processes: needs root.

use std::path::Path;
use std::process::Command;

fn name_spaces() -> Command {
    let mut unshare = Command::new("unshare");
    unshare.args(["--mount", "--net"]);
    unshare
}

/// Whether a line of shell succeeds in `folder`, in name spaces of its own.
#[must_use]
pub fn succeeds_in_name_spaces(line: &str, folder: &Path) -> bool {
    let mut sh = name_spaces();
    sh.args(["sh", "-c", line]).current_dir(folder);
    sh.output().is_ok_and(|output| output.status.success())
}

/// Runs one test of this program again, in name spaces that end with it, with the environment variable `variable` set to `folder`.
///
/// # Panics
/// When the test fails there.
pub fn run_in_name_spaces(test: &str, variable: &str, folder: &Path) {
    // The shell is the init of the name space: it waits for what loses its parent.
    let status = name_spaces()
        .args(["--pid", "--fork", "--kill-child", "--mount-proc"])
        .args(["sh", "-c", "\"$@\" & wait $!", "sh"])
        .arg(std::env::current_exe().expect("a test has a file"))
        .args([test, "--exact", "--nocapture"])
        .env(variable, folder)
        .status()
        .expect("unshare runs: it comes with util-linux");
    assert!(status.success(), "{status}");
}
