//! A package is installed, upgraded, downgraded, removed and purged in a clean system of its processor, where its
//! program starts.

use super::clean_system::CleanSystem;
use super::{Staged, VERSION, deb};
use crate::tools::copy;
use std::fs;
use std::path::Path;

/// The version that it is upgraded to.
const NEWER: &str = "9999.0.0";
/// What packages depend on beside the C library, and what prepares folders as systemd does.
const PACKAGES: &str = "systemd-standalone-sysusers,systemd-standalone-tmpfiles";
const SCRIPT: &str = "lifecycle.sh";

/// Fails where a step does, leaves something behind or takes too much away.
pub fn check(staged: &Staged, deb: &Path) -> Result<(), String> {
    let architecture = staged.target.architecture.unwrap_or_default();
    let system = CleanSystem::new(architecture, PACKAGES)?;
    let newer = deb::write(staged, NEWER)?;
    let folder = super::fresh_folder("trial")?;
    let script = folder.join(SCRIPT);
    fs::write(&script, include_str!("lifecycle.sh"))
        .map_err(|cause| format!("{}: {cause}", script.display()))?;
    for deb in [deb, &newer] {
        copy(deb, &folder, 0o644)?;
    }
    fs::remove_file(&newer).map_err(|cause| format!("{}: {cause}", newer.display()))?;
    let [deb, newer] = [deb, &newer].map(|deb| {
        let name = deb.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    });
    let package = [staged.package.name, staged.package.program];
    let versions = [deb.as_str(), VERSION, &newer, NEWER];
    system.run(&folder, SCRIPT, &[&package[..], &versions].concat())
}
