//! Report on a lens calibration.

use crate::Verdict;
use crate::lens::{LensCalibration, LensMaps};
use serde::Serialize;
use sextant_geometry::Lens;
use sextant_site_model::{CameraId, TagId};

/// Accuracy of a lens calibration, and a verdict. Pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensReport {
    /// Id of the camera.
    pub camera: CameraId,
    /// Width and height of its images.
    pub resolution: [u32; 2],
    /// The lens.
    pub lens: Lens,
    /// One standard deviation each of fx, fy, cx, cy and the distortion coefficients.
    pub sigmas: Vec<f64>,
    /// RMS reprojection error.
    pub rms_px: f64,
    /// Standard deviation of corner coordinates estimated by the fit.
    pub noise_px: f64,
    /// Images received, with or without the board.
    pub images: usize,
    /// Images used for the fit.
    pub views: usize,
    /// Images of a stream that were left out, since they differed too little from those used.
    pub alike: usize,
    /// Images that showed too little of the board.
    pub without_board: usize,
    /// Tags used for the fit.
    pub tags: usize,
    /// Outlier tags, which are not where the board file says.
    pub wrong_tags: usize,
    /// Tags that were mostly outliers or appeared twice in one image.
    pub suspicious: Vec<TagId>,
    /// The evaluated models, simplest first.
    pub models: Vec<HeldOut>,
    /// Share of the image's cells that contain a corner.
    pub coverage: f64,
    /// Standard deviation of projected rays, over the image.
    pub uncertainty_px: Uncertainty,
    /// Remaining errors of the corners, over the image.
    #[serde(rename = "cells", serialize_with = "rows")]
    pub maps: LensMaps,
    /// Grade and findings.
    pub verdict: Verdict,
}

/// Held-out error of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// Name of the model.
    pub model: &'static str,
    /// RMS distance between detected and predicted corners of images that were not used for its fit.
    pub held_out_rms_px: f64,
}

/// Standard deviation of projected rays over the image, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Mean over the image.
    pub mean: f64,
    /// Largest value.
    pub largest: f64,
}

impl LensReport {
    /// The report on a camera's calibration.
    pub fn new(camera: &CameraId, found: LensCalibration) -> Self {
        let (mean, largest, _) = found.maps.uncertainty();
        let models = found.scores.iter().map(|score| HeldOut {
            model: score.model.name(),
            held_out_rms_px: score.held_out_rms_px,
        });
        Self {
            camera: camera.clone(),
            resolution: found.resolution,
            lens: found.lens,
            sigmas: found.sigmas,
            rms_px: found.rms_px,
            noise_px: found.noise_px,
            images: found.images,
            views: found.views,
            alike: found.alike,
            without_board: found.without_board,
            tags: found.tags,
            wrong_tags: found.wrong_tags,
            suspicious: found.suspicious,
            models: models.collect(),
            coverage: found.maps.coverage(),
            uncertainty_px: Uncertainty { mean, largest },
            maps: found.maps,
            verdict: found.verdict,
        }
    }
}

fn rows<S: serde::Serializer>(maps: &LensMaps, serializer: S) -> Result<S::Ok, S::Error> {
    maps.cells.serialize(serializer)
}
