//! `sextant mqtt`: poses and events of zones as messages of MQTT, for home automation and dashboards.

use crate::output::{Format, print_line};
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use anyhow::Context;
use clap::Args;
use sextant_gateways::mqtt::{
    Broker, BrokerError, MqttCounts, MqttOptions, MqttPublisher, StartError, Tls,
};
use sextant_process::{Exit, WithExit};
use sextant_site_model::ObjectId;
use std::path::PathBuf;

/// Arguments of `sextant mqtt`.
#[derive(Args, Debug)]
#[command(after_help = "Topics, with the default prefix and the site demo:
  sextant/demo/status               online or offline, retained; the broker says offline when this program is gone
  sextant/demo/object/ID/pose       JSON, as `sextant echo --format json`
  sextant/demo/object/ID/event      JSON, when an object enters or leaves a zone or falls: docs/live.md
With --home-assistant each object appears there as a device. MQTT 5, without acknowledgement (QoS 0). Poses of all
states are sent; that an object is lost is never held back. docs/outputs.md has more. With --json, one line at the end:
{\"poses\",\"refused\",\"superseded\",\"dropped\",\"events\",\"refused_events\",\"sent\",\"unsent\",\"skipped\"}")]
pub struct MqttArguments {
    /// The broker: mqtt://HOST, or mqtts://HOST for TLS; a port other than 1883 and 8883 as HOST:PORT.
    #[arg(long, value_name = "URL", default_value = "mqtt://127.0.0.1")]
    to: String,
    /// Name of a user of the broker.
    #[arg(long, value_name = "NAME", requires = "password")]
    user: Option<String>,
    /// The user's password.
    #[arg(
        long,
        env = "SEXTANT_MQTT_PASSWORD",
        hide_env_values = true,
        value_name = "TEXT"
    )]
    password: Option<String>,
    /// Authorities that may have signed the broker's certificate, in PEM; by default those of this system.
    #[arg(long, value_name = "FILE")]
    ca: Option<PathBuf>,
    /// What topics begin with; by default sextant/ and the name of the site.
    #[arg(long, value_name = "TOPIC", value_parser = topic)]
    prefix: Option<String>,
    /// Announce the objects to Home Assistant, below its discovery prefix.
    #[arg(
        long,
        value_name = "TOPIC",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "homeassistant",
        value_parser = topic
    )]
    home_assistant: Option<String>,
    /// An object; may be repeated. By default all objects.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most poses a second of each object.
    #[arg(long, value_name = "HZ", default_value = "5", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

fn topic(text: &str) -> Result<String, &'static str> {
    let is_wrong = |c: char| matches!(c, '+' | '#') || c.is_control();
    match text.is_empty() || text.len() > 1000 || text.contains(is_wrong) {
        true => Err("a topic is not empty and has neither + nor #"),
        false => Ok(text.trim_end_matches('/').to_owned()),
    }
}

/// Runs `sextant mqtt`.
///
/// # Errors
/// An address that is none, a broker that is unreachable or refuses, no router.
pub fn run(arguments: &MqttArguments, format: Format) -> anyhow::Result<()> {
    let broker = arguments.explained(Broker::parse(&arguments.to, arguments.trust()))?;
    let name = broker.to_string();
    if broker.is_plain() && arguments.user.is_some() {
        eprintln!("warning: the password goes to {name} without encryption; use mqtts://");
    }
    let site = arguments.feed.site.open()?;
    let options = arguments.options();
    let prefix = options.prefix.clone();
    let user = arguments.user.clone();
    let user = user.zip(arguments.password.clone());
    let mut publisher =
        match MqttPublisher::start(&site, broker, user, options, pose_feed::reporter()) {
            Err(StartError::Broker(error)) => arguments.explained(Err(error))?,
            started => started?,
        };
    eprintln!(
        "publishing {} at {name} below {prefix}, at most {} a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        arguments.rate
    );
    let feed = pose_feed::run_on(site, &arguments.feed, &arguments.objects, &mut publisher)?;
    print_counts(&publisher.finish(feed), format)
}

impl MqttArguments {
    fn trust(&self) -> Tls<'_> {
        self.ca.as_deref().map_or(Tls::System, Tls::File)
    }

    fn options(&self) -> MqttOptions {
        let site = self.feed.site.site().to_string();
        let usual = || format!("sextant/{site}");
        MqttOptions {
            prefix: self.prefix.clone().unwrap_or_else(usual),
            site,
            home_assistant: self.home_assistant.clone(),
            objects: self.objects.clone(),
            rate_hz: self.rate,
        }
    }

    fn explained<T>(&self, result: Result<T, BrokerError>) -> anyhow::Result<T> {
        result.or_else(|error| {
            let exit = match &error {
                BrokerError::Address => Exit::Usage,
                BrokerError::Certificates(_) => Exit::Input,
                _ => Exit::Unavailable,
            };
            Err(error)
                .with_context(|| format!("--to {}", self.to))
                .exit_with(exit)
        })
    }
}

fn print_counts(counts: &MqttCounts, format: Format) -> anyhow::Result<()> {
    let feed = counts.feed;
    match format {
        Format::Json => print_line(&serde_json::to_string(counts)?)?,
        Format::Text => eprintln!(
            "{} from {} and {}; {} skipped by the rate limit, {} dropped, {} refused; {} unsent",
            words::count(counts.sent as usize, "message"),
            words::count(feed.poses as usize, "pose"),
            words::count(counts.events as usize, "event"),
            counts.skipped,
            feed.dropped,
            feed.refused + counts.refused_events,
            counts.unsent
        ),
    }
    Ok(())
}
