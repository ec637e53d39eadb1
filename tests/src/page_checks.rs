//! Scripts that use the page as a person would, in headless Chromium.

use std::{
    io::{BufRead, BufReader},
    process::{Command, Stdio},
};

use crate::workspace_root;

/// Runs `e2e/<script>` of the page with these arguments, and passes its lines on.
///
/// # Panics
///
/// Where the page's packages are not installed, or with the lines that begin with `FAIL` when a check fails.
pub fn run_page_checks(script: &str, arguments: &[&str]) {
    let page = workspace_root().join("node-viewer-bridge/page");
    assert!(
        page.join("node_modules/playwright-core").is_dir(),
        "run `cargo xtask page` first: it installs what drives the browser"
    );
    let mut node = Command::new("node")
        .arg(format!("e2e/{script}"))
        .args(arguments)
        .current_dir(page)
        .stderr(Stdio::piped())
        .spawn()
        .expect("Node is installed");
    let lines = BufReader::new(node.stderr.take().expect("a pipe")).lines();
    let mut failures = Vec::new();
    for line in lines.map_while(Result::ok) {
        eprintln!("{line}");
        if line.starts_with("FAIL") {
            failures.push(line);
        }
    }
    let status = node.wait().expect("it can be waited for");
    assert!(
        status.success(),
        "{script} ended with {status}:\n{}",
        failures.join("\n")
    );
}
