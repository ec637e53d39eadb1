//! Bundle adjustment of tag corners: estimates cameras and tags jointly with the pose of the object at every instant.
//!
//! A [`Bundle`] has the parameters, fixed or free, and the observations. [`solve`] minimises the reprojection errors of
//! all corners over the free lenses, camera poses, clocks and tags (the *kept* parameters) and over the pose of the
//! object at every instant. Instants are eliminated one by one (Schur complement; B. Triggs et al., Bundle adjustment:
//! a modern synthesis, 2000, section 6), so that memory grows linearly with their number. The result has estimates,
//! their covariance, and the directions that the images do not determine.
//!
//! At least one camera or tag should be fixed (the gauge); undetermined parameters keep their start and are reported.

mod anchors;
mod arm;
mod arm_equations;
mod clusters;
mod covariance;
mod elimination;
mod equations;
mod image_sums;
mod layout;
mod motion;
mod node;
mod observability;
mod prior_knowledge;
mod residuals;
mod solver;
mod stamps;
mod state;

pub(crate) use arm::HandError;
pub use arm::{Arm, ArmResidual, Hand, Mount};
pub use covariance::KeptCovariance;
pub use layout::{ArmPose, KeptParameter};
pub use observability::WeakDirection;
pub use prior_knowledge::PriorKnowledge;
pub use residuals::TagResidual;
pub use solver::{BundleOptions, BundleSolution, solve};
pub use state::{
    Anchor, Bundle, BundleCamera, BundleError, BundleImage, BundleTag, FreeLens, Freedom, Instant,
    Motion, TagObservation,
};

#[cfg(test)]
mod tests;
