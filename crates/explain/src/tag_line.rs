//! A tag as JSON has it.

use serde::Serialize;
use sextant_apriltag::Detection;
use sextant_tag_families::Family;

/// A tag as JSON has it: corners clockwise from the top left, px, with (0, 0) at the centre of the top-left pixel;
/// covariances in px².
#[derive(Serialize)]
pub struct TagLine {
    family: Family,
    id: u32,
    hamming: u8,
    margin: f32,
    corners: [[f32; 2]; 4],
    corner_covariance: [[f32; 3]; 4],
    corner_cross_covariance: [[f32; 4]; 6],
}

impl From<&Detection> for TagLine {
    fn from(detection: &Detection) -> Self {
        Self {
            family: detection.family,
            id: detection.id,
            hamming: detection.hamming,
            margin: detection.margin,
            corners: detection.corners,
            corner_covariance: detection.corner_covariance,
            corner_cross_covariance: detection.corner_cross_covariance,
        }
    }
}
