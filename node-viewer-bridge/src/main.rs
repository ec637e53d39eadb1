//! The viewer bridge as a program of its own; `sextant viewer` is the same.

use clap::Parser;
use sextant_process::{Shutdown, logging, panics, report};
use std::path::PathBuf;
use std::process::ExitCode;

/// Serves a site as a web page and as JSON on a WebSocket.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// The bridge's configuration (`sextant config viewer` prints one).
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

fn main() -> ExitCode {
    panics::end_the_process();
    let arguments = Arguments::parse();
    logging::init("viewer");
    report(
        Shutdown::install()
            .map_err(Into::into)
            .and_then(|shutdown| node_viewer_bridge::run(&arguments.config, &shutdown)),
    )
}
