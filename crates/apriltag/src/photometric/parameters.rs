//! Layout of the vector of fitted parameters.
//!
//! Homography (8), black, white, slope of the light (2), covariance of the blur (3), halo, gain, ground.

/// Number of parameters.
pub(super) const PARAMETERS: usize = 18;

/// Parameters of the homography, which come first.
pub(super) const HOMOGRAPHY: usize = 8;

/// Index of black.
pub(super) const BLACK: usize = 8;

/// Index of white.
pub(super) const WHITE: usize = 9;

/// Index of the first parameter of the blur.
pub(super) const BLUR: usize = 12;

/// Index of the halo.
pub(super) const HALO: usize = BLUR + 3;

pub(super) type Vector = [f32; PARAMETERS];
