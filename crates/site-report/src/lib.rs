//! What fusion reports of a site, as data.
//!
//! - [`ObjectEstimate`]: pose, covariance and twist of an object at a capture time, with its [`State`] and, where it
//!   has links, an [`ArticulatedEstimate`] of [`LinkEstimate`]s and [`JointEstimate`]s.
//! - [`ClockOffset`]: how far a camera's clock is off.
//! - [`Fault`], [`Imperfection`]: what is wrong with the site and its files, with the words for people and their
//!   [`Severity`].
//!
//! Metres, radians and seconds; frames as `crates/geometry/FRAMES.md` defines them. This crate estimates nothing, so
//! that whoever reads a report depends on no estimator. Messages encode a variant of [`State`], [`Fault`] and
//! [`Imperfection`] by its index, so the order of variants is part of the wire contract; `proto/tests/contract.rs`
//! compares it with `proto/CONTRACT.md`.

mod clock_cause;
mod estimate;
mod fault;
mod imperfection;
mod sentences;
mod severity;

pub use clock_cause::clock_cause;
pub use estimate::{
    ArticulatedEstimate, ClockOffset, JointEstimate, LinkEstimate, ObjectEstimate, State,
};
pub use fault::Fault;
pub use imperfection::Imperfection;
pub use severity::Severity;
