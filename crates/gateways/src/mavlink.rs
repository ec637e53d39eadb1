//! The pose of a vehicle as MAVLink `ODOMETRY`, by UDP to its autopilot, whose `TIMESYNC` requests are answered at once
//! by a thread.

use crate::datagrams::{DatagramTarget, SenderCounts};
use crate::pose_feed::{FeedCounts, Next, PoseReceiver, RateLimit};
use sextant_pose_streams::{LocalFrame, MavlinkSender, ResetCounter, Sender, timesync_requests};
use sextant_process::now_ns;
use sextant_proto::ObjectPose;
use sextant_zenoh_bus::BusError;
use std::io::{self, ErrorKind};
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// Longest wait for a request, after which the thread looks whether it shall end.
const LISTEN: Duration = Duration::from_millis(100);
/// Longest datagram that is read: some frames.
const MOST_BYTES: usize = 2048;

/// Sends the poses of a vehicle, and a heartbeat a second.
#[derive(Debug)]
pub struct OdometrySender {
    target: DatagramTarget,
    frames: Arc<Mutex<MavlinkSender>>,
    /// Ends the thread.
    stop: Arc<AtomicBool>,
    local: LocalFrame,
    resets: ResetCounter,
    limit: RateLimit,
    heartbeat_due: Instant,
}

impl OdometrySender {
    /// A sender of at most `rate_hz` poses a second, in the frame `local`.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(
        sender: Sender,
        local: LocalFrame,
        target: DatagramTarget,
        rate_hz: f64,
    ) -> io::Result<Self> {
        let frames = Arc::new(Mutex::new(MavlinkSender::new(sender)));
        let answers = Answers {
            socket: target.receiver()?,
            frames: Arc::clone(&frames),
            stop: Arc::default(),
        };
        let stop = Arc::clone(&answers.stop);
        Builder::new()
            .name("timesync".into())
            .spawn(move || answers.give())?;
        Ok(Self {
            target,
            frames,
            stop,
            local,
            resets: ResetCounter::default(),
            limit: RateLimit::new(rate_hz),
            heartbeat_due: Instant::now(),
        })
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

impl Drop for OdometrySender {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Answers to requests for our time. An autopilot believes them if they come within a few milliseconds.
struct Answers {
    socket: UdpSocket,
    frames: Arc<Mutex<MavlinkSender>>,
    stop: Arc<AtomicBool>,
}

impl Answers {
    fn give(self) {
        let mut datagram = [0; MOST_BYTES];
        let _ = self.socket.set_read_timeout(Some(LISTEN));
        while !self.stop.load(Ordering::Relaxed) {
            let received = match self.socket.recv(&mut datagram) {
                Ok(n_bytes) => &datagram[..n_bytes],
                Err(error) => {
                    // No receiver is bound there yet: the error is immediate.
                    if !matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) {
                        std::thread::sleep(LISTEN);
                    }
                    continue;
                }
            };
            for theirs in timesync_requests(received) {
                let frame = locked(&self.frames).timesync(now_ns(), theirs);
                let _ = self.socket.send(&frame);
            }
        }
    }
}

fn locked(frames: &Mutex<MavlinkSender>) -> MutexGuard<'_, MavlinkSender> {
    frames.lock().unwrap_or_else(PoisonError::into_inner)
}

impl PoseReceiver for OdometrySender {
    type Error = BusError;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        if let Some(resets) = self.resets.take(pose)
            && self.limit.admits(&pose.object, Instant::now())
        {
            let frame = locked(&self.frames).odometry(pose, &self.local, resets);
            self.target.send(&frame);
        }
        Ok(Next::More)
    }

    fn tick(&mut self) {
        if Instant::now() >= self.heartbeat_due {
            self.heartbeat_due = Instant::now() + HEARTBEAT;
            let frame = locked(&self.frames).heartbeat();
            self.target.send(&frame);
        }
    }
}
