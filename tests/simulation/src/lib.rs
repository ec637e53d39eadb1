//! A whole site in simulated time: cameras, routers, fusion nodes with their election, models and disks, and a client,
//! as their real state machines, in one queue of events. Everything follows from one seed, and what the site promises
//! is checked meanwhile and in the end.

#![allow(
    clippy::expect_used,
    reason = "a simulation that cannot be set up ends by panicking"
)]

mod coverage;
mod disk;
mod followers;
mod fusion;
mod host;
mod network;
mod plan;
mod promises;
mod recorder;
mod scene;
mod shrink;
mod trace;
mod world;

pub use coverage::Coverage;
pub use plan::Plan;
pub use promises::Violation;
pub use shrink::superfluous;
pub use world::{Outcome, run};
