//! The pose of a vehicle as MAVLink `ODOMETRY`, by UDP to its autopilot.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use sextant_pose_formats::{LocalFrame, MavlinkSender, ResetCounter, Sender};
use sextant_proto::ObjectPose;
use sextant_zenoh_bus::BusError;
use std::time::{Duration, Instant};

/// Between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// Sends the poses of a vehicle, and a heartbeat a second.
#[derive(Debug)]
pub struct OdometrySender {
    target: DatagramTarget,
    frames: MavlinkSender,
    local: LocalFrame,
    resets: ResetCounter,
    limit: RateLimit,
    heartbeat_due: Instant,
}

impl OdometrySender {
    /// A sender of at most `rate_hz` poses a second, in the frame `local`.
    pub fn new(sender: Sender, local: LocalFrame, target: DatagramTarget, rate_hz: f64) -> Self {
        Self {
            target,
            frames: MavlinkSender::new(sender),
            local,
            resets: ResetCounter::default(),
            limit: RateLimit::new(rate_hz),
            heartbeat_due: Instant::now(),
        }
    }

    /// The counts at the end of a feed.
    pub fn counts(&self, feed: FeedCounts) -> SenderCounts {
        SenderCounts {
            feed,
            datagrams: self.target.counts(),
            skipped: self.limit.skipped,
        }
    }
}

impl PoseReceiver for OdometrySender {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if let Some(resets) = self.resets.take(pose)
            && self.limit.admits(&pose.object, Instant::now())
        {
            let frame = self.frames.odometry(pose, &self.local, resets);
            self.target.send(&frame);
        }
        Ok(Next::More)
    }

    fn tick(&mut self) {
        if Instant::now() >= self.heartbeat_due {
            self.heartbeat_due = Instant::now() + HEARTBEAT;
            let frame = self.frames.heartbeat();
            self.target.send(&frame);
        }
    }
}
