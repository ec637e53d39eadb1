//! `sextant osc`: poses as Open Sound Control messages, by UDP to one machine.

use crate::axes::AxesName;
use crate::output::Format;
use crate::pose_feed::{self, FeedArguments};
use crate::words;
use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use sextant_gateways::osc::OscSender;
use sextant_pose_streams::{AddressTemplate, MAX_VMT_TRACKERS, MAX_VRCHAT_TRACKERS, OscLayout};
use sextant_process::{Exit, Failure};
use sextant_site_model::ObjectId;

/// Arguments of `sextant osc`.
#[derive(Args, Debug)]
#[command(
    after_help = "plain   ADDRESS x y z qx qy qz qw: metres, a unit quaternion
vrchat /tracking/trackers/N/position x y z and /tracking/trackers/N/rotation x y z: Unity's axes, degrees; N is 1 for
the first --object.
        VRChat listens on port 9000
vmt /VMT/Room/Unity index enable 0 x y z qx qy qz qw: Unity's axes; the index of the first --object is 0. Virtual Motion
Tracker
        listens on port 39570
Objects that are tracked or coasting are sent; docs/outputs.md has more. With --json, one line at the end:
{\"poses\",\"refused\",\"dropped\",\"sent\",\"unsent\",\"unheard\",\"skipped\"}"
)]
pub struct OscArguments {
    /// The receiver.
    #[arg(long, value_name = "HOST:PORT")]
    to: String,
    /// Addresses and arguments.
    #[arg(long, value_enum, default_value_t = LayoutName::Plain)]
    layout: LayoutName,
    /// Address of the plain layout.
    #[arg(
        long,
        value_name = "TEMPLATE",
        default_value = "/sextant/{object}/pose"
    )]
    address: AddressTemplate,
    /// Axes of the plain layout.
    #[arg(long, value_enum, default_value_t = AxesName::ZUp)]
    axes: AxesName,
    /// An object; may be repeated. By default all objects, in the plain layout.
    #[arg(long = "object", value_name = "ID")]
    objects: Vec<ObjectId>,
    /// Most poses a second of each object.
    #[arg(long, value_name = "HZ", default_value = "60", value_parser = pose_feed::rate)]
    rate: f64,
    #[command(flatten)]
    feed: FeedArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LayoutName {
    Plain,
    Vrchat,
    Vmt,
}

/// Runs `sextant osc`.
///
/// # Errors
/// A target that is none, no router.
pub fn run(arguments: &OscArguments, format: Format) -> anyhow::Result<()> {
    let layout = arguments.layout()?;
    let target = pose_feed::datagram_target(&arguments.to)?;
    eprintln!(
        "sending {} to {} by UDP as OSC ({}), at most {} a second; Ctrl-C ends it",
        words::poses_of(&arguments.objects),
        target.address(),
        arguments.what(),
        arguments.rate
    );
    let mut sender = OscSender::new(layout, target, arguments.rate);
    let feed = pose_feed::run(&arguments.feed, &arguments.objects, &mut sender)?;
    pose_feed::print_counts(&sender.counts(feed), format)
}

impl OscArguments {
    fn layout(&self) -> anyhow::Result<OscLayout> {
        Ok(match self.layout {
            LayoutName::Plain => OscLayout::Plain {
                address: self.plain_address()?,
                axes: self.axes.into(),
            },
            LayoutName::Vrchat => OscLayout::VrChat {
                trackers: self.trackers(MAX_VRCHAT_TRACKERS)?,
            },
            LayoutName::Vmt => OscLayout::Vmt {
                trackers: self.trackers(MAX_VMT_TRACKERS)?,
            },
        })
    }

    /// The address, which tells objects apart unless there is only one.
    fn plain_address(&self) -> anyhow::Result<AddressTemplate> {
        if self.objects.len() != 1 && !self.address.distinguishes_objects() {
            bail!(usage(
                "--address without {object} is for one object: name it with --object"
            ));
        }
        Ok(self.address.clone())
    }

    fn trackers(&self, most: usize) -> anyhow::Result<Vec<ObjectId>> {
        if self.objects.is_empty() || self.objects.len() > most {
            bail!(usage(&format!(
                "this layout numbers its trackers: name 1 to {most} objects with --object, in \
                 the order of their numbers"
            )));
        }
        Ok(self.objects.clone())
    }

    fn what(&self) -> String {
        match self.layout {
            LayoutName::Plain => self.address.to_string(),
            LayoutName::Vrchat => "VRChat trackers".to_owned(),
            LayoutName::Vmt => "Virtual Motion Tracker".to_owned(),
        }
    }
}

fn usage(cause: &str) -> Failure {
    Failure::new(Exit::Usage, anyhow!("{cause}"))
}
