//! `sextant mavlink`: the pose of a vehicle as MAVLink `ODOMETRY`, by UDP to its autopilot.

use crate::output::Format;
use crate::pose_feed::{self, FeedArguments};
use clap::{Args, ValueEnum};
use sextant_gateways::mavlink::OdometrySender;
use sextant_pose_streams::{LocalFrame, Sender};
use sextant_site_model::ObjectId;

/// Arguments of `sextant mavlink`.
#[derive(Args, Debug)]
#[command(
    after_help = "Sends ODOMETRY (MAVLink 2) of each tracked pose, with covariance, and a HEARTBEAT a second. The
object's x axis is the vehicle's forward, its z axis up. reset_counter is raised when the object is found again and when
its pose jumps. Autopilots want 30 to 50 poses a second: no pose is repeated, so the cameras have to give as many.
docs/outputs.md has the settings of PX4 and ArduPilot. With --json, one line at the end: {\"poses\",\"refused\",
\"dropped\",\"sent\",\"unsent\",\"unheard\",\"skipped\"}"
)]
pub struct MavlinkArguments {
    /// The autopilot, or the router before it.
    #[arg(long, value_name = "udp:HOST:PORT")]
    to: String,
    /// The vehicle.
    #[arg(long, value_name = "ID")]
    object: ObjectId,
    /// Most poses a second.
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = pose_feed::rate)]
    rate: f64,
    /// Frame of positions and attitudes.
    #[arg(long, value_enum, default_value_t = Frame::Frd)]
    frame: Frame,
    /// Direction of north for --frame ned: degrees from the world's x axis towards its y axis.
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = degrees, allow_negative_numbers = true)]
    north: f64,
    /// System id of the vehicle.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=255))]
    sysid: u8,
    /// Component id of this program: MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY.
    #[arg(long, value_name = "N", default_value_t = 197, value_parser = clap::value_parser!(u8).range(1..=255))]
    compid: u8,
    #[command(flatten)]
    feed: FeedArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Frame {
    /// Forward, right, down: x of the world is forward (MAV_FRAME_LOCAL_FRD).
    Frd,
    /// North, east, down (MAV_FRAME_LOCAL_NED).
    Ned,
}

fn degrees(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees.abs() <= 360.0 => Ok(degrees),
        _ => Err("an angle is a number from -360 to 360".to_owned()),
    }
}

/// Runs `sextant mavlink`.
///
/// # Errors
/// A target that is none, no router.
pub fn run(arguments: &MavlinkArguments, format: Format) -> anyhow::Result<()> {
    let target = arguments.to.strip_prefix("udp:").unwrap_or(&arguments.to);
    let target = pose_feed::datagram_target(target)?;
    eprintln!(
        "sending the pose of {} to {} by UDP as MAVLink ODOMETRY of system {}, at most {} a second; Ctrl-C ends it",
        arguments.object,
        target.address(),
        arguments.sysid,
        arguments.rate
    );
    let sender = Sender {
        system: arguments.sysid,
        component: arguments.compid,
    };
    let local = match arguments.frame {
        Frame::Frd => LocalFrame::Frd,
        Frame::Ned => LocalFrame::Ned {
            north_rad: arguments.north.to_radians(),
        },
    };
    let mut vehicle = OdometrySender::new(sender, local, target, arguments.rate)?;
    let objects = std::slice::from_ref(&arguments.object);
    let feed = pose_feed::run(&arguments.feed, objects, &mut vehicle)?;
    pose_feed::print_counts(&vehicle.counts(feed), format)
}
