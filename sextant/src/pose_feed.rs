//! What the commands share that pass on the poses of a running site.

use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use anyhow::Context;
use clap::Args;
use sextant_gateways::datagrams::{DatagramTarget, SenderCounts, TargetError};
use sextant_gateways::pose_feed::{self, FeedCounts, PoseReceiver};
use sextant_gateways::{Notice, Reporter, SiteSession};
use sextant_process::{Exit, WithExit};
use sextant_site_model::ObjectId;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::{Duration, Instant};

/// Which site, and for how long.
#[derive(Args, Debug)]
pub struct FeedArguments {
    /// End after this time, in seconds; by default with Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration: Option<Duration>,
    #[command(flatten)]
    pub site: SiteArguments,
}

fn seconds(text: &str) -> anyhow::Result<Duration> {
    Ok(Duration::try_from_secs_f64(text.parse()?)?)
}

/// Hands the poses of these objects to `receiver`, those of all objects when none is named, until the time is over,
/// Ctrl-C, or the receiver is done.
///
/// # Errors
/// No router, or an error of the receiver.
pub fn run<R: PoseReceiver>(
    arguments: &FeedArguments,
    objects: &[ObjectId],
    receiver: &mut R,
) -> anyhow::Result<FeedCounts>
where
    anyhow::Error: From<R::Error>,
{
    run_on(arguments.site.open()?, arguments, objects, receiver)
}

/// As [`run`], on a session that is open already.
///
/// # Errors
/// An error of the receiver.
pub fn run_on<R: PoseReceiver>(
    site: SiteSession,
    arguments: &FeedArguments,
    objects: &[ObjectId],
    receiver: &mut R,
) -> anyhow::Result<FeedCounts>
where
    anyhow::Error: From<R::Error>,
{
    let end = arguments
        .duration
        .map(|duration| Instant::now().checked_add(duration).context("--duration"))
        .transpose()?;
    Ok(pose_feed::run(site, objects, end, receiver, &reporter())?)
}

/// Prints notices on standard error.
pub fn reporter() -> Reporter {
    Reporter::new(|notice| {
        let words = words::plain(&notice.to_string());
        match notice {
            Notice::NoPose { .. } => eprintln!("{words} (`sextant list` shows more)"),
            Notice::NoRosRouter { .. } => eprintln!(
                "{words}. Start `ros2 run rmw_zenoh_cpp rmw_zenohd`, or name another with --router"
            ),
            _ => eprintln!("{words}"),
        }
    })
}

/// Value of `--to`: the machine and port to which datagrams go.
///
/// # Errors
/// [`Exit::Usage`] for what is no address of one machine, [`Exit::Unavailable`] for a name that is not found.
pub fn datagram_target(target: &str) -> anyhow::Result<DatagramTarget> {
    opened(target, DatagramTarget::open(target, reporter()))
}

/// Value of `--to` where a multicast group is allowed too, which is reached from this machine's address `interface`.
///
/// # Errors
/// As [`datagram_target`]; [`Exit::Usage`] for an address that this machine does not have.
pub fn group_or_machine(target: &str, interface: Ipv4Addr) -> anyhow::Result<DatagramTarget> {
    match target.parse::<SocketAddrV4>() {
        Ok(group) if group.ip().is_multicast() && group.port() != 0 => {
            let described = format!("{target} --interface {interface}");
            opened(
                &described,
                DatagramTarget::group(group, interface, reporter()),
            )
        }
        _ => datagram_target(target),
    }
}

fn opened(
    target: &str,
    result: Result<DatagramTarget, TargetError>,
) -> anyhow::Result<DatagramTarget> {
    result.or_else(|error| {
        let exit = match &error {
            TargetError::Address(_) => Exit::Usage,
            TargetError::Host { .. } | TargetError::Unreachable(_) => Exit::Unavailable,
            TargetError::Socket(_) => Exit::Fault,
        };
        Err(error)
            .with_context(|| format!("--to {target}"))
            .exit_with(exit)
    })
}

/// Prints the counts of a sender of datagrams.
///
/// # Errors
/// A closed output.
pub fn print_counts(counts: &SenderCounts, format: Format) -> anyhow::Result<()> {
    let (feed, datagrams) = (counts.feed, counts.datagrams);
    match format {
        Format::Json => print_line(&serde_json::to_string(counts)?)?,
        Format::Text => eprintln!(
            "{} from {}; {} skipped by the rate limit, {} dropped, {} refused; {} unsent",
            words::count(datagrams.sent as usize, "datagram"),
            words::count(feed.poses as usize, "pose"),
            counts.skipped,
            feed.dropped,
            feed.refused,
            datagrams.unsent
        ),
    }
    Ok(())
}

/// A rate in hertz.
pub fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.1..=1000.0).contains(&rate) => Ok(rate),
        _ => Err("a rate is a number from 0.1 to 1000 (poses a second)".to_owned()),
    }
}
