//! `sextant natnet`: each object as a rigid body of a NatNet server, as Motive is one.

use crate::axes::AxesName;
use crate::listening::bind_unprotected;
use crate::output::{Format, print_line};
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use anyhow::{anyhow, bail};
use clap::Args;
use sextant_gateways::natnet::{BodyOptions, BodyServer, BodyServerCounts};
use sextant_pose_streams::{NATNET_COMMAND_PORT, NATNET_DATA_PORT, NatNetServer, NatNetVersion};
use sextant_process::{Exit, Failure};
use sextant_site_model::ObjectId;
use std::net::SocketAddrV4;

/// Arguments of `sextant natnet`.
#[derive(Args, Debug)]
#[command(
    after_help = "Each object is a rigid body of its name; its streaming id is 1 for the first --object, or by name
where none is named. The centres of its tags are its markers. Frames go to the multicast group, and to every client that
asks for them by unicast. A body is marked as tracked where its pose is new and not a prediction; its mean error is the
standard deviation of its position in metres; times are nanoseconds since the Unix epoch. NatNet has no passwords: every
client that reaches the address can read the poses. --listen with an address of this machine lets other machines
connect, and sends to the group on that network. docs/outputs.md has the settings of clients. With --json, one line at
the end: {\"poses\",\"refused\",\"dropped\",\"frames\",\"sent\",\"unsent\",\"clients\",\"turned_away\",
\"unrecognized\"}"
)]
pub struct NatNetArguments {
    /// Address of the server; its port is the command port.
    #[arg(long, value_name = "HOST[:PORT]", default_value_t = format!("127.0.0.1:{NATNET_COMMAND_PORT}"))]
    listen: String,
    /// Multicast group of the frames and the data port.
    #[arg(
        long,
        value_name = "GROUP:PORT",
        default_value_t = SocketAddrV4::new([239, 255, 42, 99].into(), NATNET_DATA_PORT),
        value_parser = group
    )]
    multicast: SocketAddrV4,
    /// Send only to clients that ask for frames by unicast.
    #[arg(long, conflicts_with = "multicast")]
    unicast: bool,
    /// Version of the protocol: 3.0, 3.1 or 4.1. A unicast client may choose another one for itself.
    #[arg(long, value_name = "VERSION", default_value_t = NatNetVersion::NEWEST)]
    protocol: NatNetVersion,
    /// Axes of positions and quaternions: z-up or y-up, as in Motive's streaming settings.
    #[arg(long, value_enum, default_value_t = AxesName::ZUp)]
    axes: AxesName,
    /// An object; may be repeated. By default all objects.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most frames a second.
    #[arg(long, value_name = "HZ", default_value = "120", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

fn group(text: &str) -> Result<SocketAddrV4, &'static str> {
    match text.parse::<SocketAddrV4>() {
        Ok(group) if group.ip().is_multicast() && group.port() != 0 => Ok(group),
        _ => Err("write a multicast group and a port, such as 239.255.42.99:1511"),
    }
}

/// Runs `sextant natnet`.
///
/// # Errors
/// An address that is invalid or in use, no router.
pub fn run(arguments: &NatNetArguments, format: Format) -> anyhow::Result<()> {
    if arguments.axes == AxesName::Unity {
        bail!(usage(
            "--axes unity: the axes of NatNet are right-handed, and OptiTrack's plugin for Unity \
             turns them itself; use y-up"
        ));
    }
    let (address, site) = (&arguments.listen, &arguments.feed.site);
    let socket = bind_unprotected(address, NATNET_COMMAND_PORT, "NatNet", site)?;
    let address = socket.local_addr()?;
    let group = (!arguments.unicast).then_some(arguments.multicast);
    let options = BodyOptions {
        server: NatNetServer {
            axes: arguments.axes.into(),
            rate_hz: arguments.rate,
            multicast: group,
            data_port: arguments.multicast.port(),
        },
        version: arguments.protocol,
        objects: arguments.objects.clone(),
    };
    eprintln!(
        "serving {} as NatNet {} rigid bodies at {address}, {}, at most {} frames a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        arguments.protocol,
        group.map_or_else(
            || "by unicast".to_owned(),
            |group| format!("frames to {group}")
        ),
        arguments.rate
    );
    let mut bodies = BodyServer::start(socket, options, pose_feed::reporter())?;
    let feed = pose_feed::run(&arguments.feed, &arguments.objects, &mut bodies)?;
    print_counts(&bodies.counts(feed), format)
}

fn usage(cause: &str) -> Failure {
    Failure::new(Exit::Usage, anyhow!("{cause}"))
}

fn print_counts(counts: &BodyServerCounts, format: Format) -> anyhow::Result<()> {
    let (feed, server) = (counts.feed, counts.server);
    match format {
        Format::Json => print_line(&serde_json::to_string(counts)?)?,
        Format::Text => eprintln!(
            "{} from {}, {} sent; {} dropped, {} refused; {} by unicast, {} turned away, {} not recognised; {} unsent",
            words::count(server.frames as usize, "frame"),
            words::count(feed.poses as usize, "pose"),
            words::count(server.sent as usize, "datagram"),
            feed.dropped,
            feed.refused,
            words::count(server.clients as usize, "client"),
            server.turned_away,
            words::count(server.unrecognized as usize, "request"),
            server.unsent
        ),
    }
    Ok(())
}
