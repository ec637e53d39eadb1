//! The fusion node: a thin process around the estimator's machine.
//!
//! In: observations of every camera of the site, as messages on the network. Out: a pose per object after each image, the
//! models for late joiners, a status a second. The estimating itself is `sextant_estimator`'s; this is arguments, loop, adapters.

mod config;
mod intake;
mod links;
mod node;
mod outlet;
mod status;

pub use config::FusionConfig;
pub use intake::{Counts, Intake};
pub use node::run;
