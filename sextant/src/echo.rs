//! `sextant echo`: messages of a site as they come.

mod pose_text;

use crate::message_text::{JsonMessage, text_of};
use crate::output::{Format, print_line};
use crate::pose_feed::FeedArguments;
use crate::site::{expression, report_router};
use crate::words;
use anyhow::{anyhow, bail};
use clap::Args;
use pose_text::PoseFormat;
use serde::Serialize;
use sextant_gateways::site::{RouterWatch, SiteSession};
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure, now_ns};
use sextant_proto::{AnyMessage, limits};
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_zenoh_bus::{DropRule, Item, Payload};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Messages that wait while the terminal is slow; the oldest give way.
const QUEUE: usize = 1024;
/// Silence after which a notice is printed.
const SILENCE: Duration = Duration::from_nanos(SILENCE_NS);
/// Timeout of queries for last values.
const ANSWER: Duration = Duration::from_millis(500);

/// Arguments of `sextant echo`.
#[derive(Args, Debug)]
#[command(
    after_help = "With --json, one line per message: {\"key\",\"received_ns\",\"message\"}, or
{\"key\",\"received_ns\",\"error\"} for a payload that is not a message. With --format, a line per pose of the named
objects: JSON lines and TUM as `sextant replay` writes them, or CSV. Stop with Ctrl-C."
)]
pub struct EchoArguments {
    /// A camera, an object, a node, or a key (`camera/north/preview`, `config/**`); the poses of all objects when
    /// absent. With --format, any number of objects.
    #[arg(value_name = "NAME|KEY")]
    names: Vec<String>,
    /// Print poses only, as text for other programs.
    #[arg(long, value_enum, conflicts_with = "json")]
    format: Option<PoseFormat>,
    /// File for the poses instead of standard output.
    #[arg(long, value_name = "FILE", requires = "format")]
    out: Option<PathBuf>,
    /// Replace the file if it exists.
    #[arg(long, requires = "out")]
    force: bool,
    /// Give poses in the base of this robot, a file of `sextant calibrate robot`, instead of the world.
    #[arg(long, value_name = "FILE", requires = "format")]
    frame: Option<PathBuf>,
    /// End after this number of messages.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    #[command(flatten)]
    feed: FeedArguments,
}

/// Runs `sextant echo`.
///
/// # Errors
/// No router, or a key that is none.
pub fn run(arguments: &EchoArguments, format: Format) -> anyhow::Result<()> {
    if let Some(format) = arguments.format {
        return pose_text::run(arguments, format);
    }
    if arguments.names.len() > 1 {
        let cause =
            anyhow!("name one camera, object, node or key; several objects are for --format");
        bail!(Failure::new(Exit::Usage, cause))
    }
    let site = arguments.feed.site.open()?;
    let expression = match arguments.names.first() {
        Some(name) => expression(&site.keys, name),
        None => site.keys.all_poses(),
    };
    let end = arguments
        .feed
        .duration
        .and_then(|duration| Instant::now().checked_add(duration));
    let is_over = || end.is_some_and(|end| Instant::now() >= end);
    // Previews are large and say nothing in a terminal: only where they are asked for.
    let previews = expression.contains("preview");
    let mut left = arguments.count.unwrap_or(u64::MAX);
    let mut show = |item: &Item| -> anyhow::Result<bool> {
        if left > 0 && (previews || !item.key.ends_with("/preview")) {
            print_line(&line_of(item, format))?;
            left -= 1;
        }
        Ok(left > 0)
    };
    let messages = site.bus.subscribe(
        &expression,
        QUEUE,
        DropRule::Oldest,
        limits::MAX_PAYLOAD_BYTES,
    )?;
    let mut more = true;
    let kept = site
        .bus
        .latest(&expression, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
    for item in &kept {
        more = show(item)?;
    }
    let (mut router, mut heard) = (RouterWatch::default(), !kept.is_empty());
    let mut hint_due = Some(Instant::now() + SILENCE);
    while more && !site.shutdown.is_requested() && !is_over() {
        if let Some(item) = messages.recv_timeout(SHUTDOWN_POLL) {
            (heard, hint_due) = (true, Some(Instant::now() + SILENCE));
            more = show(&item)?;
        }
        report_router(&mut router, &site.bus);
        if hint_due.is_some_and(|due| Instant::now() >= due) {
            if site.bus.is_connected() {
                report_silence(&site, &expression, heard);
            }
            hint_due = None;
        }
    }
    site.bus.close();
    Ok(())
}

fn report_silence(site: &SiteSession, expression: &str, heard: bool) {
    let silence = match heard {
        true => format!("for {} s", SILENCE.as_secs()),
        false => "so far".to_owned(),
    };
    let objects = site.objects_in_words();
    eprintln!("nothing on {expression} {silence}; {objects} (`sextant list` shows more)");
}

#[derive(Serialize)]
struct Line<'a> {
    key: &'a str,
    received_ns: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<JsonMessage<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a str>,
}

fn line_of(item: &Item, format: Format) -> String {
    let now = now_ns();
    let message = match &item.payload {
        Payload::Bytes(bytes) => AnyMessage::decode(bytes).map_err(|error| error.to_string()),
        Payload::TooLong(length) => Err(format!("{length} bytes are longer than any message")),
    };
    match format {
        Format::Json => {
            let line = Line {
                key: &item.key,
                received_ns: now,
                message: message.as_ref().ok().map(JsonMessage::from),
                error: message.as_ref().err().map(String::as_str),
            };
            // Numbers, names and enums: there is nothing that JSON could refuse.
            serde_json::to_string(&line).unwrap_or_default()
        }
        Format::Text => {
            let text = message.map_or_else(|error| format!("no message: {error}"), |m| text_of(&m));
            let key = words::plain(short(&item.key));
            format!("{} {key}  {text}", words::time_of_day(now))
        }
    }
}

/// A key without `sextant/v1/<site>/`.
pub fn short(key: &str) -> &str {
    key.splitn(4, '/').nth(3).unwrap_or(key)
}
