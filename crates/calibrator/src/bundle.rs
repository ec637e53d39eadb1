//! Bundle adjustment of tag corners: cameras and tags are found together with where the object was at every instant.
//!
//! A [`Bundle`] states what is known and what is sought; [`solve`] minimises the reprojection errors of all corners over the
//! free lenses, camera poses, clocks and tags (the *kept* parameters) and over the object's pose at every instant, which are
//! eliminated instant by instant (Schur complement; B. Triggs et al., Bundle adjustment: a modern synthesis, 2000, section
//! 6), so that memory grows with the number of instants and never with their square. What comes out are estimates, their
//! covariance, and the directions that the images do not determine.
//!
//! At least one camera or tag should be fixed (the gauge); what is left undetermined stays where it was and is reported.

mod anchors;
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
mod state;

pub use covariance::KeptCovariance;
pub use layout::KeptParameter;
pub use observability::WeakDirection;
pub use prior_knowledge::PriorKnowledge;
pub use residuals::TagResidual;
pub use solver::{BundleOptions, BundleSolution, solve};
pub use state::{
    Anchor, Bundle, BundleCamera, BundleError, BundleImage, BundleTag, FreeLens, Freedom, Instant,
    Motion, SeenTag,
};

#[cfg(test)]
mod tests;
