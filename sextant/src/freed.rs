//! `sextant freed`: the pose of a camera as Free-D messages, by UDP to one machine.

use crate::output::Format;
use crate::pose_feed::{self, FeedArguments};
use clap::Args;
use sextant_gateways::camera_tracking::{CameraSender, TrackedCamera};
use sextant_pose_streams::FreeDCamera;
use sextant_site_model::ObjectId;

/// Arguments of `sextant freed`.
#[derive(Args, Debug)]
#[command(
    after_help = "Sends message D1 (29 bytes) of each pose that is tracked or coasting: pan, tilt, roll, x, y, height.
The object's x axis is the optical axis, y is left, z up. Pan 0 looks along the world's x axis, which is Free-D's y;
Free-D's x is to the right. Unreal (Live Link Free-D), Vizrt, Aximmetry, Pixotope and Disguise read it; they ask for a
port. docs/outputs.md has more. With --json, one line at the end: {\"poses\",\"refused\",\"superseded\",\"dropped\",
\"sent\",\"unsent\",\"unheard\",\"skipped\"}"
)]
pub struct FreeDArguments {
    /// The receiver.
    #[arg(long, value_name = "HOST:PORT")]
    to: String,
    /// The camera.
    #[arg(long, value_name = "ID")]
    object: ObjectId,
    /// Number of the camera.
    #[arg(long, value_name = "N", default_value_t = 1)]
    camera: u8,
    /// Raw zoom of its lens, which stays as it is: 0 to 16777215.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..1 << 24))]
    zoom: u32,
    /// Raw focus of its lens, which stays as it is: 0 to 16777215.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..1 << 24))]
    focus: u32,
    /// Most poses a second.
    #[arg(long, value_name = "HZ", default_value = "60", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

/// Runs `sextant freed`.
///
/// # Errors
/// A target that is none, no router.
pub fn run(arguments: &FreeDArguments, format: Format) -> anyhow::Result<()> {
    let target = pose_feed::datagram_target(&arguments.to)?;
    eprintln!(
        "sending the pose of {} to {} by UDP as Free-D camera {}, at most {} a second; Ctrl-C ends it",
        arguments.object,
        target.address(),
        arguments.camera,
        arguments.rate
    );
    let camera = FreeDCamera {
        id: arguments.camera,
        zoom: arguments.zoom,
        focus: arguments.focus,
    };
    let camera = TrackedCamera::FreeD(camera);
    let mut sender = CameraSender::new(camera, target, arguments.rate);
    let objects = std::slice::from_ref(&arguments.object);
    let feed = pose_feed::run(&arguments.feed, objects, &mut sender)?;
    pose_feed::print_counts(&sender.counts(feed), format)
}
