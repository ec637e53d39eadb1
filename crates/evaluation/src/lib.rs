//! Errors of estimated poses against a reference, and whether their covariances are consistent.
//!
//! - [`PoseError`], [`Consistency`], [`Spread`]: the error of a pose, its normalised square, statistics of many.
//! - [`PosePairs`]: the best rigid motion between estimated and true poses.
//! - [`references`](mod@reference), [`compare`]: the poses of a replay against files of poses; [`plots`] of them.
//! - [`other_conventions`]: units and orders that a reference seems to have.
//! - [`live`]: poses of a running site against the simulator's truth, with constant memory.
//!
//! The error of an estimate (P, p) of a pose (Q, q) is the step `(p - q, log(P Q^T))`, in m and rad and in world axes,
//! over which covariances of poses are published ([`sextant_geometry::se3::difference`]). Nothing here knows how poses
//! are made.

mod alignment;
mod comparison;
mod conventions;
mod error;
pub mod live;
pub mod plots;
mod pose_table;
pub mod reference;

pub use alignment::{PosePairs, Rms};
pub use comparison::{Alignment, ObjectComparison, TimedError, compare};
pub use conventions::{no_common_time, other_conventions};
pub use error::{CHI_SQUARE_6_95, Consistency, PoseError, Spread};
