//! Rigid and articulated bodies: where each link of an object is, given a reference link and the joints' values.
//!
//! - [`configuration`]: pose of the reference link, joint values and their rates.
//! - [`chain`]: forward kinematics of the links and their geometric Jacobians.

pub(crate) mod chain;
pub(crate) mod configuration;
