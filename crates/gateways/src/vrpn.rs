//! Each object as a tracker of a VRPN server.

mod dialler;
mod server;

pub use server::{ServerCounts, StartError};

use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use crate::report::Reporter;
use serde::Serialize;
use server::Server;
use sextant_pose_streams::{Axes, VrpnTrackers};
use sextant_proto::ObjectPose;
use sextant_zenoh_bus::BusError;
use std::net::{SocketAddr, TcpListener};
use std::time::Instant;

/// A VRPN server whose trackers are the objects.
#[derive(Debug)]
pub struct TrackerServer {
    trackers: VrpnTrackers,
    server: Server,
    limit: RateLimit,
}

/// Counts of a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TrackerCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Messages made of them, and their clients.
    #[serde(flatten)]
    pub server: ServerCounts,
    /// Poses held back by the rate limit.
    pub skipped: u64,
}

impl TrackerServer {
    /// Serves at most `rate_hz` poses a second of each object, at the address of a listener that does not block, by TCP
    /// and UDP.
    ///
    /// # Errors
    /// See [`StartError`].
    pub fn start(
        listener: TcpListener,
        axes: Axes,
        rate_hz: f64,
        reporter: Reporter,
    ) -> Result<Self, StartError> {
        Ok(Self {
            trackers: VrpnTrackers::new(axes),
            server: Server::start(listener, reporter)?,
            limit: RateLimit::new(rate_hz),
        })
    }

    /// Address that the server listens on.
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// The counts at the end of a feed.
    pub fn counts(&self, feed: FeedCounts) -> TrackerCounts {
        TrackerCounts {
            feed,
            server: self.server.counts(),
            skipped: self.limit.skipped,
        }
    }
}

impl PoseReceiver for TrackerServer {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if self.limit.admits(&pose.object, Instant::now())
            && let Some(report) = self.trackers.report(pose)
        {
            self.server.send(&report);
        }
        Ok(Next::More)
    }

    fn tick(&mut self) {
        self.server.turn(&self.trackers, Instant::now());
    }
}
