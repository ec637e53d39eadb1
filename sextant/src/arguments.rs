//! The commands and where each of them lives.

use crate::output::Format;
use crate::{
    calibrate, check, config, convert, demo, detect, doctor, echo, hz, learn, list, nodes, print,
    replay, simulate, top,
};
use clap::{Parser, Subcommand};
use node_camera::CameraArguments;

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
  101  a defect of this program: a thread panicked
  130  interrupted before the result was there

Errors go to standard error with cause and remedy; SEXTANT_LOG filters the log of the nodes (for example `debug`).";

#[derive(Subcommand, Debug)]
enum Command {
    /// A whole site without hardware: simulated cameras, everything else real, a page to watch it.
    Demo(demo::DemoArguments),
    /// Render a recording with truth, and the site's files as a person would have them.
    Simulate(simulate::SimulateArguments),
    /// Find tags in pictures.
    Detect(detect::DetectArguments),
    /// Run a recording through the estimator.
    Replay(replay::ReplayArguments),
    /// Find lenses' and cameras' parameters from images.
    Calibrate(calibrate::CalibrateArguments),
    /// Learn where the tags of an object sit.
    Learn(learn::LearnArguments),
    /// Say who and what is there on a site.
    List(list::ListArguments),
    /// Show messages of a site as they come.
    Echo(echo::EchoArguments),
    /// Show how often and how late messages of a site come.
    Hz(hz::HzArguments),
    /// Watch how a site fares: cameras, objects, what is wrong.
    Top(top::TopArguments),
    /// Write boards, tags and cubes as PDF in true size, with their object files.
    Print(print::PrintArguments),
    /// Take lenses and camera poses from ROS, Kalibr or OpenCV, or write them for those.
    Convert(convert::ConvertArguments),
    /// Print documented configuration files; get and change the rig and the objects of a running site.
    Config(config::ConfigArguments),
    /// Look whether this machine and its network have what a site needs.
    Doctor(doctor::DoctorArguments),
    /// Check files and recordings.
    Check(check::CheckArguments),
    /// Run a camera node.
    Camera(CameraArguments),
    /// Run a fusion node.
    Fusion(nodes::NodeArguments),
    /// Run a viewer bridge: the web page.
    Viewer(nodes::NodeArguments),
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
        Command::Demo(arguments) => demo::run(arguments, format),
        Command::Simulate(arguments) => simulate::run(arguments, format),
        Command::Detect(arguments) => detect::run(arguments, format),
        Command::Replay(arguments) => replay::run(arguments, format),
        Command::Calibrate(arguments) => calibrate::run(arguments, format),
        Command::Learn(arguments) => learn::run(arguments, format),
        Command::List(arguments) => list::run(arguments, format),
        Command::Echo(arguments) => echo::run(arguments, format),
        Command::Hz(arguments) => hz::run(arguments, format),
        Command::Top(arguments) => top::run(arguments, format),
        Command::Print(arguments) => print::run(arguments, format),
        Command::Convert(arguments) => convert::run(arguments, format),
        Command::Config(arguments) => config::run(arguments, format),
        Command::Doctor(arguments) => doctor::run(arguments, format),
        Command::Check(arguments) => check::run(arguments, format),
        Command::Camera(arguments) => nodes::camera(arguments),
        Command::Fusion(arguments) => nodes::fusion(arguments),
        Command::Viewer(arguments) => nodes::viewer(arguments),
    }
}
