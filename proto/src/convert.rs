//! Between messages and the types of models and estimates: one file a subject.

mod covariance;
mod links;
mod object;
mod observations;
mod pose;
mod rig;

pub use rig::RigConfigError;
