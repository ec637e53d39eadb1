//! Observation messages from detections.

use nalgebra::Point2;
use sextant_apriltag::Detection;
use sextant_geometry::Lens;
use sextant_geometry::planar_pose::{PlanarPose, solve_square};
use sextant_iceoryx_images::{ClockSource as HeaderClock, ImageHeader};
use sextant_process::now_ns;
use sextant_proto::{
    ClockQuality, ClockSource, Observations, TagObservation, TagPose, Timing, limits,
};
use sextant_site_model::{CameraId, TagId};

use super::models::SubscribedModels;

/// The message of one image after the other. It keeps its memory, so that an image with no more tags than an earlier
/// one allocates nothing.
pub(super) struct Draft {
    pub(super) message: Observations,
    /// For the poses of a tag each.
    unused: Vec<Vec<TagPose>>,
}

impl Draft {
    /// An empty message of a camera.
    pub(super) fn new(camera: CameraId) -> Self {
        Self {
            message: Observations {
                camera,
                sequence: 0,
                capture_ns: 0,
                exposure_ns: 0,
                clock: ClockQuality::default(),
                resolution: [0; 2],
                timing: Timing::default(),
                tags: Vec::new(),
            },
            unused: Vec::new(),
        }
    }

    /// Writes the message of an image, without its timing. It contains the first tags that fit into a message.
    pub(super) fn write(
        &mut self,
        header: &ImageHeader,
        detections: &[Detection],
        models: &SubscribedModels,
    ) -> &mut Observations {
        let Self { message, unused } = self;
        message.sequence = header.sequence;
        message.capture_ns = header.capture_ns;
        message.exposure_ns = header.exposure_ns;
        message.clock = clock(header);
        message.resolution = [header.width, header.height];
        unused.extend(message.tags.drain(..).map(|tag| tag.poses));
        let lens = models.lens(header.width, header.height);
        let detections = detections.iter().take(limits::MAX_TAGS);
        message.tags.extend(detections.map(|detection| {
            let mut poses = unused.pop().unwrap_or_default();
            solve(detection, lens, models, &mut poses);
            tag(detection, poses)
        }));
        message
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

fn tag(detection: &Detection, poses: Vec<TagPose>) -> TagObservation {
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

/// Fills `poses`; they stay empty without a lens or the tag's size.
fn solve(
    detection: &Detection,
    lens: Option<&Lens>,
    models: &SubscribedModels,
    poses: &mut Vec<TagPose>,
) {
    poses.clear();
    let id = TagId {
        family: detection.family,
        id: detection.id,
    };
    let (Some(lens), Some(size_m)) = (lens, models.size_m(&id)) else {
        return;
    };
    let corners = detection
        .corners
        .map(|[x, y]| Point2::new(f64::from(x), f64::from(y)));
    if let Ok(solved) = solve_square(lens, &corners, size_m) {
        poses.extend(solved.iter().take(limits::MAX_TAG_POSES).map(tag_pose));
    }
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
