//! The error-state filter of one object: SE(3) with a twist, and joints where it has some, fed with corners of images.
//!
//! - [`edges`]: the noise of a tag's corners.
//! - [`kinematics`]: the state and its prediction in time.
//! - [`bent`]: tags seen through lenses that bend lines.
//! - [`chain`]: where links are, and how they move with base and joints.
//! - [`consider`]: errors of the cameras' poses, which last.
//! - [`clocks`]: the cameras' clock offsets.
//! - [`joints`]: values and speeds of joints; [`limits`]: what their limits mean for what is published.
//! - [`observed`]: the configuration as a camera saw it.
//! - [`corners`]: residuals of a view's corners and their Jacobian.
//! - [`motion`]: how restless the body is.
//! - [`rooting`]: which link the state is about.
//! - [`solve`]: the configuration that agrees best with a prior and the corners.
//! - [`absorb`]: what that pose means for the whole state.

pub(crate) mod absorb;
pub(crate) mod bent;
pub(crate) mod chain;
pub(crate) mod clocks;
pub(crate) mod consider;
pub(crate) mod corners;
pub(crate) mod edges;
pub(crate) mod joints;
pub(crate) mod kinematics;
pub(crate) mod limits;
pub(crate) mod motion;
pub(crate) mod observed;
pub(crate) mod rooting;
pub(crate) mod solve;

#[cfg(test)]
mod tests;
