//! The commands and where each of them lives.

use crate::output::Format;
use crate::{
    calibrate, camera, check, config, convert, demo, deploy, detect, doctor, echo, foxglove, freed,
    hz, keys, learn, list, manual, mavlink, mqtt, natnet, nodes, nt4, opentrackio, osc, phone,
    play, print, progress, psn, record, replay, ros2, router, simulate, top, vrpn,
};
use clap::{CommandFactory, Parser, Subcommand};

/// Publishes the poses of tagged objects seen by several cameras: nodes, calibration and tools.
#[derive(Parser, Debug)]
#[command(name = "sextant", version, after_help = EXIT_CODES)]
pub struct Arguments {
    /// Print JSON, one value per line.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str = "Exit codes:
  0    done
  1    a failure at run time
  2    wrong usage of the command line
  3    a file is missing or wrong
  4    a port, camera or service is in use or unreachable; a calibration is partial
  101  a bug: a thread panicked
  130  interrupted before the result was complete

Errors go to standard error with cause and remedy; SEXTANT_LOG filters the log of the nodes (for example `debug`).";

#[derive(Subcommand, Debug)]
enum Command {
    /// Run a complete site without hardware: simulated cameras, real nodes, and the page.
    Demo(demo::DemoArguments),
    /// Render a recording of a scenario, with its site files and the truth.
    Simulate(simulate::SimulateArguments),
    /// Detect tags in images.
    Detect(detect::DetectArguments),
    /// Record a site into an MCAP file.
    Record(record::RecordArguments),
    /// Run a recording through the estimator.
    Replay(replay::ReplayArguments),
    /// Play a recording on the page and to all tools, as a site of its own.
    Play(play::PlayArguments),
    /// Calibrate lenses and camera poses from images.
    Calibrate(calibrate::CalibrateArguments),
    /// Find the tag poses of an object from images.
    Learn(learn::LearnArguments),
    /// List nodes, cameras and objects.
    List(list::ListArguments),
    /// Print the messages of a site as they arrive.
    Echo(echo::EchoArguments),
    /// Send poses as Open Sound Control messages: creative tools, VRChat, SteamVR.
    Osc(osc::OscArguments),
    /// Show a link and a QR code that make a phone or laptop a camera.
    Phone(phone::PhoneArguments),
    /// Send the pose of a vehicle to its autopilot as MAVLink odometry.
    Mavlink(mavlink::MavlinkArguments),
    /// Serve poses as VRPN trackers: ROS, Unreal, MATLAB, virtual-reality tools.
    Vrpn(vrpn::VrpnArguments),
    /// Serve poses as NatNet rigid bodies, as OptiTrack's Motive does.
    #[command(name = "natnet")]
    NatNet(natnet::NatNetArguments),
    /// Publish poses and events by MQTT: Home Assistant, Node-RED, dashboards.
    Mqtt(mqtt::MqttArguments),
    /// Publish poses by NetworkTables 4: robots of the FIRST Robotics Competition.
    Nt4(nt4::Nt4Arguments),
    /// Send poses as PosiStageNet trackers: lighting consoles, media servers.
    Psn(psn::PsnArguments),
    /// Send the pose of a camera as Free-D: Unreal, virtual studios.
    #[command(name = "freed")]
    FreeD(freed::FreeDArguments),
    /// Send the pose of a camera as OpenTrackIO: Unreal, virtual studios.
    #[command(name = "opentrackio")]
    OpenTrackIo(opentrackio::OpenTrackIoArguments),
    /// Show message rates and latencies.
    Hz(hz::HzArguments),
    /// Watch the cameras, objects and faults of a site.
    Top(top::TopArguments),
    /// Serve the site to Foxglove and Lichtblick, over a WebSocket.
    Foxglove(foxglove::FoxgloveArguments),
    /// Publish the site's poses, detections, lenses and pictures as ROS 2 topics, without ROS.
    Ros2(ros2::Ros2Arguments),
    /// Print boards, tags and cubes as PDF in true size, with their object files.
    Print(print::PrintArguments),
    /// Convert lenses and camera poses from and to ROS, Kalibr and OpenCV, recordings from and to MCAP, and to bags of
    /// ROS 2 and animations.
    Convert(convert::ConvertArguments),
    /// Print documented configuration files; get and change the rig and the objects of a running site.
    Config(config::ConfigArguments),
    /// Check this machine and its network.
    Doctor(doctor::DoctorArguments),
    /// Make and revoke the keys of a site's members.
    Keys(keys::KeysArguments),
    /// Bring camera nodes to boards, over ssh.
    Deploy(deploy::DeployArguments),
    /// Check files and recordings.
    Check(check::CheckArguments),
    /// Run a camera node, or list this machine's cameras.
    Camera(camera::CameraCommand),
    /// Run a fusion node.
    Fusion(nodes::NodeArguments),
    /// Run a router, for sites with more than one fusion node.
    Router(router::RouterArguments),
    /// Run a viewer bridge: the web page.
    Viewer(nodes::NodeArguments),
    /// Print the completions of a shell.
    Completions(manual::CompletionsArguments),
    /// Write manual pages and shell completions, for packages.
    #[command(hide = true)]
    Manual(manual::ManualArguments),
}

/// Runs the command.
///
/// # Errors
/// Whatever the command cannot do, with its exit code.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let format = if arguments.json {
        progress::forbid();
        Format::Json
    } else {
        Format::Text
    };
    match &arguments.command {
        Command::Demo(arguments) => demo::run(arguments, format),
        Command::Simulate(arguments) => simulate::run(arguments, format),
        Command::Detect(arguments) => detect::run(arguments, format),
        Command::Record(arguments) => record::run(arguments, format),
        Command::Replay(arguments) => replay::run(arguments, format),
        Command::Play(arguments) => play::run(arguments, format),
        Command::Calibrate(arguments) => calibrate::run(arguments, format),
        Command::Learn(arguments) => learn::run(arguments, format),
        Command::List(arguments) => list::run(arguments, format),
        Command::Echo(arguments) => echo::run(arguments, format),
        Command::Osc(arguments) => osc::run(arguments, format),
        Command::Phone(arguments) => phone::run(arguments, format),
        Command::Mavlink(arguments) => mavlink::run(arguments, format),
        Command::Vrpn(arguments) => vrpn::run(arguments, format),
        Command::NatNet(arguments) => natnet::run(arguments, format),
        Command::Mqtt(arguments) => mqtt::run(arguments, format),
        Command::Nt4(arguments) => nt4::run(arguments, format),
        Command::Psn(arguments) => psn::run(arguments, format),
        Command::FreeD(arguments) => freed::run(arguments, format),
        Command::OpenTrackIo(arguments) => opentrackio::run(arguments, format),
        Command::Hz(arguments) => hz::run(arguments, format),
        Command::Top(arguments) => top::run(arguments, format),
        Command::Foxglove(arguments) => foxglove::run(arguments, format),
        Command::Ros2(arguments) => ros2::run(arguments, format),
        Command::Print(arguments) => print::run(arguments, format),
        Command::Convert(arguments) => convert::run(arguments, format),
        Command::Config(arguments) => config::run(arguments, format),
        Command::Doctor(arguments) => doctor::run(arguments, format),
        Command::Keys(arguments) => keys::run(arguments, format),
        Command::Deploy(arguments) => deploy::run(arguments, format),
        Command::Check(arguments) => check::run(arguments, format),
        Command::Camera(arguments) => camera::run(arguments, format),
        Command::Fusion(arguments) => nodes::fusion(arguments),
        Command::Router(arguments) => router::run(arguments),
        Command::Viewer(arguments) => nodes::viewer(arguments),
        Command::Completions(arguments) => manual::completions(arguments, Arguments::command()),
        Command::Manual(arguments) => manual::run(arguments, Arguments::command()),
    }
}
