//! The fusion node as a program of its own; `sextant fusion` is the same.

use clap::Parser;
use sextant_process::{Shutdown, logging, panics, report};
use std::path::PathBuf;
use std::process::ExitCode;

/// Fuses the observations of a site's cameras into one pose per object.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// The node's configuration (`sextant config fusion` prints one).
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

fn main() -> ExitCode {
    panics::end_the_process();
    let arguments = Arguments::parse();
    logging::init("fusion");
    report(
        Shutdown::install()
            .map_err(Into::into)
            .and_then(|shutdown| node_fusion::run(&arguments.config, &shutdown)),
    )
}
