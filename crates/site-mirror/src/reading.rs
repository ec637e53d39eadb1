//! A payload as the message that belongs under its key.

use crate::rejection::Rejection;
use sextant_proto::{AnyMessage, DecodeError, KeyRef};

/// Decodes a payload as the kind of its key and compares the ids.
///
/// # Errors
/// [`Rejection::Undecodable`], or [`Rejection::WrongId`] for a message that names another id than its key.
pub(crate) fn read(
    key: &KeyRef,
    payload: Result<&[u8], DecodeError>,
) -> Result<AnyMessage, Rejection> {
    // Tokens have no payload: one under their key is nothing of ours.
    let kind = key.kind().ok_or(DecodeError::BadMagic)?;
    let message = AnyMessage::decode_as(kind, payload?)?;
    match belongs(&message, key) {
        true => Ok(message),
        false => Err(Rejection::WrongId),
    }
}

fn belongs(message: &AnyMessage, key: &KeyRef) -> bool {
    use AnyMessage as M;
    match (key, message) {
        (KeyRef::Observations(id), M::Observations(message)) => message.camera == *id,
        (KeyRef::Preview(id), M::Preview(message)) => message.camera == *id,
        (KeyRef::DetectionReport(id), M::DetectionReport(message)) => message.camera == *id,
        (KeyRef::CameraStatus(id), M::CameraStatus(message)) => message.camera == *id,
        (KeyRef::ConfigCamera(id), M::CameraSettings(message)) => message.camera == *id,
        (KeyRef::Pose(id), M::ObjectPose(message)) => message.object == *id,
        (KeyRef::Truth(id), M::ObjectTruth(message)) => message.object == *id,
        (KeyRef::Links(id), M::ObjectLinks(message)) => message.object == *id,
        (KeyRef::ConfigObject(id), M::ObjectConfig(message)) => message.id == *id,
        (KeyRef::FormerObject(_, id), M::ObjectConfig(message)) => message.id == *id,
        (KeyRef::FusionStatus(id), M::FusionStatus(message)) => message.node == *id,
        (KeyRef::Clocks(id), M::ClockReport(message)) => message.node == *id,
        (KeyRef::Inputs(id), M::FusionInputs(message)) => message.node == *id,
        (KeyRef::Heartbeat(id), M::Heartbeat(message)) => message.node == *id,
        (KeyRef::ConfigAnswer(id), M::ConfigAnswer(message)) => message.node == *id,
        (KeyRef::Proposal(id) | KeyRef::Former(id), M::Proposal(message)) => message.node == *id,
        (KeyRef::ConfigModels, M::Proposal(_)) => true,
        (KeyRef::ConfigRig | KeyRef::FormerRig(_), M::RigConfig(_)) => true,
        _ => false,
    }
}
