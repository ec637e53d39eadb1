//! Chores about what the program is made of. Their tools are cargo's extensions of one version each, so that a run
//! tells of a change of ours and not of theirs.

use crate::tools::{CargoTool, root, run};
use sextant_test_needs::note_skip;
use std::fs;

const DENY: CargoTool = CargoTool {
    name: "cargo-deny",
    version: "0.20.2",
    options: &[],
};
const CYCLONEDX: CargoTool = CargoTool {
    name: "cargo-cyclonedx",
    version: "0.5.9",
    options: &[],
};
/// The name without its ending, as cargo-cyclonedx wants it.
const SBOM: &str = "sextant.cdx";

pub fn deny() -> Result<(), String> {
    let deny = DENY.program()?;
    run(
        &deny,
        &["--all-features", "check", "licenses", "bans", "sources"],
    )
}

/// Without a network there is no database, and nothing is known of the dependencies that was not known before: that is
/// no fault.
pub fn advisories() -> Result<(), String> {
    let deny = DENY.program()?;
    if let Err(cause) = run(&deny, &["--log-level", "error", "fetch", "db"]) {
        let why = format!("the advisory database cannot be fetched ({cause})");
        note_skip("known faults of dependencies", &why);
        return Ok(());
    }
    run(&deny, &["--all-features", "check", "advisories"])
}

/// cargo-cyclonedx writes a file beside the manifest of each package of the workspace; the program's is kept, the
/// others go.
pub fn sbom() -> Result<(), String> {
    let cyclonedx = CYCLONEDX.program()?;
    let format = ["--format", "json", "--spec-version", "1.5"];
    let name = ["--override-filename", SBOM];
    let written = run(&cyclonedx, &[&["cyclonedx"][..], &format, &name].concat());
    let kept = written.and_then(|()| keep_sbom().map_err(|cause| format!("the SBOM: {cause}")));
    remove_others();
    kept
}

fn keep_sbom() -> std::io::Result<()> {
    let (file, folder) = (format!("{SBOM}.json"), root().join("target/sbom"));
    fs::create_dir_all(&folder)?;
    fs::rename(root().join("sextant").join(&file), folder.join(&file))
}

fn remove_others() {
    let folders =
        [".", "crates", "clients", "benches"].map(|folder| fs::read_dir(root().join(folder)));
    for package in folders.into_iter().flatten().flatten().flatten() {
        // Most folders have none.
        let _ = fs::remove_file(package.path().join(format!("{SBOM}.json")));
    }
}
