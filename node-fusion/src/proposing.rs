//! A refined calibration of the estimator as a message, as changes of the site, and as a notice.

use crate::models::Change;
use sextant_estimator::{HeldBack, Proposal};
use sextant_proto::{
    EncodeError, ModelPayload, NodeId, Notice, ObjectConfig, Proposal as Message, RigConfig,
};

/// The message of a proposal made at `t_ns`; an empty one where there is none.
///
/// # Errors
/// A model that fits into no message.
pub fn message(
    proposal: Option<&Proposal>,
    node: &NodeId,
    t_ns: u64,
) -> Result<Message, EncodeError> {
    let none = Message::none(node.clone(), t_ns);
    let Some(proposal) = proposal else {
        return Ok(none);
    };
    let rig = proposal.rig.as_ref().map(RigConfig::from);
    let objects = proposal.objects.iter().map(ObjectConfig::from);
    Ok(Message {
        rig: rig.as_ref().map(ModelPayload::encode).transpose()?,
        objects: objects
            .map(|object| ModelPayload::encode(&object))
            .collect::<Result<_, _>>()?,
        n_images: u32::try_from(proposal.held_back.n_images).unwrap_or(u32::MAX),
        before_px: proposal.held_back.before_px,
        after_px: proposal.held_back.after_px,
        ..none
    })
}

/// The changes that put a proposal in force.
pub fn changes(proposal: Proposal) -> impl Iterator<Item = Change> {
    let rig = proposal.rig.map(Change::Rig);
    rig.into_iter()
        .chain(proposal.objects.into_iter().map(Change::Object))
}

/// What it is worth.
pub fn notice(held_back: &HeldBack) -> Notice {
    Notice::RefinementProposed {
        n_images: u32::try_from(held_back.n_images).unwrap_or(u32::MAX),
        before_px: held_back.before_px,
        after_px: held_back.after_px,
    }
}
