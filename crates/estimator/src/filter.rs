//! The error-state filter of one rigid body: SE(3) with a twist, fed with corners of images.
//!
//! - [`edges`]: the noise of a tag's corners.
//! - [`kinematics`]: the state and its prediction in time.
//! - [`bent`]: tags seen through lenses that bend lines.
//! - [`clocks`]: the cameras' clock offsets, and the pose as a camera saw it.
//! - [`corners`]: residuals of a view's corners and their Jacobian.
//! - [`motion`]: how restless the body is.
//! - [`solve`]: the pose that agrees best with a prior and the corners.
//! - [`absorb`]: what that pose means for the whole state.

pub(crate) mod absorb;
pub(crate) mod bent;
pub(crate) mod clocks;
pub(crate) mod corners;
pub(crate) mod edges;
pub(crate) mod kinematics;
pub(crate) mod motion;
pub(crate) mod solve;

#[cfg(test)]
mod tests;
