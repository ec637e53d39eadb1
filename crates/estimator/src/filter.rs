//! The error-state filter of one object: SE(3) with a twist, and joints where it has some, fed with corners of images.
//!
//! - [`edges`]: the noise of a tag's corners.
//! - [`kinematics`]: the state and its prediction in time.
//! - [`bent`]: tags seen through lenses that bend lines.
//! - [`bodies`]: the links that are seen, and what their views say together.
//! - [`chain`]: where links are, and how they move with base and joints.
//! - [`configuration`]: where base and joints are, and how fast.
//! - [`consider`]: errors of cameras' poses, lenses and tags' places; [`lasting`]: how they displace corners.
//! - [`clocks`]: the cameras' clock offsets.
//! - [`joints`]: values and speeds of joints; [`limits`]: what their limits mean for what is published.
//! - [`observed`]: the configuration as a camera saw it.
//! - [`corners`]: residuals of a view's corners and their Jacobian.
//! - [`normal`]: what a view says of the pose of its link.
//! - [`motion`]: how restless the body is.
//! - [`rooting`]: which link the state is about.
//! - [`shutter`]: images whose rows have times of their own.
//! - [`solve`]: the configuration that agrees best with a prior and the corners.
//! - [`absorb`]: what that pose means for the whole state.

pub(crate) mod absorb;
pub(crate) mod bent;
pub(crate) mod bodies;
pub(crate) mod chain;
pub(crate) mod clocks;
pub(crate) mod configuration;
pub(crate) mod consider;
pub(crate) mod corners;
pub(crate) mod edges;
pub(crate) mod joints;
pub(crate) mod kinematics;
pub(crate) mod lasting;
pub(crate) mod limits;
pub(crate) mod motion;
pub(crate) mod normal;
pub(crate) mod observed;
pub(crate) mod rooting;
pub(crate) mod shutter;
pub(crate) mod solve;

#[cfg(test)]
mod tests;
