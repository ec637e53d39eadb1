//! The result of a lens calibration.

use super::choice::ModelScore;
use super::maps::LensMaps;
use crate::verdict::Verdict;
use nalgebra::DMatrix;
use sextant_geometry::Lens;
use sextant_site_model::TagId;

/// A finished calibration. Pixels, radians, metres.
#[derive(Clone, Debug)]
pub struct LensCalibration {
    /// The lens.
    pub lens: Lens,
    /// Width and height of its images.
    pub resolution: [u32; 2],
    /// One standard deviation of each of [`Lens::parameters`].
    pub sigmas: Vec<f64>,
    /// Covariance of [`Lens::parameters`].
    pub covariance: DMatrix<f64>,
    /// RMS reprojection error, pixels.
    pub rms_px: f64,
    /// Standard deviation of corner coordinates estimated by the fit, pixels.
    pub noise_px: f64,
    /// Images received, with or without the board.
    pub images: usize,
    /// Images used for the fit.
    pub views: usize,
    /// Images that differed too little from those, which [`Selection::New`](super::Selection::New) passes over.
    pub alike: usize,
    /// Images that showed too little of the board.
    pub without_board: usize,
    /// Tags used for the fit.
    pub tags: usize,
    /// Outlier tags, which are not where the board file says.
    pub wrong_tags: usize,
    /// Tags that were mostly outliers or appeared twice in one image, as if a second one existed.
    pub suspicious: Vec<TagId>,
    /// The evaluated models, simplest first.
    pub scores: Vec<ModelScore>,
    /// Coverage, residuals and uncertainty over the image.
    pub maps: LensMaps,
    /// Grade and findings.
    pub verdict: Verdict,
}
