//! What is counted of a camera and an object.

use super::Moment;
use super::histogram::Histogram;
use sextant_proto::{ObjectPose, Observations};
use sextant_site_mirror::limits::SILENCE_NS;

/// The stages of an image, in order.
pub(super) const IMAGE_STAGES: [&str; 4] = ["capture", "detect", "publish", "network"];
/// How far a pose has come, from its capture.
pub(super) const POSE_STAGES: [&str; 2] = ["published", "received"];

/// A camera.
#[derive(Debug, Default)]
pub(super) struct CameraFigures {
    pub(super) images: u64,
    pub(super) tags: u64,
    /// By [`IMAGE_STAGES`].
    pub(super) stages: [Histogram; IMAGE_STAGES.len()],
    /// Stages that end before they begin, since clocks differ.
    pub(super) back_in_time: u64,
}

impl CameraFigures {
    pub(super) fn count_image(&mut self, message: &Observations, now: Moment) {
        self.images += 1;
        self.tags += message.tags.len() as u64;
        let timing = &message.timing;
        let stamps = [
            message.capture_ns,
            timing.received_ns,
            timing.detected_ns,
            timing.published_ns,
            now.wall_ns,
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
pub(super) struct ObjectFigures {
    pub(super) poses: u64,
    /// By [`POSE_STAGES`].
    pub(super) stages: [Histogram; POSE_STAGES.len()],
    /// When its tags were first and last seen without a longer pause than [`SILENCE_NS`], ns.
    pub(super) seen_ns: Option<(u64, u64)>,
}

impl ObjectFigures {
    pub(super) fn count_pose(&mut self, pose: &ObjectPose, now: Moment) {
        self.poses += 1;
        for (stage, end_ns) in self.stages.iter_mut().zip([pose.published_ns, now.wall_ns]) {
            // Of clocks that are off there are no latencies; cameras' clocks have figures of their own.
            let _ = stage.take(pose.capture_ns, end_ns);
        }
    }

    pub(super) fn is_seen(&mut self, now_ns: u64) {
        let first_ns = match self.seen_ns {
            Some((first_ns, last_ns)) if now_ns.saturating_sub(last_ns) <= SILENCE_NS => first_ns,
            _ => now_ns,
        };
        self.seen_ns = Some((first_ns, now_ns));
    }
}
