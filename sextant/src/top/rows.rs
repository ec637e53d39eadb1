//! Rows of the table: one camera, one object, one process.

use sextant_proto::{CameraClock, CameraIntake, CameraStatus, ObjectPose};
use sextant_site_report::State;
use std::collections::VecDeque;

/// Window over which poses are counted.
const RATE_WINDOW_NS: u64 = 2_000_000_000;
/// Time without messages after which a node counts as silent.
pub const SILENCE_S: f64 = 3.0;

/// A camera.
#[derive(Debug, Default)]
pub struct CameraRow {
    /// Last status of its node.
    pub status: Option<CameraStatus>,
    /// Capture time of its newest image, ns; 0 before the first.
    pub last_capture_ns: u64,
    /// How the fusion node treats its messages.
    pub intake: Option<CameraIntake>,
    /// What its images reveal about its clock.
    pub clock: Option<CameraClock>,
    /// Arrival of its last own message, ns; 0 before the first.
    pub heard_ns: u64,
    /// Whether it is in the rig of a fusion node.
    pub in_rig: bool,
}

/// An object.
#[derive(Debug, Default)]
pub struct ObjectRow {
    /// The newest pose.
    pub pose: Option<Box<ObjectPose>>,
    /// Arrival times of the last poses, ns.
    arrivals_ns: VecDeque<u64>,
    /// Since when no fusion node has it any more, ns.
    pub gone_ns: Option<u64>,
}

/// A process of the site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeRow {
    /// Whether it is on the network.
    pub up: bool,
    /// Arrival of its last message, ns.
    pub heard_ns: u64,
}

impl CameraRow {
    /// Since when it has been silent; none if it was never heard or is not expected.
    pub fn gone_ns(&self, now_ns: u64) -> Option<u64> {
        let age_s = now_ns.saturating_sub(self.heard_ns) as f64 * 1e-9;
        (self.heard_ns > 0 && age_s > SILENCE_S).then_some(self.heard_ns)
    }
}

impl ObjectRow {
    /// Handles a pose that arrived at `now_ns`.
    pub fn take(&mut self, pose: ObjectPose, now_ns: u64) {
        self.pose = Some(Box::new(pose));
        self.arrivals_ns.push_back(now_ns);
        let since = now_ns.saturating_sub(RATE_WINDOW_NS);
        let is_old = |at: &u64| *at < since;
        while self.arrivals_ns.len() > 1 && self.arrivals_ns.front().is_some_and(is_old) {
            self.arrivals_ns.pop_front();
        }
    }

    /// Poses per second at `now_ns`.
    pub fn rate_hz(&self, now_ns: u64) -> f64 {
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

    /// The state; lost if no pose was published, or none recently.
    pub fn state(&self, now_ns: u64) -> State {
        let silent = self
            .arrivals_ns
            .back()
            .is_none_or(|last| now_ns.saturating_sub(*last) as f64 * 1e-9 > SILENCE_S);
        match &self.pose {
            Some(pose) if !silent => pose.state,
            _ => State::Lost,
        }
    }
}

impl Default for NodeRow {
    fn default() -> Self {
        Self {
            up: true,
            heard_ns: 0,
        }
    }
}
