//! Rows of the table: one camera, one object.

use sextant_proto::{CameraClock, CameraIntake, CameraStatus, ObjectPose};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::State;
use std::collections::VecDeque;

/// Window over which poses are counted.
const RATE_WINDOW_NS: u64 = 2_000_000_000;
/// Most poses that are counted in it.
const MOST_POSES: usize = 2048;

/// A camera's row of the board.
#[derive(Debug)]
pub struct CameraRow<'a> {
    /// Its name.
    pub id: &'a CameraId,
    /// Last status of its node.
    pub status: Option<&'a CameraStatus>,
    /// Capture time of its newest image, ns.
    pub last_capture_ns: Option<u64>,
    /// How the fusion node treats its messages.
    pub intake: Option<&'a CameraIntake>,
    /// What its images reveal about its clock.
    pub clock: Option<&'a CameraClock>,
    /// Since when it has been silent, ns; none if it was never heard.
    pub gone_ns: Option<u64>,
    /// Whether images are missing.
    pub lacks_images: bool,
}

/// An object's row of the board.
#[derive(Debug)]
pub struct ObjectRow<'a> {
    /// Its name.
    pub id: &'a ObjectId,
    /// The newest pose.
    pub pose: Option<&'a ObjectPose>,
    /// The state; lost if no pose was published, or none recently.
    pub state: State,
    /// Poses per second.
    pub rate_hz: f64,
    /// Since when no fusion node has it any more, ns.
    pub gone_ns: Option<u64>,
}

/// How often the poses of an object come.
#[derive(Debug, Default)]
pub struct PoseRate {
    arrivals_ns: VecDeque<u64>,
}

impl PoseRate {
    /// Counts a pose that arrived at `now_ns`.
    pub fn count(&mut self, now_ns: u64) {
        self.arrivals_ns.push_back(now_ns);
        let since = now_ns.saturating_sub(RATE_WINDOW_NS);
        let is_old = |at: &u64| *at < since;
        while self.arrivals_ns.len() > MOST_POSES
            || self.arrivals_ns.len() > 1 && self.arrivals_ns.front().is_some_and(is_old)
        {
            self.arrivals_ns.pop_front();
        }
    }

    /// Poses per second at `now_ns`.
    pub fn hz(&self, now_ns: u64) -> f64 {
        let since = now_ns.saturating_sub(RATE_WINDOW_NS);
        let recent = self.arrivals_ns.iter().filter(|at| **at > since);
        let (mut count, mut first) = (0_u32, None);
        for at in recent {
            count += 1;
            first = first.or(Some(*at));
        }
        // Counted since the first pose, so that the first seconds are correct, too.
        let span_s = first.map_or(0.0, |first| now_ns.saturating_sub(first) as f64 * 1e-9);
        if span_s > 0.0 {
            f64::from(count) / span_s.max(0.5)
        } else {
            0.0
        }
    }
}
