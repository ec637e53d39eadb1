//! The files of a simulated site: rig and objects as a person has them and as they truly are, and where the objects go.

use super::models::{bodies, rig};
use anyhow::Context;
use sextant_recordings::tum_line;
use sextant_simulator::Scenario;
use sextant_site_files::{write_object, write_rig};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Writes rig.toml and each object's file, with the errors that the scenario gives them.
///
/// # Errors
/// A scenario without a valid rig or object, or files that cannot be written.
pub fn write(folder: &Path, scenario: &Scenario) -> anyhow::Result<()> {
    write_as(folder, &scenario.as_written()?, "")
}

/// The same without errors: rig.true.toml, OBJECT.true.toml.
///
/// # Errors
/// As above.
pub fn write_truth(folder: &Path, scenario: &Scenario) -> anyhow::Result<()> {
    write_as(folder, &scenario.as_built(), ".true")
}

fn write_as(folder: &Path, scenario: &Scenario, infix: &str) -> anyhow::Result<()> {
    write_rig(
        &folder.join(format!("rig{infix}.toml")),
        &rig(&scenario.cameras)?,
    )?;
    for body in bodies(scenario) {
        let file = folder.join(format!("{}{infix}.toml", body.id()));
        write_object(&file, &body.model()?)?;
    }
    Ok(())
}

/// Writes the true poses of each object or link at these true times: ID.tum, `seconds x y z qx qy qz qw` a line.
///
/// # Errors
/// Files that can't be written.
pub fn write_paths(
    folder: &Path,
    scenario: &Scenario,
    true_times: &BTreeSet<u64>,
) -> anyhow::Result<()> {
    for object in &scenario.objects {
        let lines = true_times.iter().map(|&true_ns| {
            let pose = object.world_from_object(true_ns);
            format!("{}\n", tum_line(true_ns, &pose))
        });
        let file = folder.join(format!("{}.tum", object.id));
        fs::write(&file, lines.collect::<String>()).with_context(|| file.display().to_string())?;
    }
    Ok(())
}
