//! Reference of timestamps, and the middle of the exposure, which is the capture time everywhere else.
//!
//! Rows are exposed one after the other, each for the exposure time T; the readout R = (rows - 1) line delays is the
//! delay of the last row relative to the first (0 with a global shutter). The image starts with the exposure of the
//! first row and ends with that of the last one, T + R later; the middle of the middle row is (T + R) / 2 from either
//! end, whatever the direction of readout.
//!
//! Nothing else depends on T. A point that moves at constant velocity appears where it is in the middle of the
//! exposure; an acceleration a displaces it by a T^2 / 24 (the second order of the mean), at 10 ms and 1 g by 0.04 mm.

use serde::{Deserialize, Serialize};

use crate::rig::{Camera, Rig};
use crate::{CameraId, ImageObservation};

/// Longest valid exposure, s.
const LONGEST_S: f64 = 1.0;

/// Reference of a timestamp within the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stamp {
    /// Start of the exposure of the first row.
    Start,
    /// Middle of the exposure of the middle row.
    #[default]
    Middle,
    /// End of the exposure of the last row.
    End,
}

/// Exposure of a camera's images, and the reference of their timestamps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Exposure time of a row, s. That of an image itself takes precedence.
    pub length_s: f64,
    /// Reference of the timestamps.
    pub stamp: Stamp,
}

impl Exposure {
    pub(super) fn is_sound(&self) -> bool {
        (0.0..=LONGEST_S).contains(&self.length_s)
    }

    /// Exposure of an image, given its own exposure in ns, or 0 if unknown.
    fn length_of_s(&self, stated_ns: u64) -> f64 {
        match stated_ns {
            0 => self.length_s,
            _ => (stated_ns as f64 * 1e-9).min(LONGEST_S),
        }
    }
}

impl Rig {
    /// Middle of the exposure of an image with this timestamp, given its own exposure in ns, or 0 if unknown.
    pub fn middle_of_exposure_ns(&self, id: &CameraId, stamp_ns: u64, stated_ns: u64) -> u64 {
        let camera = self.camera(id);
        let Some((camera, exposure)) = camera.and_then(|camera| Some((camera, camera.exposure?)))
        else {
            return stamp_ns;
        };
        let whole_s = exposure.length_of_s(stated_ns) + readout_s(camera);
        let half_ns = (0.5e9 * whole_s).round() as u64;
        match exposure.stamp {
            Stamp::Start => stamp_ns.saturating_add(half_ns),
            Stamp::Middle => stamp_ns,
            Stamp::End => stamp_ns.saturating_sub(half_ns),
        }
    }

    /// The image with the middle of its exposure as capture time. Apply it once, when an image is received.
    #[must_use]
    pub fn timed(&self, image: ImageObservation) -> ImageObservation {
        ImageObservation {
            capture_ns: self.middle_of_exposure_ns(
                &image.camera,
                image.capture_ns,
                image.exposure_ns,
            ),
            ..image
        }
    }
}

/// Seconds from the start of the first row to that of the last.
fn readout_s(camera: &Camera) -> f64 {
    f64::from(camera.resolution[1] - 1) * camera.line_delay_s.unwrap_or(0.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RigError;
    use sextant_geometry::{Intrinsics, Lens};

    fn north() -> CameraId {
        CameraId::new("north").unwrap()
    }

    fn rig(exposure: Exposure, line_delay_s: f64) -> Result<Rig, RigError> {
        let lens = Lens::pinhole(Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 319.5,
            cy: 239.5,
        });
        Rig::new(vec![Camera {
            line_delay_s: Some(line_delay_s),
            exposure: Some(exposure),
            ..Camera::new(north(), [640, 481], lens.unwrap(), None)
        }])
    }

    /// 8 ms of exposure, and 480 rows of 25 us: 12 ms from the first to the last.
    #[test]
    fn the_middle_lies_half_of_exposure_and_readout_from_either_end() {
        let (stamp_ns, ms) = (5_000_000_000, 1_000_000);
        for (stamp, line_delay_s, stated_ns, middle_ns) in [
            (Stamp::Start, 0.0, 0, stamp_ns + 4 * ms),
            (Stamp::End, 0.0, 0, stamp_ns - 4 * ms),
            (Stamp::Start, 2.5e-5, 0, stamp_ns + 10 * ms),
            (Stamp::Start, -2.5e-5, 0, stamp_ns + 10 * ms),
            (Stamp::End, 2.5e-5, 0, stamp_ns - 10 * ms),
            (Stamp::Middle, 2.5e-5, 0, stamp_ns),
            // An image with an exposure time of its own, 2 ms.
            (Stamp::Start, 2.5e-5, 2 * ms, stamp_ns + 7 * ms),
        ] {
            let length_s = 0.008;
            let rig = rig(Exposure { length_s, stamp }, line_delay_s).unwrap();
            let found = rig.middle_of_exposure_ns(&north(), stamp_ns, stated_ns);
            assert_eq!(found, middle_ns, "{stamp:?} {line_delay_s} {stated_ns}");
        }
    }

    #[test]
    fn of_cameras_that_state_nothing_the_stamp_is_the_capture_time() {
        let exposure = Exposure {
            length_s: 0.0,
            stamp: Stamp::End,
        };
        let rig = rig(exposure, 0.0).unwrap();
        let other = CameraId::new("south").unwrap();
        assert_eq!(rig.middle_of_exposure_ns(&other, 7, 1000), 7);
        // Timestamps at the limits do not overflow.
        assert_eq!(rig.middle_of_exposure_ns(&north(), 7, u64::MAX), 0);
    }

    #[test]
    fn an_exposure_that_is_none_is_refused() {
        for length_s in [-0.001, 1.1, f64::NAN] {
            let stamp = Stamp::Middle;
            let refused = rig(Exposure { length_s, stamp }, 0.0).unwrap_err();
            assert_eq!(refused, RigError::Exposure(north()));
        }
    }
}
