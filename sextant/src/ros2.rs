//! `sextant ros2`: a site's poses, detections, lenses and pictures as ROS 2 topics, by the protocol of rmw_zenoh.
//!
//! Two sessions: one on the site's router, as every tool has, and one on the router of ROS, of which this program is a client, since
//! that router does not forward between peers. What becomes which message is `sextant-ros2`'s.

mod publishers;

use crate::output::{Format, print_line};
use crate::site::{RouterWatch, Site, SiteArguments};
use anyhow::Context;
use clap::Args;
use publishers::Publishers;
use serde_json::json;
use sextant_process::{Exit, Failure, Shutdown, WithExit, now_ns};
use sextant_proto::limits;
use sextant_ros2::{Bridge, BridgeOptions, Distribution, Graph, Namespace};
use sextant_zenoh_bus::{
    Bus, BusError, BusOptions, Item, Profile, Security, StreamBounds, why_no_router,
};
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Messages of the site that wait while the router of ROS is slow; the oldest give way.
const WAITING: StreamBounds = StreamBounds {
    items: 4096,
    bytes: 16 << 20,
    wait: Duration::from_millis(500),
};
/// Longest delay until Ctrl-C has an effect.
const GLANCE: Duration = Duration::from_millis(50);
/// Timeout of the query for rig and objects.
const ANSWER: Duration = Duration::from_secs(1);
/// Period of `/diagnostics`.
const DIAGNOSTICS: Duration = Duration::from_secs(1);
/// Time without a router of ROS before it is reported.
const HICCUP: Duration = Duration::from_secs(1);

/// Arguments of `sextant ros2`.
#[derive(Args, Debug)]
#[command(after_help = "Topics, with the default namespace:
  /tf, /tf_static                            tf2_msgs/TFMessage: objects and links; cameras and tags
  /sextant/object/ID/pose                    geometry_msgs/PoseWithCovarianceStamped
  /sextant/camera/ID/detections              apriltag_msgs/AprilTagDetectionArray
  /sextant/camera/ID/camera_info             sensor_msgs/CameraInfo, for late subscribers too
  /sextant/camera/ID/preview/image/compressed, .../preview/camera_info
  /diagnostics                               diagnostic_msgs/DiagnosticArray

ROS 2 must use rmw_zenoh_cpp (RMW_IMPLEMENTATION), with its router running. See docs/ros2.md.
With --json, one line per event: {\"event\":\"connected\",\"router\",\"session\"}, {\"event\":\"topic\",\"name\",\"type\"},
and at the end {\"event\":\"end\",\"published\",\"failed\",\"dropped\",\"invalid\",\"over_rate\",\"superseded\",\"name_taken\"}.
Stop with Ctrl-C.")]
pub struct Ros2Arguments {
    /// Endpoint of the router of ROS (rmw_zenohd).
    #[arg(long, value_name = "ENDPOINT", default_value = "tcp/localhost:7447")]
    router: String,
    /// Domain of ROS.
    #[arg(long, env = "ROS_DOMAIN_ID", value_name = "N", default_value_t = 0,
          value_parser = clap::value_parser!(u32).range(0..=232))]
    domain: u32,
    /// Release of ROS: humble, jazzy, kilted, lyrical or rolling.
    #[arg(long, env = "ROS_DISTRO", value_name = "NAME", default_value = "jazzy")]
    distro: Distribution,
    /// Namespace of the topics of objects and cameras.
    #[arg(long, value_name = "NAME", default_value = "sextant")]
    namespace: Namespace,
    /// Name of the world's frame.
    #[arg(long, value_name = "NAME", default_value = "world", value_parser = frame)]
    frame: String,
    /// Most messages per second of each object, and of each camera's detections and pictures; all when absent.
    #[arg(long, value_name = "HZ", value_parser = rate)]
    max_rate: Option<f64>,
    #[command(flatten)]
    site: SiteArguments,
}

fn frame(text: &str) -> Result<String, String> {
    if text.is_empty() || text.starts_with('/') {
        return Err("a frame has a name without a slash in front".to_owned());
    }
    Ok(text.to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|cause| format!("{cause}"))?;
    if (0.01..=1000.0).contains(&rate) {
        Ok(rate)
    } else {
        Err("a rate is from 0.01 to 1000 Hz".to_owned())
    }
}

/// Runs `sextant ros2`.
///
/// # Errors
/// No router of the site, or an endpoint that is none. Without a router of ROS it waits.
pub fn run(arguments: &Ros2Arguments, format: Format) -> anyhow::Result<()> {
    let site = arguments.site.open()?;
    let ros = arguments.connect(&site.shutdown)?;
    let graph = Graph {
        domain: arguments.domain,
        distribution: arguments.distro,
        session: ros.session_id()?,
        namespace: arguments.namespace.clone(),
    };
    print_line(&connected(&arguments.router, &graph.session, format))?;
    let bridge = Bridge::new(BridgeOptions {
        namespace: arguments.namespace.clone(),
        world: arguments.frame.clone(),
        max_rate_hz: arguments.max_rate,
    });
    let mut relay = Relay {
        bridge,
        publishers: Publishers::new(ros, graph, format)?,
    };
    let ended = relay.run(&site);
    print_line(&relay.summary(ended?, format))?;
    relay.publishers.close();
    site.bus.close();
    Ok(())
}

impl Ros2Arguments {
    /// Waits for the router of ROS, and says so.
    fn connect(&self, shutdown: &Shutdown) -> anyhow::Result<Bus> {
        let options = BusOptions::client_of(&self.router);
        let security = Security::none(Profile::Open);
        let (start, is_said) = (Instant::now(), Cell::new(false));
        let wait = || {
            if start.elapsed() >= HICCUP && !is_said.replace(true) {
                let why = why_no_router(&options, &security);
                eprintln!(
                    "no ROS router answers at {}{}; waiting for it. Start `ros2 run rmw_zenoh_cpp rmw_zenohd`, or name another with --router",
                    self.router,
                    why.map_or_else(String::new, |why| format!(" ({why})"))
                );
            }
            shutdown.is_requested()
        };
        match Bus::open_unless(&options, &security, &wait) {
            Err(BusError::Abandoned { .. }) => {
                let cause = anyhow::anyhow!("interrupted while waiting for a ROS router");
                Err(Failure::new(Exit::Interrupted, cause).into())
            }
            opened => opened
                .with_context(|| format!("--router {}", self.router))
                .exit_with(Exit::Input),
        }
    }
}

/// Messages of the site on their way.
struct Relay {
    bridge: Bridge,
    publishers: Publishers,
}

impl Relay {
    /// Relays until a signal; returns how many messages of the site were dropped unread.
    fn run(&mut self, site: &Site) -> anyhow::Result<u64> {
        let everything = site.keys.everything();
        let messages =
            site.bus
                .subscribe_stream(&everything, WAITING, limits::MAX_PAYLOAD_BYTES)?;
        let (mut router, mut is_new) = (RouterWatch::default(), true);
        let mut diagnostics_due = Instant::now();
        while !site.shutdown.is_requested() {
            if is_new && site.bus.is_connected() {
                self.take_configuration(site)?;
            }
            is_new = !site.bus.is_connected();
            if let Some(item) = messages.recv_timeout(GLANCE) {
                self.take(site, &item)?;
            }
            if Instant::now() >= diagnostics_due {
                diagnostics_due = Instant::now() + DIAGNOSTICS;
                self.publish_diagnostics(messages.counts().dropped)?;
                router.say(&site.bus);
                self.publishers.watch_router();
            }
        }
        Ok(messages.counts().dropped)
    }

    /// Rig and objects as the fusion nodes have them.
    fn take_configuration(&mut self, site: &Site) -> anyhow::Result<()> {
        let all = site.keys.all_config();
        let items = site.bus.latest(&all, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
        items.iter().try_for_each(|item| self.take(site, item))
    }

    fn take(&mut self, site: &Site, item: &Item) -> anyhow::Result<()> {
        let (Some(key), now) = (site.keys.parse(&item.key), now_ns()) else {
            return Ok(());
        };
        let sender = item.sender.as_deref();
        let outgoing = self.bridge.handle(now, &key, sender, item.try_bytes());
        outgoing
            .into_iter()
            .try_for_each(|message| self.publishers.put(now, message))
    }

    fn publish_diagnostics(&mut self, dropped: u64) -> anyhow::Result<()> {
        let now = now_ns();
        let counts = self.publishers.counts();
        let own = [
            ("messages published", counts.published),
            ("messages not published", counts.failed),
            ("messages of the site dropped", dropped),
        ];
        let message = self.bridge.diagnostics(now, &own);
        self.publishers.put(now, message)
    }

    fn summary(&self, dropped: u64, format: Format) -> String {
        let (ours, counts) = (self.publishers.counts(), self.bridge.counts());
        match format {
            Format::Json => json!({
                "event": "end", "published": ours.published, "failed": ours.failed, "dropped": dropped,
                "invalid": counts.invalid, "over_rate": counts.over_rate,
                "superseded": counts.superseded, "name_taken": counts.name_taken,
            })
            .to_string(),
            Format::Text => format!(
                "{} messages published, {} not; of the site's {} dropped, {} invalid, {} over the rate, {} superseded, {} without a name",
                ours.published,
                ours.failed,
                dropped,
                counts.invalid,
                counts.over_rate,
                counts.superseded,
                counts.name_taken
            ),
        }
    }
}

fn connected(router: &str, session: &str, format: Format) -> String {
    match format {
        Format::Json => {
            json!({"event": "connected", "router": router, "session": session}).to_string()
        }
        Format::Text => format!("connected to the ROS router at {router}"),
    }
}
