//! Observation of one image: the corners of its tags in pixels, with capture time and its error.

use nalgebra::{Matrix2, Point2, SMatrix};
use sextant_geometry::CORNER_PAIRS;

use crate::{CameraId, TagId};

/// The corners of one tag in one image.
#[derive(Debug, Clone, PartialEq)]
pub struct TagCorners {
    /// Identity of the tag.
    pub tag: TagId,
    /// Top left, top right, bottom right, bottom left of the upright tag, in pixels.
    pub corners: [Point2<f64>; 4],
    /// Covariance of each corner in px², from the detector; zero if unknown.
    pub corner_covariance: [Matrix2<f64>; 4],
    /// Covariance between the corners of each of [`sextant_geometry::CORNER_PAIRS`] in px², rows of the first one; all
    /// zero where their errors are independent or their covariance is unknown.
    pub corner_cross_covariance: [Matrix2<f64>; 6],
}

impl TagCorners {
    /// Whether cross covariances of the corners are given.
    pub fn is_joint(&self) -> bool {
        self.corner_cross_covariance
            .iter()
            .any(|cross| *cross != Matrix2::zeros())
    }

    /// Covariance of x and y of each corner in turn, px².
    pub fn covariance(&self) -> SMatrix<f64, 8, 8> {
        let mut all = self.own_covariance();
        for ([a, b], cross) in CORNER_PAIRS.iter().zip(&self.corner_cross_covariance) {
            all.fixed_view_mut::<2, 2>(2 * a, 2 * b).copy_from(cross);
            let transposed = cross.transpose();
            all.fixed_view_mut::<2, 2>(2 * b, 2 * a)
                .copy_from(&transposed);
        }
        all
    }

    /// Covariance of corners with independent errors.
    pub fn own_covariance(&self) -> SMatrix<f64, 8, 8> {
        let mut all = SMatrix::<f64, 8, 8>::zeros();
        for (corner, own) in self.corner_covariance.iter().enumerate() {
            let symmetric = (own + own.transpose()) * 0.5;
            let mut block = all.fixed_view_mut::<2, 2>(2 * corner, 2 * corner);
            block.copy_from(&symmetric);
        }
        all
    }
}

/// The tags of one image.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageObservation {
    /// Id of the camera.
    pub camera: CameraId,
    /// Middle of the exposure by the camera's clock, in ns since the Unix epoch.
    pub capture_ns: u64,
    /// Standard deviation of that clock relative to the site's time in ns; [`ImageObservation::CLOCK_ERROR_UNKNOWN`] if
    /// unknown.
    pub clock_error_ns: u64,
    /// Length of the exposure in ns; 0 where unknown.
    pub exposure_ns: u64,
    /// Width and height of the image in pixels; `None` where unknown.
    pub resolution: Option<[u32; 2]>,
    /// The detected tags; may be empty, since an image without tags is information, too.
    pub tags: Vec<TagCorners>,
}

impl ImageObservation {
    /// Clock error of a camera whose clock is not synchronised.
    pub const CLOCK_ERROR_UNKNOWN: u64 = u64::MAX;
}
