//! Observation messages from detections.

use nalgebra::Point2;
use sextant_apriltag::Detection;
use sextant_estimator::{TagId, tag_poses};
use sextant_geometry::Lens;
use sextant_geometry::planar_pose::PlanarPose;
use sextant_iceoryx_images::{ClockSource as HeaderClock, ImageHeader};
use sextant_process::now_ns;
use sextant_proto::{
    ClockQuality, ClockSource, Observations, TagObservation, TagPose, Timing, limits,
};

use super::models::Models;

/// The message of an image, without its timing. It contains the first tags that fit into a message.
pub(super) fn observations(
    header: &ImageHeader,
    detections: &[Detection],
    models: &Models,
) -> Observations {
    let lens = models.lens(header.width, header.height);
    let tags = detections
        .iter()
        .take(limits::MAX_TAGS)
        .map(|detection| tag(detection, lens, models))
        .collect();
    Observations {
        camera: models.camera().clone(),
        sequence: header.sequence,
        capture_ns: header.capture_ns,
        exposure_ns: header.exposure_ns,
        clock: clock(header),
        resolution: [header.width, header.height],
        timing: Timing::default(),
        tags,
    }
}

/// Times at which the image passed the stages, by the clock of the camera.
pub(super) fn stamp(message: &mut Observations, header: &ImageHeader, received_ns: u64) {
    let in_camera_clock = |host_ns: u64| host_ns.saturating_add_signed(header.clock_offset_ns);
    let now = in_camera_clock(now_ns());
    message.timing = Timing {
        received_ns: in_camera_clock(received_ns),
        detected_ns: now,
        published_ns: now,
    };
}

/// The clock of an image, as on the wire.
pub(super) fn clock(header: &ImageHeader) -> ClockQuality {
    let source = match header.clock() {
        HeaderClock::Unknown => ClockSource::Unknown,
        HeaderClock::FreeRunning => ClockSource::FreeRunning,
        HeaderClock::Ntp => ClockSource::Ntp,
        HeaderClock::Ptp => ClockSource::Ptp,
        HeaderClock::Recorded => ClockSource::Recorded,
        HeaderClock::Simulated => ClockSource::Simulated,
        HeaderClock::Arrival => ClockSource::Arrival,
    };
    ClockQuality {
        source,
        error_ns: header.clock_error_ns,
    }
}

fn tag(detection: &Detection, lens: Option<&Lens>, models: &Models) -> TagObservation {
    let id = TagId {
        family: detection.family,
        id: detection.id,
    };
    let poses = match (lens, models.size_m(&id)) {
        (Some(lens), Some(size_m)) => poses(lens, detection, size_m),
        _ => Vec::new(),
    };
    TagObservation {
        family: detection.family,
        id: detection.id,
        hamming: detection.hamming,
        margin: detection.margin,
        corners: detection.corners,
        corner_covariance: detection.corner_covariance,
        corner_cross_covariance: detection.corner_cross_covariance,
        poses,
    }
}

fn poses(lens: &Lens, detection: &Detection, size_m: f64) -> Vec<TagPose> {
    let corners = detection
        .corners
        .map(|[x, y]| Point2::new(f64::from(x), f64::from(y)));
    tag_poses(lens, &corners, size_m)
        .iter()
        .take(limits::MAX_TAG_POSES)
        .map(tag_pose)
        .collect()
}

fn tag_pose(pose: &PlanarPose) -> TagPose {
    let camera_from_tag = &pose.camera_from_tag;
    let orientation = camera_from_tag.rotation.coords.cast::<f32>();
    TagPose {
        position: camera_from_tag.translation.vector.cast::<f32>().into(),
        orientation: orientation.into(),
        rms_px: pose.rms_px as f32,
    }
}
