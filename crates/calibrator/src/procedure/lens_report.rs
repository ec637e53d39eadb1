//! What is told of a lens's calibration.

use crate::Verdict;
use crate::lens::{LensCalibration, LensMaps};
use serde::Serialize;
use sextant_estimator::{CameraId, TagId};
use sextant_geometry::Lens;

/// How well a lens was calibrated, in numbers and words. Pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensReport {
    /// Whose lens.
    pub camera: CameraId,
    /// Width and height of its pictures.
    pub resolution: [u32; 2],
    /// The lens.
    pub lens: Lens,
    /// One standard deviation each of fx, fy, cx, cy and the distortion's coefficients.
    pub sigmas: Vec<f64>,
    /// Root mean square distance between seen and reprojected corners.
    pub rms_px: f64,
    /// Noise of the corners in each coordinate, as the fit shows it.
    pub noise_px: f64,
    /// Images taken in, with or without the board.
    pub images: usize,
    /// Images that the lens was fitted to.
    pub views: usize,
    /// Tags that the lens was fitted to.
    pub tags: usize,
    /// Tags left out because they lie elsewhere than the board says.
    pub wrong_tags: usize,
    /// Tags of which more than half were left out, or that were seen twice in one image.
    pub suspicious: Vec<TagId>,
    /// The models that were tried, simplest first.
    pub models: Vec<HeldOut>,
    /// Part of the picture's cells that hold a corner.
    pub coverage: f64,
    /// Where the lens shows a ray, over the picture.
    pub uncertainty_px: Uncertainty,
    /// What is left of the corners' errors, over the picture.
    #[serde(rename = "cells", serialize_with = "rows")]
    pub maps: LensMaps,
    /// In words.
    pub verdict: Verdict,
}

/// How a model did on images that it was not fitted to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// Id of the camera.
    pub model: &'static str,
    /// Root mean square distance between seen and foretold corners.
    pub held_out_rms_px: f64,
}

/// One standard deviation over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Its mean.
    pub mean: f64,
    /// At the worst place.
    pub largest: f64,
}

impl LensReport {
    /// Of a camera's calibration.
    pub fn of(camera: &CameraId, found: LensCalibration) -> Self {
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
