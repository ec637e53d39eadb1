//! The commands and where each of them lives.

use crate::output::Format;
use crate::{detect, replay};
use clap::{Parser, Subcommand};

/// Says where tagged objects are: cameras, detector, network, fusion, page, and the tools around them.
#[derive(Parser, Debug)]
#[command(name = "sextant", version, after_help = EXIT_CODES)]
pub struct Arguments {
    /// Speak JSON: one value a line.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes:
  0    done
  1    a fault at run time
  2    wrong usage of the command line
  3    a file that was given is missing or wrong
  4    a port, camera or service is in use or out of reach
  130  interrupted before the result was there

Errors go to standard error with cause and remedy; SEXTANT_LOG filters the log of the nodes (for example `debug`).";

#[derive(Subcommand, Debug)]
enum Command {
    /// Find tags in pictures.
    Detect(detect::DetectArguments),
    /// Run a recording through the estimator.
    Replay(replay::ReplayArguments),
}

/// Runs the command.
///
/// # Errors
/// Whatever the command cannot do, with its exit code.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let format = if arguments.json {
        Format::Json
    } else {
        Format::Text
    };
    match &arguments.command {
        Command::Detect(arguments) => detect::run(arguments, format),
        Command::Replay(arguments) => replay::run(arguments, format),
    }
}
