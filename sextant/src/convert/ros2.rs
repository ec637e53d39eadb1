//! A recording as a bag of ROS 2: what `sextant ros2` would have published, and the recorded images.

use crate::output::{Format, print_line};
use crate::simulate::make_empty;
use crate::words;
use anyhow::{Context, anyhow};
use serde_json::{Map, json};
use sextant_process::{Exit, Failure, WithExit};
use sextant_proto::Keys;
use sextant_recordings::compressed_image;
use sextant_recordings::mcap::WIRE_ENCODING;
use sextant_recordings::mcap::reader::{Ending, McapReader, RecordedMessage};
use sextant_recordings::mcap::ros2_bag::Ros2Bag;
use sextant_ros2::{Bridge, BridgeOptions, Outgoing, Topic};
use std::fs;
use std::path::Path;

/// Period of `/diagnostics`, of the recording's time.
const DIAGNOSTICS_NS: u64 = 1_000_000_000;

/// Writes the bag `to`, a new folder.
///
/// # Errors
/// [`Exit::Usage`] for what is no recording in one file or no folder, [`Exit::Input`] for one that cannot be used and a
/// place that is taken.
pub fn run(from: &Path, to: &Path, format: Format) -> anyhow::Result<()> {
    let [recording, bag] = [from, to].map(|path| path.display());
    if from.is_dir() {
        let cause = anyhow!(
            "{recording} is a folder; write an MCAP file first: sextant convert {recording} site.mcap --rig rig.toml"
        );
        return Err(Failure::new(Exit::Usage, cause).into());
    }
    if to.extension().is_some_and(|ending| ending == "mcap") {
        let cause = anyhow!("{bag}: a bag of ROS 2 is a folder; give a name without .mcap");
        return Err(Failure::new(Exit::Usage, cause).into());
    }
    let mut reader = McapReader::open(from).exit_with(Exit::Input)?;
    // Before the folder is made, so that an invalid file leaves none behind.
    let mut next = reader.next_message().exit_with(Exit::Input)?;
    let info = reader.info().ok_or_else(|| reader.emptiness());
    let site = info.exit_with(Exit::Input)?.site.clone();
    let mut conversion = Conversion::new(&site)?;
    make_empty(to).exit_with(Exit::Input)?;
    let mut write = || {
        let mut writer = Ros2Bag::begin(to, env!("CARGO_PKG_VERSION"))?;
        while let Some(message) = next.take() {
            for outgoing in conversion.messages(&message) {
                writer.write(&outgoing, message.arrival_ns)?;
            }
            next = reader.next_message()?;
        }
        writer.finish()
    };
    let topics = write().inspect_err(|_| {
        // Half a bag would be in the way of the next try.
        let _ = fs::remove_dir_all(to);
    })?;
    if let Some(ending) = reader.ending().filter(|ending| **ending != Ending::Closed) {
        eprintln!("{recording}: {ending}");
    }
    let left_out = conversion.left_out();
    let line = summary(to, &topics, left_out, format);
    Ok(print_line(&line)?)
}

/// The line that ends the conversion; in text, what was left out is on standard error.
fn summary(
    to: &Path,
    topics: &[(Topic, u32)],
    left_out: [(&'static str, u64); 4],
    format: Format,
) -> String {
    let bag = to.display();
    let total: u32 = topics.iter().map(|(_, messages)| messages).sum();
    match format {
        Format::Json => {
            let topics = topics.iter();
            let topics: Map<_, _> = topics
                .map(|(topic, messages)| (topic.name.clone(), (*messages).into()))
                .collect();
            let left_out = Map::from_iter(left_out.map(|(why, n)| (why.to_owned(), n.into())));
            json!({ "to": to, "messages": total, "topics": topics, "left_out": left_out })
                .to_string()
        }
        Format::Text => {
            for (why, n) in left_out.into_iter().filter(|(_, n)| *n > 0) {
                let n = words::count(n as usize, "message");
                eprintln!("{bag}: without {n}: {}", why.replace('_', " "));
            }
            format!(
                "{bag}: {} on {}",
                words::count(total as usize, "message"),
                words::count(topics.len(), "topic")
            )
        }
    }
}

struct Conversion {
    keys: Keys,
    bridge: Bridge,
    /// When `/diagnostics` was written last.
    diagnosed_ns: Option<u64>,
    /// Images that are no pictures.
    damaged_images: u64,
}

impl Conversion {
    fn new(site: &str) -> anyhow::Result<Self> {
        let options = BridgeOptions {
            namespace: "sextant".parse()?,
            world: "world".to_owned(),
            max_rate_hz: None,
            also: Vec::new(),
        };
        let keys = Keys::new(site).with_context(|| format!("the recording's site {site:?}"));
        Ok(Self {
            keys: keys.exit_with(Exit::Input)?,
            bridge: Bridge::new(options),
            diagnosed_ns: None,
            damaged_images: 0,
        })
    }

    /// What becomes of a recorded message.
    fn messages(&mut self, message: &RecordedMessage) -> Vec<Outgoing> {
        let (topic, now_ns) = (&message.channel.topic, message.arrival_ns);
        let mut outgoing = match &*message.channel.encoding {
            WIRE_ENCODING => self
                .keys
                .parse(topic)
                .map(|key| self.bridge.handle(now_ns, &key, None, Ok(&message.data))),
            sextant_ros2::MESSAGE_ENCODING => self.image(topic, &message.data),
            _ => None,
        };
        let is_recent = |last_ns: u64| now_ns.abs_diff(last_ns) < DIAGNOSTICS_NS;
        if !self.diagnosed_ns.is_some_and(is_recent) {
            self.diagnosed_ns = Some(now_ns);
            let state = self.bridge.diagnostics(now_ns, &[]);
            outgoing.get_or_insert_default().push(state);
        }
        outgoing.unwrap_or_default()
    }

    fn image(&mut self, topic: &str, message: &[u8]) -> Option<Vec<Outgoing>> {
        let camera = compressed_image::camera_of(topic)?;
        let Some(image) = compressed_image::decode(&camera, message) else {
            self.damaged_images += 1;
            return None;
        };
        Some(
            self.bridge
                .image(&camera, image.capture_ns, "png", image.png),
        )
    }

    /// Messages that the bag lacks, by cause.
    fn left_out(&self) -> [(&'static str, u64); 4] {
        let counts = self.bridge.counts();
        [
            ("damaged_images", self.damaged_images),
            ("invalid", counts.invalid),
            ("not_newer_than_the_one_before", counts.superseded),
            ("name_taken", counts.name_taken),
        ]
    }
}
