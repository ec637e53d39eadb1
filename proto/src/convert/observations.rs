//! Observations to what the estimator takes in.

use crate::messages::camera_status::{ClockQuality, ClockSource};
use crate::messages::observations::{Observations, TagObservation};
use nalgebra::{Matrix2, Point2};
use sextant_estimator::{ImageObservation, TagCorners, TagId};

impl From<&Observations> for ImageObservation {
    fn from(message: &Observations) -> Self {
        Self {
            camera: message.camera.clone(),
            capture_ns: message.capture_ns,
            clock_error_ns: clock_error_ns(message.clock),
            exposure_ns: u64::from(message.exposure_ns),
            tags: message.tags.iter().map(TagCorners::from).collect(),
        }
    }
}

impl From<&TagObservation> for TagCorners {
    fn from(tag: &TagObservation) -> Self {
        Self {
            tag: TagId {
                family: tag.family,
                id: tag.id,
            },
            corners: tag
                .corners
                .map(|[x, y]| Point2::new(f64::from(x), f64::from(y))),
            corner_covariance: tag.corner_covariance.map(|[xx, xy, yy]| {
                let (xx, xy, yy) = (f64::from(xx), f64::from(xy), f64::from(yy));
                Matrix2::new(xx, xy, xy, yy)
            }),
            corner_cross_covariance: tag
                .corner_cross_covariance
                .map(|cross| Matrix2::from_row_slice(&cross.map(f64::from))),
        }
    }
}

/// Nobody has compared the clock behind recorded time stamps, or one without a source, with the site's.
fn clock_error_ns(clock: ClockQuality) -> u64 {
    match clock.source {
        ClockSource::Unknown | ClockSource::Recorded => ImageObservation::CLOCK_ERROR_UNKNOWN,
        _ => clock.error_ns,
    }
}
