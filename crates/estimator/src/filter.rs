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
//! - [`update`]: what that pose means for the whole state.

pub(crate) mod clock_states;
pub(crate) mod consider;
pub(crate) mod covariance;
pub(crate) mod joint_limits;
pub(crate) mod joint_states;
pub(crate) mod least_squares;
pub(crate) mod link_equations;
pub(crate) mod observed_configuration;
pub(crate) mod process_noise;
pub(crate) mod reanchor;
pub(crate) mod state;
pub(crate) mod update;

#[cfg(test)]
mod tests;
