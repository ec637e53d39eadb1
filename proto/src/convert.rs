//! Between messages and the estimator's types: one file a direction of travel.

mod config;
mod covariance;
mod full;
mod links;
mod observations;
mod pose;
#[cfg(test)]
mod samples;

pub use config::RigConfigError;
