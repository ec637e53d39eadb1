//! A recording of a site in memory, apart from its images: observations, models, the fusion node's inputs, and poses.

use super::reader::{Ending, McapReader, RecordedMessage};
use super::{RecordingInfo, WIRE_ENCODING};
use crate::compressed_image as image;
use crate::error::RecordingError;
use sextant_proto::{
    AnyMessage, FusionInputs, KeyRef, Keys, NodeId, ObjectConfig, ObjectPose, ObjectTruth,
    Observations, RigConfig, fingerprint,
};
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::path::Path;

/// What a recording holds, each list in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct SiteRecording {
    /// What it says about itself.
    pub info: RecordingInfo,
    /// How it ends.
    pub ending: Ending,
    /// Every image's observations.
    pub observations: Vec<Timed<Observations>>,
    /// Models as fusion nodes announced them.
    pub models: Vec<Timed<RecordedModel>>,
    /// Inputs by fusion node.
    pub inputs: BTreeMap<NodeId, Vec<FusionInputs>>,
    /// Published poses.
    pub poses: Vec<ObjectPose>,
    /// Simulated truth.
    pub truths: Vec<ObjectTruth>,
    /// Images by camera.
    pub images: BTreeMap<CameraId, u64>,
    /// Wire payloads that are no messages of this version, or do not belong under their key.
    pub rejected: u64,
    /// Of these, rigs and objects.
    pub rejected_models: u64,
}

/// Something with its arrival.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed<T> {
    /// Arrival at the recorder, ns since the Unix epoch.
    pub arrival_ns: u64,
    /// What arrived.
    pub item: T,
}

/// A model with the fingerprint by which inputs refer to it.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedModel {
    /// Of its payload.
    pub fingerprint: u64,
    /// The model.
    pub model: Model,
}

/// A rig or an object.
#[derive(Debug, Clone, PartialEq)]
pub enum Model {
    /// The cameras.
    Rig(RigConfig),
    /// One object, or its removal.
    Object(ObjectConfig),
}

impl SiteRecording {
    /// Reads a file, images apart.
    ///
    /// # Errors
    /// A file that cannot be read or is no recording of a site.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = McapReader::open(path)?;
        let mut recording = Self {
            info: RecordingInfo::default(),
            ending: Ending::Closed,
            observations: Vec::new(),
            models: Vec::new(),
            inputs: BTreeMap::new(),
            poses: Vec::new(),
            truths: Vec::new(),
            images: BTreeMap::new(),
            rejected: 0,
            rejected_models: 0,
        };
        while let Some(message) = reader.next_message()? {
            recording.take(&message);
        }
        recording.ending = reader.ending().cloned().unwrap_or(Ending::Closed);
        recording.info = reader.info().ok_or_else(|| reader.emptiness())?.clone();
        Ok(recording)
    }

    fn take(&mut self, message: &RecordedMessage) {
        let topic = &message.channel.topic;
        if message.channel.encoding == WIRE_ENCODING {
            let taken = self.take_payload(topic, &message.data, message.arrival_ns);
            self.rejected += u64::from(taken.is_none());
            let is_model = || parse(topic).is_some_and(|key| key.is_config());
            self.rejected_models += u64::from(taken.is_none() && is_model());
        } else if message.channel.encoding == sextant_ros2::MESSAGE_ENCODING
            && let Some(camera) = image::camera_of(topic)
        {
            *self.images.entry(camera).or_default() += 1;
        }
    }

    /// `None` for a payload that is not what its key promises.
    fn take_payload(&mut self, key: &str, payload: &[u8], arrival_ns: u64) -> Option<()> {
        let message = AnyMessage::decode(payload).ok()?;
        let key = parse(key).filter(|key| key.kind() == Some(message.kind()))?;
        let model = |model| Timed {
            arrival_ns,
            item: RecordedModel {
                fingerprint: fingerprint(payload),
                model,
            },
        };
        match (key, message) {
            (KeyRef::Observations(camera), AnyMessage::Observations(item)) => {
                (item.camera == camera).then_some(())?;
                self.observations.push(Timed { arrival_ns, item });
            }
            (KeyRef::ConfigRig, AnyMessage::RigConfig(rig)) => {
                self.models.push(model(Model::Rig(rig)));
            }
            (KeyRef::ConfigObject(id), AnyMessage::ObjectConfig(object)) => {
                (object.id == id).then_some(())?;
                self.models.push(model(Model::Object(object)));
            }
            (KeyRef::Inputs(node), AnyMessage::FusionInputs(inputs)) => {
                (inputs.node == node).then_some(())?;
                self.inputs.entry(node).or_default().push(inputs);
            }
            (KeyRef::Pose(object), AnyMessage::ObjectPose(pose)) => {
                (pose.object == object).then_some(())?;
                self.poses.push(*pose);
            }
            (KeyRef::Truth(object), AnyMessage::ObjectTruth(truth)) => {
                (truth.object == object).then_some(())?;
                self.truths.push(truth);
            }
            _ => {}
        }
        Some(())
    }
}

/// The meaning of a key, for any site.
fn parse(key: &str) -> Option<KeyRef> {
    let site = key.split('/').nth(2)?;
    Keys::new(site).ok()?.parse(key)
}
