//! Sextant on the command line: one program for every node and every tool.

mod arguments;
mod detect;
mod ordered;
mod output;
mod replay;

use arguments::Arguments;
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = arguments::run(&Arguments::parse());
    match result {
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        result => sextant_process::report(result),
    }
}
