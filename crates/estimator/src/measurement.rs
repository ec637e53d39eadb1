//! What one image says about one tag: residuals of the corners, their noise and their Jacobians. The ground floor of
//! the estimator.
//!
//! - [`corners`]: residuals of a tag's corners and their derivatives by the object's pose.
//! - [`corner_noise`]: covariance of the corners before anything is learned; [`whitening`]: residuals with independent
//!   noise.
//! - [`distortion_bias`]: bias of the corners of tags that a lens bends.
//! - [`rolling_shutter`]: images whose rows are exposed one after the other.
//! - [`view_equations`]: robust normal equations of a view about the pose of its link.
//! - [`biases`]: how errors of camera poses, lenses and tag poses displace a view.

pub(crate) mod biases;
pub(crate) mod corner_noise;
pub(crate) mod corners;
pub(crate) mod distortion_bias;
pub(crate) mod planar_poses;
pub(crate) mod ray;
pub(crate) mod rolling_shutter;
pub(crate) mod view_equations;
pub(crate) mod whitening;
