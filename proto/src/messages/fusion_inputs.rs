//! What a fusion node's estimator took in, in order and with its times: a recording with these and the observations
//! gives the same poses.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::ids::NodeId;
use crate::limits::{MAX_INPUTS, MAX_OBJECTS};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// Consecutive inputs of a fusion node's estimator. The first two of a run are the rig and the objects before its first
/// image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FusionInputs {
    /// The node, equal to that of the key.
    pub node: NodeId,
    /// Number of the first of these inputs since the node started, from 0; a gap is a lost message.
    pub first: u64,
    /// The inputs, in the order in which they were processed.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_INPUTS>")]
    pub inputs: Vec<FusionInput>,
}

/// One input of the estimator, with its time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FusionInput {
    /// The time that the estimator was given, ns since the Unix epoch by the node's clock.
    pub now_ns: u64,
    /// What was taken in.
    pub source: InputSource,
}

/// What was taken in. On the wire the number of the variant, from 0.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InputSource {
    /// An image: which of its camera's observations.
    Image {
        /// As in its observations.
        camera: CameraId,
        /// As in its observations.
        sequence: u64,
        /// As in its observations.
        capture_ns: u64,
    },
    /// A rig: [`crate::fingerprint`] of its announcement.
    Rig(u64),
    /// All objects, in the estimator's order: [`crate::fingerprint`]s of their announcements.
    Objects(#[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_OBJECTS>")] Vec<u64>),
    /// The node's clock was set: the time is by the new one.
    ClockStep,
    /// Nothing: time has passed.
    Tick,
    /// The adjustment of the files that was due: it applies from here on.
    Adjusted,
}

impl Message for FusionInputs {
    const KIND: MessageKind = MessageKind::FusionInputs;

    fn check(&self) -> Result<(), OutOfRange> {
        holds(self.inputs.len() <= MAX_INPUTS, "inputs")?;
        self.inputs.iter().try_for_each(FusionInput::check)
    }
}

impl FusionInput {
    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.now_ns, "inputs[].now_ns")?;
        match &self.source {
            InputSource::Image { capture_ns, .. } => check::time(*capture_ns, "inputs[].source"),
            InputSource::Objects(objects) => holds(objects.len() <= MAX_OBJECTS, "inputs[].source"),
            InputSource::Rig(_)
            | InputSource::ClockStep
            | InputSource::Tick
            | InputSource::Adjusted => Ok(()),
        }
    }
}
