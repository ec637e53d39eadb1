//! The pose of a camera as Free-D messages, by UDP to one machine.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use sextant_pose_formats::{FreeDCamera, freed_position};
use sextant_proto::ObjectPose;
use sextant_site_report::State;
use sextant_zenoh_bus::BusError;
use std::time::Instant;

/// Sends the poses of a camera that are tracked or coasting.
#[derive(Debug)]
pub struct FreeDSender {
    camera: FreeDCamera,
    target: DatagramTarget,
    limit: RateLimit,
}

impl FreeDSender {
    /// A sender of at most `rate_hz` poses a second.
    pub fn new(camera: FreeDCamera, target: DatagramTarget, rate_hz: f64) -> Self {
        Self {
            camera,
            target,
            limit: RateLimit::new(rate_hz),
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

impl PoseReceiver for FreeDSender {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if matches!(pose.state, State::Tracking | State::Coasting)
            && self.limit.admits(&pose.object, Instant::now())
        {
            self.target.send(&freed_position(pose, &self.camera));
        }
        Ok(Next::More)
    }
}
