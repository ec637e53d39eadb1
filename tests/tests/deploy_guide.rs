//! The commands of `sextant` on the page that tells how to put it on machines, typed one after the other. What changes
//! the machine itself, packages and units, is tried on the emulated board.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use std::fs;
use std::path::Path;
use std::process::Command;
use system_tests::{commands, sextant};

#[test]
fn the_commands_of_the_deployment_guide_work() {
    let machine = tempfile::tempdir().expect("a temporary folder");
    let state = machine.path().join("sextant");
    fs::create_dir_all(&state).expect("a folder");
    fs::create_dir_all(machine.path().join("sextant-viewer")).expect("a folder");
    let mut typed = 0;
    for line in commands("deploy/README.md", "sh") {
        // `doctor` wants a camera and a router.
        if line.starts_with("sextant ") && !line.starts_with("sextant doctor") {
            run(
                &line.replace("/var/lib", &machine.path().display().to_string()),
                &state,
            );
            typed += 1;
        }
    }
    assert!(typed >= 6, "{typed} commands");
}

fn run(line: &str, folder: &Path) {
    let sextant = sextant();
    let programs = Path::new(sextant.get_program()).parent().expect("a folder");
    let path = std::env::var("PATH").expect("a path");
    let output = Command::new("sh")
        .args(["-ec", line])
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", programs.display()))
        .output()
        .expect("a shell");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}\n{said}");
}
