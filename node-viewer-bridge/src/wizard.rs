//! The wizards: lenses, rigs and constellations calibrated from the page, with the images of the running site.
//!
//! One wizard runs at a time and every client sees the same one. All that happens to it (requests, images, answers and
//! offers of fusion nodes) waits in one bounded queue ([`inbox`]) for one thread ([`run`]), which has a machine without
//! thread, file and network handle it ([`wizard_core`]) and carries its outputs out. Solving has a thread of its own.
//! Edits of the rig and of objects go the same way. The procedures are `sextant_calibrator`'s, as on the command line.

mod command;
mod inbox;
mod machine;
mod plan;
mod run;
#[cfg(test)]
pub(crate) mod samples;
mod service;
mod state;
mod wizard_core;

pub(crate) use command::{Command, MAX_BYTES as MAX_COMMAND_BYTES};
pub(crate) use run::run;
pub(crate) use service::WizardService;
pub(crate) use wizard_core::UserRequest;
