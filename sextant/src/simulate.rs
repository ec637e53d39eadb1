//! `sextant simulate`: a recording of a scenario, its site's files as a person would have them, and the truth beside
//! them.

pub mod models;
mod recording;
pub mod site_files;

use crate::output::{Format, print_line};
use crate::words;
use anyhow::{Context, ensure};
use clap::Args;
use sextant_process::{Exit, Shutdown, WithExit};
use sextant_simulator::{Imperfections, Scenario};
use sextant_site_files::{Complaint, read_toml_checked, write_toml};
use std::fs;
use std::path::{Path, PathBuf};

/// True time of the first images where the scenario has none: any will do, and clocks may be behind it.
const START_NS: u64 = 1_700_000_000_000_000_000;

/// Arguments of `sextant simulate`.
#[derive(Args, Debug)]
#[command(
    after_help = "Without SCENARIO the site is that of the demo, with errors of hand-made files; its scenario.toml in
DIR is a starting point for your own.

In DIR: CAMERA/data.csv and CAMERA/data/*.png, rig.toml and OBJECT.toml with the errors of the scenario, rig.true.toml
and OBJECT.true.toml without them, OBJECT.tum with the true poses, scenario.toml.

For example: sextant simulate --seconds 10 --out site
             sextant replay site --rig site/rig.toml --object site/cuboid.toml"
)]
pub struct SimulateArguments {
    /// The site to simulate: docs/scenarios.md has the keys.
    #[arg(conflicts_with_all = ["cameras", "objects", "arm", "seed", "exact"])]
    scenario: Option<PathBuf>,
    /// The folder to make.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// How long the recording is, s; 0 writes the files only.
    #[arg(long, default_value_t = 10.0, value_parser = parse_seconds)]
    seconds: f64,
    #[command(flatten)]
    demonstration: Demonstration,
}

/// Size and contents of the demonstration's site.
#[derive(Args, Debug, Clone, Copy)]
pub struct Demonstration {
    /// Simulated cameras around the table.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=16))]
    cameras: u8,
    /// Tagged objects that move on it.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=12))]
    objects: u8,
    /// With an arm of two joints and three links in the middle, around which the others move.
    #[arg(long)]
    arm: bool,
    /// Seed of the scene: the same seed, the same images.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Rig and object files that are exactly right. Without it they are off as those of a real site: cameras by 3 mm
    /// and 0.3 degrees an axis, focal lengths and prints by 0.3 %, glued tags by 0.4 mm and 0.4 degrees; its cameras
    /// are triggered together, those of an exact site one after the other.
    #[arg(long)]
    exact: bool,
}

impl Demonstration {
    /// The scenario that these options describe.
    pub fn scenario(&self) -> Scenario {
        let make = if self.arm {
            Scenario::demo_with_arm
        } else {
            Scenario::demo
        };
        let scenario = make(self.cameras.into(), self.objects.into(), self.seed.into());
        let Some(errors) = self.imperfections() else {
            return scenario;
        };
        let mut scenario = scenario.with_imperfections(errors);
        // Triggered together: while objects move, images of different times don't tell how cameras stand to each other.
        scenario
            .cameras
            .iter_mut()
            .for_each(|camera| camera.phase = 0.0);
        scenario
    }

    /// How wrong its files are, if they are.
    pub fn imperfections(&self) -> Option<&'static Imperfections> {
        (!self.exact).then_some(&Imperfections::TYPICAL)
    }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err(format!(
            "'{text}' is not a number of seconds from 0 to 86400"
        )),
    }
}

/// Writes the folder.
///
/// # Errors
/// [`Exit::Input`] for a scenario that is missing or wrong and for a folder with something in it.
pub fn run(arguments: &SimulateArguments, format: Format) -> anyhow::Result<()> {
    let shutdown = Shutdown::install()?;
    let mut scenario = match &arguments.scenario {
        Some(file) => read(file).exit_with(Exit::Input)?,
        None => arguments.demonstration.scenario(),
    };
    if scenario.start_ns == 0 {
        scenario.start_ns = START_NS;
    }
    let folder = &arguments.out;
    make_empty(folder).exit_with(Exit::Input)?;
    write_toml(&folder.join("scenario.toml"), &scenario)?;
    site_files::write(folder, &scenario)?;
    site_files::write_truth(folder, &scenario)?;
    let until_ns = scenario.start_ns + (arguments.seconds * 1e9) as u64;
    let times = recording::write(folder, &scenario, until_ns, &shutdown)?;
    site_files::write_paths(folder, &scenario, &times)?;
    print_line(&said(&scenario, folder, times.len(), format))?;
    Ok(())
}

fn said(scenario: &Scenario, folder: &Path, instants: usize, format: Format) -> String {
    let folder = folder.display();
    let (cameras, objects) = (scenario.cameras.len(), scenario.objects.len());
    match format {
        Format::Json => serde_json::json!({
            "folder": folder.to_string(), "cameras": cameras, "objects": objects, "instants": instants,
        })
        .to_string(),
        Format::Text => format!(
            "{folder}: {}, {}, images at {}",
            words::count(cameras, "camera"),
            words::count(objects, "object"),
            words::count(instants, "instant"),
        ),
    }
}

/// A scenario's file.
///
/// # Errors
/// A file that is missing, malformed, or a site that can't be simulated; with file and key.
pub fn read(file: &Path) -> anyhow::Result<Scenario> {
    let sound = |scenario: &Scenario| {
        let flaw = scenario.validate();
        flaw.map_err(|error| Complaint::new("", error.to_string(), ""))
    };
    Ok(read_toml_checked(file, sound)?)
}

/// Makes a folder, or takes an empty one: nothing of an earlier recording may mix with a new one.
///
/// # Errors
/// A folder that has something in it or cannot be made.
pub fn make_empty(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("{}: give a new folder", folder.display()))?;
    let is_empty = fs::read_dir(folder)
        .with_context(|| folder.display().to_string())?
        .next()
        .is_none();
    ensure!(
        is_empty,
        "{}: there is something in this folder; give a new one",
        folder.display()
    );
    Ok(())
}
