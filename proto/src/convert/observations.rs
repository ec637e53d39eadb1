//! Observations to the images of the site model.

use crate::messages::camera_status::{ClockQuality, ClockSource};
use crate::messages::observations::{Observations, TagObservation};
use nalgebra::{Matrix2, Point2};
use sextant_site_model::{ImageObservation, TagCorners, TagId};

impl From<&Observations> for ImageObservation {
    fn from(message: &Observations) -> Self {
        Self {
            camera: message.camera.clone(),
            capture_ns: message.capture_ns,
            clock_error_ns: clock_error_ns(message.clock),
            exposure_ns: u64::from(message.exposure_ns),
            resolution: Some(message.resolution.map(u32::from)),
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

/// An error from which on it is no prior: the estimate of an offset is linear over some milliseconds of motion.
const FAR_CLOCK_NS: u64 = 100_000_000;

/// Nobody has compared the clock behind recorded time stamps, or one without a source, with the site's; and a clock
/// that nothing disciplines, or that is off by tenths of a second, may show any time.
fn clock_error_ns(clock: ClockQuality) -> u64 {
    match clock.source {
        ClockSource::Unknown | ClockSource::FreeRunning | ClockSource::Recorded => {
            ImageObservation::CLOCK_ERROR_UNKNOWN
        }
        _ if clock.error_ns > FAR_CLOCK_NS => ImageObservation::CLOCK_ERROR_UNKNOWN,
        _ => clock.error_ns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_may_show_any_time_has_an_unknown_offset() {
        let error_ns = |source, error_ns| clock_error_ns(ClockQuality { source, error_ns });
        let unknown = ImageObservation::CLOCK_ERROR_UNKNOWN;
        assert_eq!(error_ns(ClockSource::Unknown, 0), unknown);
        assert_eq!(error_ns(ClockSource::FreeRunning, 5_000_000), unknown);
        assert_eq!(error_ns(ClockSource::Arrival, 200_000_000), unknown);
        assert_eq!(error_ns(ClockSource::Arrival, 10_000_000), 10_000_000);
        assert_eq!(error_ns(ClockSource::Ntp, 300_000), 300_000);
        assert_eq!(error_ns(ClockSource::Simulated, 0), 0);
    }
}
