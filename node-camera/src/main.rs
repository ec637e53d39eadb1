//! The camera node as a program of its own; `sextant camera` is the same.

use std::process::ExitCode;

use clap::Parser;
use node_camera::{CameraArguments, run};
use sextant_process::{Shutdown, panics, report};

/// Captures the images of one camera, finds tags in them and publishes what it sees.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    camera: CameraArguments,
}

fn main() -> ExitCode {
    panics::end_the_process();
    let arguments = Arguments::parse();
    report(
        Shutdown::install()
            .map_err(Into::into)
            .and_then(|shutdown| run(&arguments.camera, &[], &shutdown)),
    )
}
