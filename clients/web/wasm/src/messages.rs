//! Tags and statistics as payloads of the network's contract.

use sextant_apriltag::Detection;
use sextant_proto::{
    CameraControls, CameraStatus, ClockQuality, ClockSource, EncodeError, Observations, Preview,
    TagObservation, Timing, encode, limits,
};
use sextant_site_model::CameraId;

/// When an image was taken and worked on, ns by the device's own clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// Middle of the exposure, or the arrival where the browser does not say more.
    pub capture_ns: u64,
    /// The image arrived.
    pub received_ns: u64,
    /// Its tags were found.
    pub detected_ns: u64,
    /// Whether `capture_ns` is only the arrival.
    pub is_arrival: bool,
}

/// Statistics of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Images that the camera delivered.
    pub captured: u64,
    /// Images that were searched.
    pub detected: u64,
    /// Observations sent.
    pub published: u64,
    /// Images a second.
    pub rate_hz: f32,
    /// Median and 99th percentile of detection, ms.
    pub detect_ms: [f32; 2],
    /// Seconds since the camera started.
    pub uptime_s: u64,
}

/// The payload of an image's [`Observations`], without poses.
///
/// # Errors
/// A value out of its range.
pub fn observations(
    camera: CameraId,
    sequence: u64,
    times: &Times,
    resolution: [u16; 2],
    tags: &[Detection],
) -> Result<Vec<u8>, EncodeError> {
    encode(&Observations {
        camera,
        sequence,
        capture_ns: times.capture_ns,
        exposure_ns: 0,
        clock: clock(times.is_arrival),
        resolution,
        timing: Timing {
            received_ns: times.received_ns,
            detected_ns: times.detected_ns,
            published_ns: times.detected_ns,
        },
        tags: tags.iter().take(limits::MAX_TAGS).map(tag).collect(),
    })
}

/// The payload of a [`CameraStatus`] of a device called `host`.
///
/// # Errors
/// A value out of its range.
pub fn status(
    camera: CameraId,
    host: &str,
    figures: &Figures,
    brightness: f32,
) -> Result<Vec<u8>, EncodeError> {
    encode(&CameraStatus {
        camera,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        host: limits::clipped(host, limits::MAX_NAME_BYTES),
        captured: figures.captured,
        detected: figures.detected,
        dropped: figures.captured.saturating_sub(figures.detected),
        rate_hz: figures.rate_hz,
        detect_ms: figures.detect_ms,
        clock: clock(false),
        uptime_s: figures.uptime_s,
        published: figures.published,
        fallbacks: 0,
        brightness,
        controls: CameraControls::default(),
        notices: Vec::new(),
    })
}

/// The payload of a [`Preview`].
///
/// # Errors
/// More bytes than a picture may have.
pub fn preview(
    camera: CameraId,
    sequence: u64,
    capture_ns: u64,
    resolution: [u16; 2],
    jpeg: &[u8],
) -> Result<Vec<u8>, EncodeError> {
    encode(&Preview {
        camera,
        sequence,
        capture_ns,
        resolution,
        jpeg: jpeg.to_vec(),
    })
}

/// The device's clock as it is before the site has compared it.
fn clock(is_arrival: bool) -> ClockQuality {
    let source = match is_arrival {
        true => ClockSource::Arrival,
        false => ClockSource::FreeRunning,
    };
    ClockQuality {
        source,
        error_ns: 0,
    }
}

fn tag(detection: &Detection) -> TagObservation {
    TagObservation {
        family: detection.family,
        id: detection.id,
        hamming: detection.hamming,
        margin: detection.margin,
        corners: detection.corners,
        corner_covariance: detection.corner_covariance,
        corner_cross_covariance: detection.corner_cross_covariance,
        poses: Vec::new(),
    }
}
