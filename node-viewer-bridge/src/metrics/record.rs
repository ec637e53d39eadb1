//! What is kept of a camera, an object and a fusion node.

use super::Moment;
use super::health::SILENCE;
use super::histogram::Histogram;
use sextant_proto::{CameraClock, CameraStatus, FusionStatus, ObjectPose, Observations};
use std::time::Instant;

/// The stages of an image, in order.
pub(super) const IMAGE_STAGES: [&str; 4] = ["capture", "detect", "publish", "network"];
/// How far a pose has come, from its capture.
pub(super) const POSE_STAGES: [&str; 2] = ["published", "received"];

/// A camera.
#[derive(Debug, Default)]
pub(super) struct CameraRecord {
    pub(super) status: Option<CameraStatus>,
    pub(super) images: u64,
    pub(super) tags: u64,
    pub(super) last_image: Option<Instant>,
    /// By [`IMAGE_STAGES`].
    pub(super) stages: [Histogram; IMAGE_STAGES.len()],
    /// Stages that end before they begin, since clocks differ.
    pub(super) back_in_time: u64,
}

impl CameraRecord {
    pub(super) fn take_image(&mut self, message: &Observations, now: Moment) {
        self.images += 1;
        self.tags += message.tags.len() as u64;
        self.last_image = Some(now.at);
        let timing = &message.timing;
        let stamps = [
            message.capture_ns,
            timing.received_ns,
            timing.detected_ns,
            timing.published_ns,
            now.ns,
        ];
        for (stage, ends) in self.stages.iter_mut().zip(stamps.windows(2)) {
            // 0 is unknown.
            if let &[start, end] = ends
                && start.min(end) > 0
                && stage.take(start, end).is_err()
            {
                self.back_in_time += 1;
            }
        }
    }
}

/// An object.
#[derive(Debug, Default)]
pub(super) struct ObjectRecord {
    pub(super) poses: u64,
    /// The newest, and when it arrived.
    pub(super) pose: Option<(ObjectPose, Instant)>,
    /// By [`POSE_STAGES`].
    pub(super) stages: [Histogram; POSE_STAGES.len()],
    /// When its tags were first and last seen without a longer pause than [`SILENCE`].
    pub(super) seen: Option<(Instant, Instant)>,
}

impl ObjectRecord {
    pub(super) fn take_pose(&mut self, pose: &ObjectPose, now: Moment) {
        self.poses += 1;
        for (stage, end_ns) in self.stages.iter_mut().zip([pose.published_ns, now.ns]) {
            // Of clocks that are off there are no latencies; cameras' clocks have figures of their own.
            let _ = stage.take(pose.capture_ns, end_ns);
        }
        self.pose = Some((pose.clone(), now.at));
    }

    pub(super) fn is_seen(&mut self, now: Instant) {
        let first = match self.seen {
            Some((first, last)) if now.saturating_duration_since(last) <= SILENCE => first,
            _ => now,
        };
        self.seen = Some((first, now));
    }
}

/// A fusion node.
#[derive(Debug, Default)]
pub(super) struct FusionRecord {
    /// The newest, and when it arrived.
    pub(super) status: Option<(FusionStatus, Instant)>,
    pub(super) clocks: Vec<CameraClock>,
}
