//! The wizards: lenses, rigs and constellations calibrated from the page, with the images of the running site.
//!
//! One wizard runs at a time and every client sees the same one. A person's command is answered at once by the [`WizardService`];
//! images wait in a bounded queue for the wizard's thread, and solving has a thread of its own, so that neither the network
//! nor the page waits for either. The procedures are `sextant_calibrator`'s, as on the command line.

mod command;
mod machine;
mod plan;
mod run;
#[cfg(test)]
pub(crate) mod samples;
mod service;
mod state;

pub(crate) use command::{Command, MAX_BYTES as MAX_COMMAND_BYTES};
pub(crate) use run::run;
pub(crate) use service::WizardService;
