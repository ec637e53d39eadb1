//! Each object as a tracker of PosiStageNet, by UDP to a multicast group or to one machine.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Gathering, Next, PoseReceiver};
use sextant_pose_streams::{Axes, PsnTrackers};
use sextant_process::now_ns;
use sextant_proto::ObjectPose;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_zenoh_bus::BusError;
use std::time::{Duration, Instant};

/// Between two packets with names.
const INFO: Duration = Duration::from_secs(1);

/// Sends frames of all trackers, and their names once a second.
#[derive(Debug)]
pub struct TrackerSender {
    trackers: PsnTrackers,
    target: DatagramTarget,
    gathering: Gathering,
    info_due: Instant,
}

impl TrackerSender {
    /// A sender of at most `rate_hz` frames a second. Objects are numbered in this order; all by name when none is
    /// named.
    pub fn new(axes: Axes, objects: &[ObjectId], target: DatagramTarget, rate_hz: f64) -> Self {
        Self {
            trackers: PsnTrackers::new(axes, objects, now_ns()),
            target,
            gathering: Gathering::new(rate_hz),
            info_due: Instant::now(),
        }
    }

    /// The counts at the end of a feed.
    pub fn counts(&self, feed: FeedCounts) -> SenderCounts {
        SenderCounts {
            feed,
            datagrams: self.target.counts(),
            skipped: 0,
        }
    }

    fn send_if_due(&mut self, now: Instant) {
        if self.gathering.is_due(now) {
            let packets = self.trackers.data(now_ns());
            packets.iter().for_each(|packet| self.target.send(packet));
        }
    }
}

impl PoseReceiver for TrackerSender {
    type Error = BusError;
    const WANTS_MODELS: bool = true;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        let (now, is_complete) = (Instant::now(), self.trackers.take(pose));
        self.gathering.note(now, is_complete);
        self.send_if_due(now);
        Ok(Next::More)
    }

    fn describe(&mut self, model: &ObjectModel) {
        self.trackers.add(model.id());
    }

    fn remove(&mut self, object: &ObjectId) {
        self.trackers.remove(object);
    }

    fn tick(&mut self) {
        let now = Instant::now();
        self.send_if_due(now);
        if now >= self.info_due {
            self.info_due = now + INFO;
            let packets = self.trackers.info(now_ns());
            packets.iter().for_each(|packet| self.target.send(packet));
        }
    }
}
