//! The camera node as a program of its own; `sextant camera` is the same.

use std::process::ExitCode;

use clap::Parser;
use node_camera::{ProgramArguments, run};
use sextant_process::{Shutdown, panics, report};

fn main() -> ExitCode {
    panics::end_the_process();
    let arguments = ProgramArguments::parse();
    report(
        Shutdown::install()
            .map_err(Into::into)
            .and_then(|shutdown| run(&arguments.camera, &[], &shutdown)),
    )
}
