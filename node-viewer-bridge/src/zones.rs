//! Zones of the world and what happens in them: which object entered or left a zone, and which fell.
//!
//! In: poses from the network and the operators' commands. Out: the messages `zones` and `events` for the page, and
//! events for the network and the webhook. The judgement (`judge`, `fall`) has no clock and no network: time is that of
//! the images.

mod command;
mod event;
mod fall;
mod judge;
mod sample;
mod service;
mod zone;

pub(crate) use command::{Command, MAX_BYTES as MAX_COMMAND_BYTES};
pub(crate) use event::Event;
#[cfg(test)]
pub(crate) use event::EventKind;
pub(crate) use service::ZoneService;
