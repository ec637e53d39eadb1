//! `sextant opentrackio`: the pose of a camera as samples of OpenTrackIO.

use crate::output::Format;
use crate::pose_feed::{self, FeedArguments};
use clap::Args;
use sextant_gateways::camera_tracking::{CameraSender, TrackedCamera};
use sextant_pose_streams::{OpenTrackIoCamera, opentrackio_group};
use sextant_process::now_ns;
use sextant_site_model::ObjectId;
use std::net::Ipv4Addr;

/// Arguments of `sextant opentrackio`.
#[derive(Args, Debug)]
#[command(
    after_help = "Sends a sample in JSON (OpenTrackIO 1.0) of each pose that is tracked or coasting: translation, pan,
tilt, roll, capture time. The object's x axis is the optical axis, y is left, z up. Receivers listen to 239.135.1.N on
port 55555, N the number of the source: name this machine's address on their network with --interface. docs/outputs.md
has more. With --json, one line at the end: {\"poses\",\"refused\",\"superseded\",\"dropped\",\"sent\",\"unsent\",
\"unheard\",\"skipped\"}"
)]
pub struct OpenTrackIoArguments {
    /// The camera.
    #[arg(long, value_name = "ID")]
    object: ObjectId,
    /// Number of the source.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=200))]
    source: u8,
    /// Multicast group, or one machine; by default the group of the source.
    #[arg(long, value_name = "HOST:PORT")]
    to: Option<String>,
    /// This machine's address on the network of the group; the default stays on this machine.
    #[arg(long, value_name = "ADDRESS", default_value_t = Ipv4Addr::LOCALHOST)]
    interface: Ipv4Addr,
    /// Most poses a second.
    #[arg(long, value_name = "HZ", default_value = "60", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

/// Runs `sextant opentrackio`.
///
/// # Errors
/// A target or an interface that is none, no router.
pub fn run(arguments: &OpenTrackIoArguments, format: Format) -> anyhow::Result<()> {
    let usual = || opentrackio_group(arguments.source).to_string();
    let to = arguments.to.clone().unwrap_or_else(usual);
    let target = pose_feed::group_or_machine(&to, arguments.interface)?;
    eprintln!(
        "sending the pose of {} to {} by UDP as OpenTrackIO source {}, at most {} a second; Ctrl-C ends it",
        arguments.object,
        target.address(),
        arguments.source,
        arguments.rate
    );
    let camera = OpenTrackIoCamera::new(arguments.source, now_ns());
    let camera = TrackedCamera::OpenTrackIo(camera);
    let mut sender = CameraSender::new(camera, target, arguments.rate);
    let objects = std::slice::from_ref(&arguments.object);
    let feed = pose_feed::run(&arguments.feed, objects, &mut sender)?;
    pose_feed::print_counts(&sender.counts(feed), format)
}
