//! The adjustment of a site to tag corners: cameras, lenses, clocks, tags and sizes jointly with the pose of the object
//! at every instant.
//!
//! A [`Bundle`] has the parameters, fixed or free, and the observations. [`solve`] minimises
//!
//! ```text
//! cost = sum of corners rho(r' W r) + sum of ties e' Q^-1 e + sum of priors (x - x0)' L (x - x0)
//! ```
//!
//! over the free lenses, camera poses, clocks, tags and scales (the *kept* parameters) and over the pose, and where
//! motion is modelled the twist, of the object at every instant. Instants are eliminated one after the other
//! (`elimination.rs`), so that memory grows linearly with their number. The result has estimates, their covariance, and
//! the directions that the images do not determine.
//!
//! At least one camera or tag should be fixed (the gauge); undetermined parameters keep their start and are reported.
//!
//! One convention each: a pose steps by `t += dt`, `R = exp(dr) R` (FRAMES.md), a twist is the velocity of the body's
//! origin and its angular velocity in world axes, a clock is *ahead* by its offset, sizes and scales step by their
//! logarithm.

mod anchor;
mod arm;
mod clusters;
mod elimination;
mod equations;
mod layout;
mod marginals;
mod node;
mod observability;
mod parameter;
mod prior_knowledge;
pub mod residuals;
pub mod shutter;
mod solve;
mod stamps;
mod stepping;
mod tie;
mod values;

pub use anchor::Anchor;
pub use arm::{Arm, ArmResidual, Hand, HandError, Mount};
pub use marginals::KeptCovariance;
pub use observability::WeakDirection;
pub use parameter::{ArmPose, KeptParameter};
pub use prior_knowledge::PriorKnowledge;
pub use residuals::corners::TagResidual;
pub use solve::{BundleOptions, BundleSolution, covariance, solve};
pub use values::{
    BodyId, Bundle, BundleCamera, BundleError, BundleImage, BundleTag, FreeLens, Freedom, Instant,
    Motion, ObjectScale, TagObservation,
};

#[cfg(test)]
mod tests;
