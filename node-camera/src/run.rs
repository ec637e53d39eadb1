//! From the command line to the part that is wanted.

use std::path::PathBuf;

use clap::{Args, Parser};
use sextant_process::{Exit, Shutdown, WithExit, logging, memory};

use crate::config::CameraNodeConfig;
use crate::part::Part;
use crate::{capture, detect, supervise};

/// Arguments of the camera node, under whatever command it runs.
#[derive(Debug, Clone, Args)]
pub struct CameraArguments {
    /// The node's configuration (`sextant config camera` prints one).
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// Run one part only; without it both run, as two processes.
    #[arg(long, value_enum)]
    pub part: Option<Part>,
}

/// Captures the images of one camera, finds tags in them and publishes what it sees.
#[derive(Debug, Parser)]
#[command(name = "node-camera", version)]
pub struct ProgramArguments {
    /// All of its arguments.
    #[command(flatten)]
    pub camera: CameraArguments,
}

/// Runs a camera node until `shutdown` or the end of its recording. `subcommand` are the words with which this program
/// starts a camera node (`["camera"]` for `sextant`, none for `node-camera`): its parts are started with them.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] for a camera, network or shared memory that can't be had.
pub fn run(
    arguments: &CameraArguments,
    subcommand: &[&str],
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    memory::keep_heap_small();
    let config = CameraNodeConfig::read(&arguments.config).exit_with(Exit::Input)?;
    match arguments.part {
        None => {
            logging::init(&format!("camera {}", config.camera));
            // Said once and before anything runs, not by the part that needs it.
            config.protection().exit_with(Exit::Input)?;
            supervise::run(&arguments.config, subcommand, shutdown)
        }
        Some(part) => {
            logging::init(&format!("{} {}", part.name(), config.camera));
            match part {
                Part::Capture => capture::run(&arguments.config, &config, shutdown),
                Part::Detect => detect::run(&config, shutdown),
            }
        }
    }
}
