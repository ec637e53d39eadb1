//! Decodes a payload of any kind, for tools that subscribe to everything.

use crate::envelope::{DecodeError, MessageKind, decode, open};
use crate::limits::MAX_PAYLOAD_BYTES;
use crate::messages::camera_settings::CameraSettings;
use crate::messages::camera_status::CameraStatus;
use crate::messages::clock_report::ClockReport;
use crate::messages::config_answer::ConfigAnswer;
use crate::messages::detection_report::DetectionReport;
use crate::messages::fusion_inputs::FusionInputs;
use crate::messages::fusion_status::FusionStatus;
use crate::messages::heartbeat::Heartbeat;
use crate::messages::object_config::ObjectConfig;
use crate::messages::object_links::ObjectLinks;
use crate::messages::object_pose::{ObjectPose, ObjectTruth};
use crate::messages::observations::Observations;
use crate::messages::preview::Preview;
use crate::messages::proposal::Proposal;
use crate::messages::rig_config::RigConfig;
use serde::Serialize;

/// One message of any kind; serialises as the message alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
#[allow(missing_docs, reason = "each variant is the message of its name")]
pub enum AnyMessage {
    Observations(Observations),
    Preview(Preview),
    CameraStatus(CameraStatus),
    ObjectPose(Box<ObjectPose>),
    ObjectTruth(ObjectTruth),
    FusionStatus(FusionStatus),
    RigConfig(RigConfig),
    ObjectConfig(ObjectConfig),
    ObjectLinks(ObjectLinks),
    ClockReport(ClockReport),
    ConfigAnswer(ConfigAnswer),
    DetectionReport(DetectionReport),
    Proposal(Proposal),
    FusionInputs(FusionInputs),
    CameraSettings(CameraSettings),
    Heartbeat(Heartbeat),
}

impl AnyMessage {
    /// The message of a payload, by the kind in its header.
    ///
    /// # Errors
    /// As [`decode`]; a kind of no number known here is [`DecodeError::Damaged`].
    pub fn decode(payload: &[u8]) -> Result<Self, DecodeError> {
        if payload.len() > MAX_PAYLOAD_BYTES {
            return Err(DecodeError::TooLong(payload.len()));
        }
        let (kind, _) = open(payload)?;
        Self::decode_as(
            MessageKind::from_byte(kind).ok_or(DecodeError::Damaged)?,
            payload,
        )
    }

    /// The message of a payload of this kind.
    ///
    /// # Errors
    /// As [`decode`].
    pub fn decode_as(kind: MessageKind, payload: &[u8]) -> Result<Self, DecodeError> {
        Ok(match kind {
            MessageKind::Observations => Self::Observations(decode(payload)?),
            MessageKind::Preview => Self::Preview(decode(payload)?),
            MessageKind::CameraStatus => Self::CameraStatus(decode(payload)?),
            MessageKind::ObjectPose => Self::ObjectPose(Box::new(decode(payload)?)),
            MessageKind::ObjectTruth => Self::ObjectTruth(decode(payload)?),
            MessageKind::FusionStatus => Self::FusionStatus(decode(payload)?),
            MessageKind::RigConfig => Self::RigConfig(decode(payload)?),
            MessageKind::ObjectConfig => Self::ObjectConfig(decode(payload)?),
            MessageKind::ObjectLinks => Self::ObjectLinks(decode(payload)?),
            MessageKind::ClockReport => Self::ClockReport(decode(payload)?),
            MessageKind::ConfigAnswer => Self::ConfigAnswer(decode(payload)?),
            MessageKind::DetectionReport => Self::DetectionReport(decode(payload)?),
            MessageKind::Proposal => Self::Proposal(decode(payload)?),
            MessageKind::FusionInputs => Self::FusionInputs(decode(payload)?),
            MessageKind::CameraSettings => Self::CameraSettings(decode(payload)?),
            MessageKind::Heartbeat => Self::Heartbeat(decode(payload)?),
        })
    }

    /// The kind of message that this is.
    #[must_use]
    pub fn kind(&self) -> MessageKind {
        match self {
            Self::Observations(_) => MessageKind::Observations,
            Self::Preview(_) => MessageKind::Preview,
            Self::CameraStatus(_) => MessageKind::CameraStatus,
            Self::ObjectPose(_) => MessageKind::ObjectPose,
            Self::ObjectTruth(_) => MessageKind::ObjectTruth,
            Self::FusionStatus(_) => MessageKind::FusionStatus,
            Self::RigConfig(_) => MessageKind::RigConfig,
            Self::ObjectConfig(_) => MessageKind::ObjectConfig,
            Self::ObjectLinks(_) => MessageKind::ObjectLinks,
            Self::ClockReport(_) => MessageKind::ClockReport,
            Self::ConfigAnswer(_) => MessageKind::ConfigAnswer,
            Self::DetectionReport(_) => MessageKind::DetectionReport,
            Self::Proposal(_) => MessageKind::Proposal,
            Self::FusionInputs(_) => MessageKind::FusionInputs,
            Self::CameraSettings(_) => MessageKind::CameraSettings,
            Self::Heartbeat(_) => MessageKind::Heartbeat,
        }
    }
}
