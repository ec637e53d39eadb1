//! `sextant vrpn`: each object as a tracker of a VRPN server.

use crate::axes::AxesName;
use crate::listening::listen_unprotected;
use crate::output::{Format, print_line};
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use anyhow::Context;
use clap::Args;
use sextant_gateways::vrpn::{StartError, TrackerCounts, TrackerServer};
use sextant_pose_streams::VRPN_PORT;
use sextant_process::{Exit, WithExit};
use sextant_site_model::ObjectId;

/// Arguments of `sextant vrpn`.
#[derive(Args, Debug)]
#[command(
    after_help = "Each object is a tracker of its name with sensor 0: a client asks for cube@HOST, or cube@tcp://HOST
where a firewall is between. Objects that are tracked or coasting are sent, with the capture time, in metres; the
quaternion is x y z w. VRPN knows no passwords: whoever reaches the address can read the poses. --listen 0.0.0.0 lets
other machines connect. With --json, one line at the end: {\"poses\",\"refused\",\"dropped\",\"sent\",\"skipped\",
\"clients\",\"slow\",\"turned_away\"}"
)]
pub struct VrpnArguments {
    /// Address of the server.
    #[arg(long, value_name = "HOST[:PORT]", default_value_t = format!("127.0.0.1:{VRPN_PORT}"))]
    listen: String,
    /// Axes of positions and quaternions.
    #[arg(long, value_enum, default_value_t = AxesName::ZUp)]
    axes: AxesName,
    /// An object; may be repeated. By default all objects.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most poses a second of each object.
    #[arg(long, value_name = "HZ", default_value = "120", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

/// Runs `sextant vrpn`.
///
/// # Errors
/// An address that is invalid or in use, no router.
pub fn run(arguments: &VrpnArguments, format: Format) -> anyhow::Result<()> {
    let mut trackers = arguments.server()?;
    eprintln!(
        "serving {} as VRPN trackers at {}, at most {} a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        trackers.address(),
        arguments.rate
    );
    let feed = pose_feed::run(&arguments.feed, &arguments.objects, &mut trackers)?;
    print_counts(&trackers.counts(feed), format)
}

impl VrpnArguments {
    fn server(&self) -> anyhow::Result<TrackerServer> {
        let listener = listen_unprotected(&self.listen, VRPN_PORT, "VRPN", &self.feed.site)?;
        let server =
            TrackerServer::start(listener, self.axes.into(), self.rate, pose_feed::reporter());
        match server {
            Err(error @ StartError::UdpPort(_)) => Err(error)
                .with_context(|| format!("--listen {}", self.listen))
                .exit_with(Exit::Unavailable),
            server => Ok(server?),
        }
    }
}

fn print_counts(counts: &TrackerCounts, format: Format) -> anyhow::Result<()> {
    let (feed, server) = (counts.feed, counts.server);
    match format {
        Format::Json => print_line(&serde_json::to_string(counts)?)?,
        Format::Text => eprintln!(
            "{} to {} from {}; {} skipped by the rate limit, {} dropped, {} refused; {} dropped \
             as too slow, {} turned away",
            words::count(server.sent as usize, "message"),
            words::count(server.clients as usize, "client"),
            words::count(feed.poses as usize, "pose"),
            counts.skipped,
            feed.dropped,
            feed.refused,
            words::count(server.slow as usize, "client"),
            server.turned_away
        ),
    }
    Ok(())
}
