//! Decodes a payload of any kind, for tools that subscribe to everything.

use crate::envelope::{DecodeError, Kind, decode, open};
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
        Self::decode_as(Kind::from_byte(kind).ok_or(DecodeError::Damaged)?, payload)
    }

    /// The message of a payload of this kind.
    ///
    /// # Errors
    /// As [`decode`].
    pub fn decode_as(kind: Kind, payload: &[u8]) -> Result<Self, DecodeError> {
        Ok(match kind {
            Kind::Observations => Self::Observations(decode(payload)?),
            Kind::Preview => Self::Preview(decode(payload)?),
            Kind::CameraStatus => Self::CameraStatus(decode(payload)?),
            Kind::ObjectPose => Self::ObjectPose(Box::new(decode(payload)?)),
            Kind::ObjectTruth => Self::ObjectTruth(decode(payload)?),
            Kind::FusionStatus => Self::FusionStatus(decode(payload)?),
            Kind::RigConfig => Self::RigConfig(decode(payload)?),
            Kind::ObjectConfig => Self::ObjectConfig(decode(payload)?),
            Kind::ObjectLinks => Self::ObjectLinks(decode(payload)?),
            Kind::ClockReport => Self::ClockReport(decode(payload)?),
            Kind::ConfigAnswer => Self::ConfigAnswer(decode(payload)?),
            Kind::DetectionReport => Self::DetectionReport(decode(payload)?),
            Kind::Proposal => Self::Proposal(decode(payload)?),
            Kind::FusionInputs => Self::FusionInputs(decode(payload)?),
            Kind::CameraSettings => Self::CameraSettings(decode(payload)?),
            Kind::Heartbeat => Self::Heartbeat(decode(payload)?),
        })
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Observations(_) => Kind::Observations,
            Self::Preview(_) => Kind::Preview,
            Self::CameraStatus(_) => Kind::CameraStatus,
            Self::ObjectPose(_) => Kind::ObjectPose,
            Self::ObjectTruth(_) => Kind::ObjectTruth,
            Self::FusionStatus(_) => Kind::FusionStatus,
            Self::RigConfig(_) => Kind::RigConfig,
            Self::ObjectConfig(_) => Kind::ObjectConfig,
            Self::ObjectLinks(_) => Kind::ObjectLinks,
            Self::ClockReport(_) => Kind::ClockReport,
            Self::ConfigAnswer(_) => Kind::ConfigAnswer,
            Self::DetectionReport(_) => Kind::DetectionReport,
            Self::Proposal(_) => Kind::Proposal,
            Self::FusionInputs(_) => Kind::FusionInputs,
            Self::CameraSettings(_) => Kind::CameraSettings,
            Self::Heartbeat(_) => Kind::Heartbeat,
        }
    }
}
