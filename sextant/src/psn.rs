//! `sextant psn`: each object as a tracker of PosiStageNet.

use crate::axes::AxesName;
use crate::output::Format;
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use clap::Args;
use sextant_gateways::psn::TrackerSender;
use sextant_pose_streams::PSN_GROUP;
use sextant_site_model::ObjectId;
use std::net::Ipv4Addr;

/// Arguments of `sextant psn`.
#[derive(Args, Debug)]
#[command(
    after_help = "PosiStageNet 2.03: position, speed, orientation, validity (1 tracked, 0.5 coasting, 0 lost) and
capture time of each object, and once a second their names. The tracker of the first --object is 1; without --object
they are numbered by name. Lighting consoles and media servers listen to 236.10.10.10 on port 56565: name this machine's
address on their network with --interface. docs/outputs.md has more. With --json, one line at the end: {\"poses\",
\"refused\",\"superseded\",\"dropped\",\"sent\",\"unsent\",\"unheard\",\"skipped\"}"
)]
pub struct PsnArguments {
    /// Multicast group, or one machine.
    #[arg(long, value_name = "HOST:PORT", default_value_t = PSN_GROUP.to_string())]
    to: String,
    /// This machine's address on the network of the group; the default stays on this machine.
    #[arg(long, value_name = "ADDRESS", default_value_t = Ipv4Addr::LOCALHOST)]
    interface: Ipv4Addr,
    /// Axes of positions and orientations; PosiStageNet's are unity: x right, y up, z into the depth.
    #[arg(long, value_enum, default_value_t = AxesName::Unity)]
    axes: AxesName,
    /// An object; may be repeated. By default all objects.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most frames a second.
    #[arg(long, value_name = "HZ", default_value = "60", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

/// Runs `sextant psn`.
///
/// # Errors
/// A target or an interface that is none, no router.
pub fn run(arguments: &PsnArguments, format: Format) -> anyhow::Result<()> {
    let target = pose_feed::group_or_machine(&arguments.to, arguments.interface)?;
    eprintln!(
        "sending {} to {} by UDP as PosiStageNet trackers, at most {} frames a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        target.address(),
        arguments.rate
    );
    let axes = arguments.axes.into();
    let mut sender = TrackerSender::new(axes, &arguments.objects, target, arguments.rate);
    let feed = pose_feed::run(&arguments.feed, &arguments.objects, &mut sender)?;
    pose_feed::print_counts(&sender.counts(feed), format)
}
