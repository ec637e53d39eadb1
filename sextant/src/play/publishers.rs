//! Recorded messages on the network, as the nodes published them.

use super::previews::{PreviewOutcome, Previews};
use sextant_proto::{ANNOUNCED, AnyMessage, KeyRef, Keys, ObjectConfig, RigConfig};
use sextant_recordings::compressed_image as image;
use sextant_recordings::mcap::WIRE_ENCODING;
use sextant_recordings::mcap::reader::RecordedMessage;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, Latest, Qos, RawPublisher};
use std::collections::BTreeMap;

/// Most keys.
const MAX_KEYS: usize = 8192;
/// Who announces the models.
const PLAYER: &str = "recording";

/// A publisher for each key that has come.
pub struct Publishers<'a> {
    bus: &'a Bus,
    keys: Keys,
    by_key: BTreeMap<String, Publisher>,
    previews: Previews<'a>,
    /// Messages published.
    pub published: u64,
    /// Payloads that are no messages of this version or do not belong under their key, and invalid images.
    pub skipped: u64,
}

enum Publisher {
    Passing(RawPublisher),
    /// Rig and objects are kept for later subscribers.
    Rig(Latest<RigConfig>),
    Object(Latest<ObjectConfig>),
}

impl<'a> Publishers<'a> {
    pub fn new(bus: &'a Bus, keys: Keys) -> Self {
        Self {
            bus,
            previews: Previews::new(bus, keys.clone()),
            keys,
            by_key: BTreeMap::new(),
            published: 0,
            skipped: 0,
        }
    }

    /// Publishes a payload under its key, and an image as a preview. The rest of a recording is for viewers of files.
    ///
    /// # Errors
    /// What the network refuses.
    pub fn put(&mut self, message: &RecordedMessage) -> anyhow::Result<()> {
        let topic = &message.channel.topic;
        match message.channel.encoding.as_str() {
            WIRE_ENCODING => self.put_payload(topic, &message.data),
            sextant_ros2::MESSAGE_ENCODING => match image::camera_of(topic) {
                Some(camera) => self.put_image(&camera, &message.data),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn put_image(&mut self, camera: &CameraId, message: &[u8]) -> anyhow::Result<()> {
        match self.previews.put(camera, message)? {
            PreviewOutcome::Published => self.published += 1,
            PreviewOutcome::Omitted => {}
            PreviewOutcome::Invalid => self.skipped += 1,
        }
        Ok(())
    }

    fn put_payload(&mut self, key: &str, payload: &[u8]) -> anyhow::Result<()> {
        let meaning = self.keys.parse(key);
        let message = AnyMessage::decode(payload).ok();
        let (Some(meaning), Some(message)) = (meaning, message) else {
            return self.skip();
        };
        let is_new = !self.by_key.contains_key(key);
        let is_full = is_new && self.by_key.len() >= MAX_KEYS;
        if meaning.kind() != Some(message.kind()) || is_full {
            return self.skip();
        }
        if is_new {
            let publisher = self.publisher(key, &meaning)?;
            self.by_key.insert(key.to_owned(), publisher);
        }
        match (self.by_key.get(key), &message) {
            (Some(Publisher::Passing(publisher)), _) => publisher.put(payload)?,
            (Some(Publisher::Rig(publisher)), AnyMessage::RigConfig(rig)) => publisher.put(rig)?,
            (Some(Publisher::Object(publisher)), AnyMessage::ObjectConfig(object)) => {
                publisher.put(object)?;
            }
            _ => return self.skip(),
        }
        self.published += 1;
        Ok(())
    }

    fn skip(&mut self) -> anyhow::Result<()> {
        self.skipped += 1;
        Ok(())
    }

    fn publisher(&self, key: &str, meaning: &KeyRef) -> anyhow::Result<Publisher> {
        let sender = format!("{ANNOUNCED}{PLAYER}");
        let qos = match meaning {
            KeyRef::ConfigRig => {
                let rig = self.bus.latest_publisher(key, Qos::Config)?;
                return Ok(Publisher::Rig(rig.signed(&sender)));
            }
            KeyRef::ConfigObject(_) => {
                let object = self.bus.latest_publisher(key, Qos::Config)?;
                return Ok(Publisher::Object(object.signed(&sender)));
            }
            KeyRef::Observations(_) => Qos::Observation,
            KeyRef::Pose(_) | KeyRef::Links(_) | KeyRef::Truth(_) => Qos::Pose,
            KeyRef::Preview(_) => Qos::Preview,
            _ => Qos::Status,
        };
        Ok(Publisher::Passing(self.bus.raw_publisher(key, qos)?))
    }
}
