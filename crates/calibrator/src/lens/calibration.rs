//! The result of a lens calibration.

use super::choice::ModelScore;
use super::maps::LensMaps;
use crate::verdict::Verdict;
use nalgebra::DMatrix;
use sextant_estimator::TagId;
use sextant_geometry::Lens;

/// A finished calibration. Pixels, radians, metres.
#[derive(Clone, Debug)]
pub struct LensCalibration {
    /// The lens.
    pub lens: Lens,
    /// Width and height of its pictures.
    pub resolution: [u32; 2],
    /// One standard deviation of each of [`Lens::parameters`].
    pub sigmas: Vec<f64>,
    /// Covariance of [`Lens::parameters`].
    pub covariance: DMatrix<f64>,
    /// Root mean square distance between seen and reprojected corners, pixels.
    pub rms_px: f64,
    /// Noise of the corners in each coordinate, pixels, as the fit shows it.
    pub noise_px: f64,
    /// Images taken in, with or without the board.
    pub images: usize,
    /// Images that the lens was fitted to.
    pub views: usize,
    /// Tags that the lens was fitted to.
    pub tags: usize,
    /// Tags left out because they lie elsewhere than the board says.
    pub wrong_tags: usize,
    /// Ids of which more than half were left out, or that were seen twice in one image: is there a second one in the room?
    pub suspicious: Vec<TagId>,
    /// The models that were tried, simplest first.
    pub scores: Vec<ModelScore>,
    /// Coverage, residuals and uncertainty over the picture.
    pub maps: LensMaps,
    /// What to think of it.
    pub verdict: Verdict,
}
