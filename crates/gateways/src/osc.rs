//! Poses as Open Sound Control messages, by UDP to one machine.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use sextant_pose_streams::OscLayout;
use sextant_proto::ObjectPose;
use sextant_site_report::State;
use sextant_zenoh_bus::BusError;
use std::time::Instant;

/// Sends poses in a layout.
#[derive(Debug)]
pub struct OscSender {
    layout: OscLayout,
    target: DatagramTarget,
    limit: RateLimit,
}

impl OscSender {
    /// A sender of at most `rate_hz` poses a second of each object.
    pub fn new(layout: OscLayout, target: DatagramTarget, rate_hz: f64) -> Self {
        Self {
            layout,
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

impl PoseReceiver for OscSender {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        // The news that an object is lost is sent once, and never held back.
        if pose.state == State::Lost || self.limit.admits(&pose.object, Instant::now()) {
            for message in self.layout.messages(pose) {
                self.target.send(&message.to_bytes());
            }
        }
        Ok(Next::More)
    }
}
