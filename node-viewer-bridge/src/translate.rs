//! From the network's messages to the clients'.

use crate::changes::edit::version_of;
use crate::message::{Message, Pose, TagOutline};
use crate::models::{camera, object_tag};
use sextant_proto::{
    ObjectConfig, ObjectPose, ObjectTruth, Observations, Preview, RigConfig, TagObservation,
};

/// First byte of a binary frame with a JPEG preview.
const JPEG_PREVIEW: u8 = 1;

pub(crate) fn rig(rig: &RigConfig) -> Message<'_> {
    Message::Rig {
        cameras: rig.cameras.iter().map(camera).collect(),
    }
}

pub(crate) fn object(object: &ObjectConfig) -> Message<'_> {
    Message::Object {
        id: object.id.as_str(),
        tags: object.tags.iter().map(object_tag).collect(),
        world_from_object: object.world_from_object,
        version: version_of(object),
    }
}

pub(crate) fn pose(pose: &ObjectPose) -> Message<'_> {
    Message::Pose(Pose {
        object: pose.object.as_str(),
        sequence: pose.sequence,
        t_ns: pose.capture_ns,
        position: pose.position,
        orientation: pose.orientation,
        covariance: &pose.covariance,
        twist: pose.twist,
        state: pose.state,
        cameras: pose.cameras,
        tags: pose.tags,
        rms_px: pose.rms_px,
        latency_ms: latency_ms(pose.capture_ns, pose.published_ns),
    })
}

pub(crate) fn truth(truth: &ObjectTruth) -> Message<'_> {
    Message::Truth {
        object: &truth.object,
        t_ns: truth.capture_ns,
        position: truth.position,
        orientation: truth.orientation,
        error_mm: truth.position_error_m * 1000.0,
        error_deg: truth.attitude_error_rad.to_degrees(),
    }
}

pub(crate) fn observations(observations: &Observations) -> Message<'_> {
    let Observations {
        capture_ns, timing, ..
    } = observations;
    // A stage without a time is unknown.
    let until = |stage_ns: u64| (stage_ns > 0).then(|| latency_ms(*capture_ns, stage_ns));
    Message::Observations {
        camera: &observations.camera,
        sequence: observations.sequence,
        t_ns: *capture_ns,
        received_ms: until(timing.received_ns),
        detected_ms: until(timing.detected_ns),
        latency_ms: latency_ms(*capture_ns, timing.published_ns),
        resolution: observations.resolution,
        tags: observations.tags.iter().map(outline).collect(),
    }
}

/// A preview as a binary frame: kind, length of the id, id, capture time, JPEG.
pub(crate) fn preview(preview: &Preview) -> Vec<u8> {
    let id = preview.camera.to_string();
    let mut frame = Vec::with_capacity(2 + id.len() + 8 + preview.jpeg.len());
    // An id has at most 32 characters.
    frame.extend([JPEG_PREVIEW, id.len() as u8]);
    frame.extend(id.as_bytes());
    frame.extend(preview.capture_ns.to_le_bytes());
    frame.extend(&preview.jpeg);
    frame
}

fn outline(tag: &TagObservation) -> TagOutline {
    TagOutline {
        family: tag.family,
        id: tag.id,
        hamming: tag.hamming,
        margin: tag.margin,
        corners: tag.corners,
    }
}

/// Negative where the two clocks disagree by more than the way took.
pub(crate) fn latency_ms(capture_ns: u64, published_ns: u64) -> f32 {
    ((i128::from(published_ns) - i128::from(capture_ns)) as f64 / 1e6) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_model::{CameraId, ObjectId};
    use sextant_site_report::State;

    #[test]
    fn a_pose_is_written_as_the_protocol_says() {
        let message = ObjectPose {
            object: ObjectId::new("cube").unwrap(),
            epoch: 1,
            sequence: 7,
            capture_ns: 1_790_000_000_000_000_000,
            published_ns: 1_790_000_000_021_500_000,
            state: State::Tracking,
            position: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 3,
            tags: 5,
            rms_px: 0.1,
        };
        let json = serde_json::to_value(pose(&message)).unwrap();
        assert_eq!(json["type"], "pose");
        assert_eq!(json["t_ns"], 1_790_000_000_000_000_000_u64);
        assert_eq!(json["latency_ms"], 21.5);
        assert_eq!(json["state"], "tracking");
        assert_eq!(json["covariance"].as_array().unwrap().len(), 36);
    }

    #[test]
    fn a_preview_frame_names_camera_and_time_before_the_picture() {
        let frame = preview(&Preview {
            camera: CameraId::new("north").unwrap(),
            sequence: 1,
            capture_ns: 0x0102_0304_0506_0708,
            resolution: [640, 480],
            jpeg: vec![0xff, 0xd8],
        });
        assert_eq!(&frame[..2], [1, 5]);
        assert_eq!(&frame[2..7], b"north");
        assert_eq!(frame[7..15], [8, 7, 6, 5, 4, 3, 2, 1]);
        assert_eq!(frame[15..], [0xff, 0xd8]);
    }

    #[test]
    fn latency_may_be_negative_when_clocks_disagree() {
        assert_eq!(latency_ms(3_000_000, 1_000_000), -2.0);
        assert!(latency_ms(0, u64::MAX).is_finite());
    }
}
