//! What fusion reports of a site, as data.
//!
//! - [`ObjectEstimate`]: pose, covariance and twist of an object at a capture time, with its [`State`] and, where it has links, an
//!   [`ArticulatedEstimate`] of [`LinkEstimate`]s and [`JointEstimate`]s.
//! - [`ClockOffset`]: how far a camera's clock is off.
//! - [`Fault`], [`Imperfection`]: what is wrong with the site and its files, with the words for people.
//!
//! Metres, radians and seconds; frames as `crates/geometry/FRAMES.md` defines them. This crate estimates nothing, so that whoever reads a
//! report depends on no estimator. [`State`], [`Fault`] and [`Imperfection`] are part of messages that encode a variant by its index:
//! `proto/CONTRACT.md` pins the order of their variants.

mod estimate;
mod fault;
mod imperfection;

pub use estimate::{
    ArticulatedEstimate, ClockOffset, JointEstimate, LinkEstimate, ObjectEstimate, State,
};
pub use fault::Fault;
pub use imperfection::Imperfection;
