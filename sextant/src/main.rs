//! Sextant on the command line: one program for every node and every tool.

mod animation_file;
mod arguments;
mod axes;
mod calibrate;
mod camera;
mod check;
mod config;
mod convert;
mod demo;
mod deploy;
mod detect;
mod doctor;
mod echo;
mod foxglove;
mod freed;
mod hz;
mod keys;
mod learn;
mod list;
mod listening;
mod manual;
mod mavlink;
mod message_text;
mod model_files;
mod mqtt;
mod natnet;
mod nodes;
mod nt4;
mod opentrackio;
mod osc;
mod output;
mod output_file;
mod phone;
mod play;
mod pose_feed;
mod print;
mod procedure;
mod progress;
mod psn;
mod record;
mod recorded;
mod replay;
mod robot_frame;
mod ros2;
mod router;
mod seconds;
mod simulate;
mod site;
mod top;
mod vrpn;
mod words;

use arguments::Arguments;
use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    sextant_process::panics::end_the_process();
    match arguments::run(&Arguments::parse()) {
        Err(error) if output::is_broken_pipe(&error) => ExitCode::SUCCESS,
        result => sextant_process::report(result),
    }
}
