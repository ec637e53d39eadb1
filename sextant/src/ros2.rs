//! `sextant ros2`: a site's poses, detections, lenses and pictures as ROS 2 topics, by the protocol of rmw_zenoh.

use crate::output::{Format, print_line};
use crate::pose_feed::reporter;
use crate::site::SiteArguments;
use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::json;
use sextant_gateways::ros2::{self, Ros2Counts};
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use sextant_ros2::{Also, BridgeOptions, Distribution, Graph, Namespace, Topic};
use sextant_zenoh_bus::{Bus, BusError};

/// Arguments of `sextant ros2`.
#[derive(Args, Debug)]
#[command(after_help = "Topics, with the default namespace:
  /tf, /tf_static                            tf2_msgs/TFMessage: objects and links; cameras and tags
  /sextant/object/ID/pose                    geometry_msgs/PoseWithCovarianceStamped
  /sextant/object/ID/quality                 std_msgs/Float64MultiArray: expected errors, for plots
  /sextant/camera/ID/detections              apriltag_msgs/AprilTagDetectionArray
  /sextant/camera/ID/camera_info             sensor_msgs/CameraInfo, for late subscribers too
  /sextant/camera/ID/preview/image/compressed, .../preview/camera_info
  /diagnostics                               diagnostic_msgs/DiagnosticArray

ROS 2 must use rmw_zenoh_cpp (RMW_IMPLEMENTATION), with its router running. See docs/ros2.md.
With --json, one line per event: {\"event\":\"connected\",\"router\",\"session\"},
{\"event\":\"topic\",\"name\",\"type\"}, and at the end {\"event\":\"end\",\"published\",\"failed\",\"dropped\",
\"invalid\",\"over_rate\",\"superseded\",\"name_taken\"}. Stop with Ctrl-C.")]
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
    /// Also publish poses as these messages; may be repeated.
    #[arg(long, value_enum, value_name = "MESSAGES")]
    also: Vec<AlsoName>,
    #[command(flatten)]
    site: SiteArguments,
}

/// Value of `--also`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AlsoName {
    /// nav_msgs/Odometry on /sextant/object/ID/odom.
    Odometry,
    /// motion_capture_tracking_interfaces/NamedPoseArray on /poses: Crazyswarm2.
    NamedPoses,
    /// mocap4r2_msgs/RigidBodies on /rigid_bodies: MOCAP4ROS2.
    RigidBodies,
}

impl From<AlsoName> for Also {
    fn from(name: AlsoName) -> Self {
        match name {
            AlsoName::Odometry => Self::Odometry,
            AlsoName::NamedPoses => Self::NamedPoses,
            AlsoName::RigidBodies => Self::RigidBodies,
        }
    }
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
    let options = BridgeOptions {
        namespace: arguments.namespace.clone(),
        world: arguments.frame.clone(),
        max_rate_hz: arguments.max_rate,
        also: arguments.also.iter().copied().map(Also::from).collect(),
    };
    let mut on_topic = |topic: &Topic| print_line(&declared(topic, format));
    let counts = ros2::run(site, ros, graph, options, &mut on_topic, &reporter())?;
    print_line(&summary(&counts, format))?;
    Ok(())
}

impl Ros2Arguments {
    /// Waits for the router of ROS, and says so.
    fn connect(&self, shutdown: &Shutdown) -> anyhow::Result<Bus> {
        match ros2::connect(&self.router, shutdown, &reporter()) {
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

fn connected(router: &str, session: &str, format: Format) -> String {
    match format {
        Format::Json => {
            json!({"event": "connected", "router": router, "session": session}).to_string()
        }
        Format::Text => format!("connected to the ROS router at {router}"),
    }
}

fn declared(topic: &Topic, format: Format) -> String {
    let (name, kind) = (&topic.name, topic.kind.type_name());
    match format {
        Format::Json => json!({"event": "topic", "name": name, "type": kind}).to_string(),
        Format::Text => format!("{name} ({kind})"),
    }
}

fn summary(counts: &Ros2Counts, format: Format) -> String {
    match format {
        Format::Json => json!({
            "event": "end", "published": counts.published, "failed": counts.failed, "dropped": counts.dropped,
            "invalid": counts.invalid, "over_rate": counts.over_rate,
            "superseded": counts.superseded, "name_taken": counts.name_taken,
        })
        .to_string(),
        Format::Text => format!(
            "{} messages published, {} not; of the site's {} dropped, {} invalid, {} over the \
             rate, {} superseded, {} without a name",
            counts.published,
            counts.failed,
            counts.dropped,
            counts.invalid,
            counts.over_rate,
            counts.superseded,
            counts.name_taken
        ),
    }
}
