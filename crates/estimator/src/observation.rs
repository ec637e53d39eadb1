//! What one image shows: the corners of its tags, in pixels, with capture time and its error.

use nalgebra::{Matrix2, Point2};

use crate::{CameraId, TagId};

/// The corners of one tag in one image.
#[derive(Debug, Clone, PartialEq)]
pub struct TagCorners {
    /// Which tag.
    pub tag: TagId,
    /// Top left, top right, bottom right, bottom left of the upright tag, in pixels.
    pub corners: [Point2<f64>; 4],
    /// Covariance of each corner in px², as the detector states it; an all-zero matrix where it says nothing.
    pub corner_covariance: [Matrix2<f64>; 4],
}

/// The tags of one image.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageObservation {
    /// Who took it.
    pub camera: CameraId,
    /// Middle of the exposure by the camera's clock, in ns since the Unix epoch.
    pub capture_ns: u64,
    /// One sigma of that clock against the site's time in ns; [`ImageObservation::CLOCK_ERROR_UNKNOWN`] where nobody knows.
    pub clock_error_ns: u64,
    /// Length of the exposure in ns; 0 where unknown.
    pub exposure_ns: u64,
    /// The tags found; may be empty: an image without tags is knowledge too.
    pub tags: Vec<TagCorners>,
}

impl ImageObservation {
    /// The clock error of a camera whose clock nobody has compared with anything.
    pub const CLOCK_ERROR_UNKNOWN: u64 = u64::MAX;
}
