//! Rigid motions, lenses, homographies, planar pose and least squares: the mathematics under everything else.
//!
//! Pure functions of `f64`; no clock, no image, no file, no network. Metres, radians, pixels; the frames and signs are
//! those of `FRAMES.md`, which has a test for each of its sentences.

pub mod corner_pairs;
pub mod homography;
pub mod least_squares;
pub mod lens;
pub mod planar_pose;
pub mod pose;
pub mod se3;
pub mod so3;
mod stumpff;
pub mod tag_frame;

pub use corner_pairs::{CORNER_PAIRS, wrong_corner_pair};
pub use homography::Homography;
pub use lens::{Intrinsics, Lens, LensError, LensModel, LensParameters, UnprojectError};
pub use pose::{Pose, PoseError, PoseParts, unit_quaternion};
pub use tag_frame::tag_corners_in_tag;
