//! The error-state filter of one object: SE(3) with a twist, joints and clock offsets, updated with the corners of
//! images.
//!
//! - [`state`]: pose, twist and their prediction; [`joint_states`] and [`clock_states`]: the other parts of the state;
//!   [`covariance`]: its blocks.
//! - [`process_noise`]: power spectral density of the acceleration.
//! - [`observed_configuration`]: the configuration as a camera sees it.
//! - [`link_equations`]: normal equations of the links that are seen; [`least_squares`]: the configuration that agrees
//!   best with prior and corners.
//! - [`update`]: the whole state after that fit.
//! - [`consider`]: sensitivities to errors of cameras, lenses and tags.
//! - [`reanchor`]: choice of the link whose pose is in the state.

pub(crate) mod clock_states;
pub(crate) mod consider;
pub(crate) mod covariance;
pub(crate) mod joint_states;
pub(crate) mod least_squares;
pub(crate) mod link_equations;
pub(crate) mod observed_configuration;
pub(crate) mod process_noise;
pub(crate) mod reanchor;
pub(crate) mod state;
pub(crate) mod update;

#[cfg(test)]
pub(crate) mod tests;
