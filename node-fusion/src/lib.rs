//! The fusion node: a thin process around the estimator's machine.
//!
//! Input: observations of every camera of the site, as messages on the network. Output: a pose per object after each
//! image, the models for late joiners, a status a second. Rig and objects may be changed over the network while it
//! works; a refined calibration is proposed from ordinary use. Of several fusion nodes of a site one publishes poses
//! and decides about changes, and the others stand by with the same models. The estimating itself is
//! `sextant_estimator`'s; this is arguments, loop, adapters.

mod adjuster;
mod ages;
mod camera_settings;
mod clocks;
mod config;
mod files;
mod formers;
mod fusion_core;
mod input_log;
mod intake;
mod journal;
mod models;
mod node;
mod notices;
mod outbox;
mod pace;
#[cfg(test)]
mod panic_tests;
mod ports;
mod proposing;
mod refusals;
mod replica;
mod requests;
mod standby;
mod status;
mod storer;
mod turn;

pub use config::{FusionConfig, Refinement, ShardingConfig};
pub use formers::Formers;
pub use fusion_core::{Action, CoreState, FusionCore, HostState, InitialState};
pub use intake::{AdmittedImage, Arrival, Arrivals, Counts, Intake};
pub use models::{Change, ModelsInForce, Payloads};
pub use node::run;
pub use outbox::{Publication, Put};
pub use replica::{KeepJob, ModelsRecord};
pub use turn::{Environment, MOST_REQUESTS};
