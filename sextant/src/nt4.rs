//! `sextant nt4`: poses as values of NetworkTables 4, at the server of a robot.

use crate::output::{Format, print_line};
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use anyhow::Context;
use clap::Args;
use sextant_gateways::nt4::{TableCounts, TableError, TablePublisher};
use sextant_process::{Exit, WithExit};
use sextant_site_model::ObjectId;

/// Arguments of `sextant nt4`.
#[derive(Args, Debug)]
#[command(
    after_help = "Publishes /Sextant/ID/pose of each tracked object as struct:Pose3d, with its schema, at the capture
time by the server's clock: what a pose estimator of WPILib wants. Sextant's world is the field's frame where x points
away from the blue alliance's wall, y to the left, z up. With --json, one line at the end: {\"poses\",\"refused\",
\"superseded\",\"dropped\",\"sent\",\"unsent\",\"skipped\"}"
)]
pub struct Nt4Arguments {
    /// The robot, or a computer with a server: its port is 5810.
    #[arg(long, value_name = "HOST[:PORT]")]
    to: String,
    /// What the names of topics begin with.
    #[arg(long, value_name = "NAME", default_value = "/Sextant", value_parser = prefix)]
    prefix: String,
    /// An object; may be repeated. By default all objects.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most poses a second of each object.
    #[arg(long, value_name = "HZ", default_value = "50", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

fn prefix(text: &str) -> Result<String, &'static str> {
    match text.starts_with('/') && text.len() < 200 && !text.contains(char::is_control) {
        true => Ok(text.trim_end_matches('/').to_owned()),
        false => Err("a name begins with /, such as /Sextant"),
    }
}

/// Runs `sextant nt4`.
///
/// # Errors
/// An address that is none, a server that is unreachable, no router.
pub fn run(arguments: &Nt4Arguments, format: Format) -> anyhow::Result<()> {
    let (to, prefix) = (&arguments.to, arguments.prefix.clone());
    let started = TablePublisher::start(to, prefix, arguments.rate, pose_feed::reporter());
    let mut publisher = started.or_else(|error| {
        let exit = match &error {
            TableError::Address => Exit::Usage,
            _ => Exit::Unavailable,
        };
        Err(error)
            .with_context(|| format!("--to {to}"))
            .exit_with(exit)
    })?;
    eprintln!(
        "publishing {} at {to} below {}, at most {} a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        arguments.prefix,
        arguments.rate
    );
    let feed = pose_feed::run(&arguments.feed, &arguments.objects, &mut publisher)?;
    print_counts(&publisher.finish(feed), format)
}

fn print_counts(counts: &TableCounts, format: Format) -> anyhow::Result<()> {
    let feed = counts.feed;
    match format {
        Format::Json => print_line(&serde_json::to_string(counts)?)?,
        Format::Text => eprintln!(
            "{} sent of {}; {} skipped by the rate limit, {} dropped, {} refused; {} unsent",
            words::count(counts.sent as usize, "value"),
            words::count(feed.poses as usize, "pose"),
            counts.skipped,
            feed.dropped,
            feed.refused,
            counts.unsent
        ),
    }
    Ok(())
}
