//! The pose of a camera for virtual studios, by UDP: Free-D or OpenTrackIO.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use sextant_pose_streams::{FreeDCamera, OpenTrackIoCamera, freed_position};
use sextant_proto::ObjectPose;
use sextant_site_report::State;
use sextant_zenoh_bus::BusError;
use std::time::Instant;

/// A camera in the protocol of a studio.
#[derive(Debug)]
pub enum TrackedCamera {
    /// Message D1.
    FreeD(FreeDCamera),
    /// A sample in JSON.
    OpenTrackIo(OpenTrackIoCamera),
}

/// Sends the poses of a camera that are tracked or coasting.
#[derive(Debug)]
pub struct CameraSender {
    camera: TrackedCamera,
    target: DatagramTarget,
    limit: RateLimit,
}

impl CameraSender {
    /// A sender of at most `rate_hz` poses a second.
    pub fn new(camera: TrackedCamera, target: DatagramTarget, rate_hz: f64) -> Self {
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

impl PoseReceiver for CameraSender {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if matches!(pose.state, State::Tracking | State::Coasting)
            && self.limit.admits(&pose.object, Instant::now())
        {
            match &mut self.camera {
                TrackedCamera::FreeD(camera) => self.target.send(&freed_position(pose, camera)),
                TrackedCamera::OpenTrackIo(camera) => self.target.send(&camera.sample(pose)),
            }
        }
        Ok(Next::More)
    }
}
