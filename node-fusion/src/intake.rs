//! Decodes observations and counts, per camera, everything that is dropped.
//!
//! Input: key and payload as the network gave them. Output: the image's observation in the estimator's types, unless it
//! is too old. Knows neither network nor clock.

use crate::ages::Ages;
use sextant_process::ClockQuality;
use sextant_proto::{
    CameraIntake, ClockSource, InputSource, KeyRef, Keys, MAX_SLOW_CAMERAS, Notice, Observations,
    Rejections, decode,
};
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_model::{CameraId, ImageObservation};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Decodes messages and counts them per camera of the rig.
#[derive(Debug)]
pub struct Intake {
    keys: Keys,
    cameras: BTreeMap<CameraId, Counts>,
    arrivals: Arrivals,
    foreign: Rejections,
    /// How much older than usual an observation may be, ns.
    max_age_ns: u64,
}

/// How many messages have arrived on the key of each camera of the rig, also of those that this node drops unread.
/// Network threads count.
#[derive(Debug, Clone, Default)]
pub struct Arrivals(Arc<Mutex<BTreeMap<String, u64>>>);

impl Arrivals {
    /// Counts a message on `key`.
    pub fn count(&self, key: &str) {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = counts.get_mut(key) {
            *count += 1;
        }
    }

    fn counted(&self, key: &str) -> u64 {
        let counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        counts.get(key).copied().unwrap_or(0)
    }

    /// Other keys count now; those that stay keep their counts.
    fn take_keys(&self, keys: impl Iterator<Item = String>) {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let before = std::mem::take(&mut *counts);
        *counts = keys
            .map(|key| {
                let count = before.get(&key).copied().unwrap_or(0);
                (key, count)
            })
            .collect();
    }
}

/// An image that is taken in.
#[derive(Debug)]
pub struct AdmittedImage {
    /// What it shows.
    pub observation: ImageObservation,
    /// Which observations they are, for the log of inputs.
    pub source: InputSource,
}

/// When a message is read.
#[derive(Debug, Clone, Copy)]
pub struct Arrival {
    /// Wire time by this host's clock, ns.
    pub now_ns: u64,
    /// The monotonic clock, ns.
    pub monotonic_ns: u64,
    /// Quality of this host's clock.
    pub clock: ClockQuality,
    /// Whether this node is late itself: its machine stood still, or is too slow.
    pub is_stalled: bool,
}

impl Arrival {
    fn age_ns(&self, capture_ns: u64) -> i64 {
        let age = i128::from(self.now_ns) - i128::from(capture_ns);
        age.clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }

    /// Three standard deviations of the difference between this clock and a camera's; `None` where either is not
    /// disciplined.
    fn clocks_ns(&self, camera: sextant_proto::ClockQuality) -> Option<u64> {
        let disciplined = matches!(camera.source, ClockSource::Ntp | ClockSource::Ptp);
        let sigma_ns = camera.error_ns.saturating_add(self.clock.error_ns);
        (disciplined && self.clock.synchronised).then(|| sigma_ns.saturating_mul(3))
    }
}

/// Counters of one camera.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Counts {
    /// Messages accepted.
    pub received: u64,
    /// Messages dropped, by cause.
    pub rejected: Rejections,
    /// Observations that were too old on arrival.
    pub too_old: u64,
    ages: Ages,
    /// Of these, since the last status: by who was late.
    late: Late,
    /// Messages accepted at the last status.
    at_last_status: u64,
    /// Clock of the last message.
    clock_source: ClockSource,
    /// Messages that had arrived by the last status, read or not.
    arrived: u64,
    /// Time in which no message arrived, s.
    silent_s: f64,
}

/// Observations of one camera that were too old on arrival, since the last status, by who was late.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
struct Late {
    here: u64,
    at_camera: u64,
    on_the_way: u64,
    /// Longest time that the camera's machine took, ns.
    behind_ns: u64,
}

/// A camera that is silent for so long while others send is reported, s.
const SILENCE_S: f64 = SILENCE_NS as f64 * 1e-9;

impl Intake {
    /// An intake for the cameras of a rig; observations may be older than usual by `max_age_s` seconds.
    #[must_use]
    pub fn new(keys: Keys, cameras: impl IntoIterator<Item = CameraId>, max_age_s: f64) -> Self {
        let mut intake = Self {
            keys,
            cameras: BTreeMap::new(),
            arrivals: Arrivals::default(),
            foreign: Rejections::default(),
            max_age_ns: (max_age_s * 1e9) as u64,
        };
        intake.take_rig(cameras);
        intake
    }

    /// Where to count every message that arrives.
    #[must_use]
    pub fn arrivals(&self) -> Arrivals {
        self.arrivals.clone()
    }

    /// Forgets all ages after the host's clock was set.
    pub fn clock_stepped(&mut self) {
        for counts in self.cameras.values_mut() {
            counts.ages = Ages::default();
        }
    }

    /// The rig has other cameras now; those that stay keep their counts.
    pub fn take_rig(&mut self, cameras: impl IntoIterator<Item = CameraId>) {
        let mut before = std::mem::take(&mut self.cameras);
        let counts = |camera: CameraId| {
            let counts = before.remove(&camera).unwrap_or_default();
            (camera, counts)
        };
        self.cameras = cameras.into_iter().map(counts).collect();
        let keys = self.cameras.keys().map(|id| self.keys.observations(id));
        self.arrivals.take_keys(keys);
    }

    /// The observation of a message, or nothing and a count.
    pub fn take(&mut self, key: &str, payload: &[u8], arrival: Arrival) -> Option<AdmittedImage> {
        let Some(KeyRef::Observations(camera)) = self.keys.parse(key) else {
            self.foreign.wrong_kind = self.foreign.wrong_kind.saturating_add(1);
            return None;
        };
        let mut counts = self.cameras.get_mut(&camera);
        let message = match decode::<Observations>(payload) {
            Ok(message) if message.camera == camera => message,
            refused => {
                let rejected = counts.map_or(&mut self.foreign, |counts| &mut counts.rejected);
                match refused {
                    Ok(_) => rejected.wrong_camera = rejected.wrong_camera.saturating_add(1),
                    Err(why) => rejected.count(&why),
                }
                return None;
            }
        };
        match &mut counts {
            Some(counts) => counts.received = counts.received.saturating_add(1),
            None => self.foreign.wrong_camera = self.foreign.wrong_camera.saturating_add(1),
        }
        if counts.is_some_and(|counts| counts.is_too_old(&message, arrival, self.max_age_ns)) {
            return None;
        }
        Some(AdmittedImage {
            observation: ImageObservation::from(&message),
            source: InputSource::Image {
                camera,
                sequence: message.sequence,
                capture_ns: message.capture_ns,
            },
        })
    }

    /// A message that the network layer refused to copy because of its length.
    pub fn count_too_long(&mut self, key: &str) {
        let rejected = match self.keys.parse(key) {
            Some(KeyRef::Observations(camera)) => self
                .cameras
                .get_mut(&camera)
                .map(|counts| &mut counts.rejected),
            _ => None,
        };
        let rejected = rejected.unwrap_or(&mut self.foreign);
        rejected.too_long = rejected.too_long.saturating_add(1);
    }

    /// Messages dropped on keys of no camera of the rig.
    #[must_use]
    pub fn foreign(&self) -> Rejections {
        self.foreign
    }

    /// The cameras that used to send and are silent while others send; as of the last call of [`Self::cameras`].
    #[must_use]
    pub fn silent_cameras(&self) -> Vec<Notice> {
        if !self.cameras.values().any(|counts| counts.silent_s == 0.0) {
            // No camera sends: then no single one is at fault.
            return Vec::new();
        }
        let gone = |counts: &Counts| counts.arrived > 0 && counts.silent_s >= SILENCE_S;
        let silent = self.cameras.iter().filter(|(_, counts)| gone(counts));
        let notices = silent.map(|(camera, counts)| Notice::CameraSilent {
            camera: camera.clone(),
            silent_s: counts.silent_s,
        });
        notices.collect()
    }

    /// Observations that were dropped because this node has read them late; since the last call of [`Self::cameras`].
    #[must_use]
    pub fn late_here(&self) -> u64 {
        self.cameras.values().map(|counts| counts.late.here).sum()
    }

    /// The cameras with new observations that were too old on arrival, and not because of this node: since the last
    /// call of [`Self::cameras`].
    #[must_use]
    pub fn late_cameras(&self) -> Vec<Notice> {
        let cameras = self.cameras.iter();
        let late = cameras
            .clone()
            .filter(|(_, counts)| counts.late.on_the_way > 0);
        let late = late.map(|(camera, counts)| Notice::LateObservations {
            camera: camera.clone(),
            total: counts.too_old,
        });
        let slow = cameras.filter(|(_, counts)| counts.late.at_camera > 0);
        let (slow, behind_ns): (Vec<CameraId>, Vec<u64>) = slow
            .map(|(camera, counts)| (camera.clone(), counts.late.behind_ns))
            .take(MAX_SLOW_CAMERAS)
            .unzip();
        let slow = behind_ns.iter().max().map(|ns| Notice::CamerasSlow {
            cameras: slow,
            behind_s: *ns as f64 * 1e-9,
        });
        late.chain(slow).collect()
    }

    /// The cameras whose images are of a recording: their stamps say nothing about clocks of now.
    pub fn recorded_cameras(&self) -> impl Iterator<Item = &CameraId> {
        let recorded = self
            .cameras
            .iter()
            .filter(|(_, counts)| counts.clock_source == ClockSource::Recorded);
        recorded.map(|(camera, _)| camera)
    }

    /// The status lines of every camera, with rates over the `elapsed_s` since the last call.
    pub fn cameras(&mut self, elapsed_s: f64) -> Vec<CameraIntake> {
        let (keys, arrivals) = (&self.keys, &self.arrivals);
        self.cameras
            .iter_mut()
            .map(|(camera, counts)| {
                counts.note_arrivals(arrivals.counted(&keys.observations(camera)), elapsed_s);
                counts.status(camera, elapsed_s)
            })
            .collect()
    }
}

impl Counts {
    /// Whether an observation is too old; if so, it is counted.
    fn is_too_old(&mut self, message: &Observations, arrival: Arrival, max_age_ns: u64) -> bool {
        let excess_ns = self.ages.excess_ns(
            arrival.age_ns(message.capture_ns),
            arrival.monotonic_ns,
            arrival.clocks_ns(message.clock),
        );
        self.clock_source = message.clock.source;
        let is_too_old = u64::try_from(excess_ns).is_ok_and(|excess_ns| excess_ns > max_age_ns);
        if is_too_old {
            self.too_old += 1;
            self.late.count(message, arrival, max_age_ns);
        }
        is_too_old
    }

    /// A camera is silent while none of its messages arrives; whether they are read is this node's affair.
    fn note_arrivals(&mut self, arrived: u64, elapsed_s: f64) {
        self.silent_s = if arrived > self.arrived {
            0.0
        } else {
            self.silent_s + elapsed_s
        };
        self.arrived = arrived;
    }

    fn status(&mut self, camera: &CameraId, elapsed_s: f64) -> CameraIntake {
        let new = self.received - self.at_last_status;
        self.at_last_status = self.received;
        self.late = Late::default();
        CameraIntake {
            camera: camera.clone(),
            received: self.received,
            rejected: self.rejected,
            unknown_tags: 0,
            late: self.too_old,
            gated: 0,
            last_capture_ns: 0,
            rate_hz: if elapsed_s > 0.0 {
                (new as f64 / elapsed_s) as f32
            } else {
                0.0
            },
        }
    }
}

impl Late {
    fn count(&mut self, message: &Observations, arrival: Arrival, max_age_ns: u64) {
        let behind_ns = (message.timing.detected_ns).saturating_sub(message.capture_ns);
        if arrival.is_stalled {
            self.here += 1;
        } else if behind_ns > max_age_ns / 2 {
            self.at_camera += 1;
            self.behind_ns = self.behind_ns.max(behind_ns);
        } else {
            self.on_the_way += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{Timing, encode};

    fn intake() -> (Intake, String) {
        let keys = Keys::new("site").unwrap();
        let north = CameraId::new("north").unwrap();
        let key = keys.observations(&north);
        (Intake::new(keys, [north], 0.5), key)
    }

    /// Read so many ns after the capture of [`message`].
    fn after(age_ns: u64) -> Arrival {
        Arrival {
            now_ns: 1 + age_ns,
            monotonic_ns: 1_000_000_000,
            clock: ClockQuality {
                synchronised: true,
                error_ns: 0,
            },
            is_stalled: false,
        }
    }

    fn message(camera: &str) -> Vec<u8> {
        let message = Observations {
            camera: CameraId::new(camera).unwrap(),
            sequence: 1,
            capture_ns: 1,
            exposure_ns: 0,
            clock: sextant_proto::ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        };
        encode(&message).unwrap()
    }

    #[test]
    fn a_good_message_is_received() {
        let (mut intake, key) = intake();
        assert!(intake.take(&key, &message("north"), after(0)).is_some());
        let status = &intake.cameras(2.0)[0];
        assert_eq!((status.received, status.rate_hz), (1, 0.5));
    }

    #[test]
    fn what_was_held_up_is_dropped_and_counted_and_the_next_is_taken() {
        let (mut intake, key) = intake();
        let usual = message("north");
        assert!(intake.take(&key, &usual, after(20_000_000)).is_some());
        assert!(intake.take(&key, &usual, after(3_000_000_000)).is_none());
        assert!(intake.take(&key, &usual, after(500_000_000)).is_some());
        let late = Notice::LateObservations {
            camera: CameraId::new("north").unwrap(),
            total: 1,
        };
        assert_eq!(intake.late_cameras(), [late]);
        let status = &intake.cameras(1.0)[0];
        assert_eq!((status.received, status.late), (3, 1));
        assert_eq!(intake.late_cameras(), []);
        // By another clock the same age is usual.
        intake.clock_stepped();
        assert!(intake.take(&key, &usual, after(3_000_000_000)).is_some());
    }

    /// One cause, one notice: whoever was late is named, and nobody else.
    #[test]
    fn who_was_late_is_distinguished() {
        let (mut intake, key) = intake();
        let mut slow = decode::<Observations>(&message("north")).unwrap();
        let usual = encode(&slow).unwrap();
        slow.timing.detected_ns = slow.capture_ns + 2_500_000_000;
        let slow = encode(&slow).unwrap();
        let stalled = Arrival {
            is_stalled: true,
            ..after(3_000_000_000)
        };
        assert!(intake.take(&key, &usual, after(20_000_000)).is_some());
        assert!(intake.take(&key, &usual, stalled).is_none());
        assert_eq!((intake.late_here(), intake.late_cameras()), (1, vec![]));
        assert_eq!(intake.cameras(1.0)[0].late, 1);
        assert!(intake.take(&key, &slow, after(3_000_000_000)).is_none());
        let cameras_slow = Notice::CamerasSlow {
            cameras: vec![CameraId::new("north").unwrap()],
            behind_s: 2.5,
        };
        assert_eq!(intake.late_cameras(), [cameras_slow]);
        assert_eq!(intake.late_here(), 0);
    }

    #[test]
    fn where_both_clocks_are_disciplined_the_age_itself_counts() {
        let (mut intake, key) = intake();
        let mut held_up = decode::<Observations>(&message("north")).unwrap();
        let mut take = |source: ClockSource| {
            held_up.clock = sextant_proto::ClockQuality {
                source,
                error_ns: 1_000_000,
            };
            intake.clock_stepped();
            let bytes = encode(&held_up).unwrap();
            intake.take(&key, &bytes, after(3_000_000_000)).is_some()
        };
        assert!(!take(ClockSource::Ntp));
        assert!(take(ClockSource::FreeRunning));
        assert!(take(ClockSource::Unknown));
    }

    #[test]
    fn a_message_on_another_cameras_key_is_refused() {
        let (mut intake, key) = intake();
        assert!(intake.take(&key, &message("south"), after(0)).is_none());
        assert_eq!(intake.cameras(1.0)[0].rejected.wrong_camera, 1);
    }

    #[test]
    fn a_camera_that_falls_silent_is_named_until_it_is_back() {
        let keys = Keys::new("site").unwrap();
        let ids = ["north", "south", "never"].map(|id| CameraId::new(id).unwrap());
        let [north, south, _] = ids.each_ref().map(|id| keys.observations(id));
        let mut intake = Intake::new(keys, ids, 0.5);
        // What arrives is not read: this node is overloaded.
        let arrivals = intake.arrivals();
        arrivals.count(&south);
        for _ in 0..3 {
            arrivals.count(&north);
            intake.cameras(2.0);
        }
        let silent = Notice::CameraSilent {
            camera: CameraId::new("south").unwrap(),
            silent_s: 4.0,
        };
        assert_eq!(intake.silent_cameras(), [silent]);
        // Where nobody sends the network is at fault.
        intake.cameras(2.0);
        assert!(intake.silent_cameras().is_empty());
        arrivals.count(&south);
        arrivals.count(&north);
        intake.cameras(2.0);
        assert!(intake.silent_cameras().is_empty());
    }

    #[test]
    fn only_cameras_of_the_rig_are_counted() {
        let (mut intake, key) = intake();
        let arrivals = intake.arrivals();
        let stranger = key.replace("north", "south");
        (0..3).for_each(|_| arrivals.count(&key));
        (0..3).for_each(|_| arrivals.count(&stranger));
        assert_eq!(
            (arrivals.counted(&key), arrivals.counted(&stranger)),
            (3, 0)
        );
        intake.take_rig(["north", "south"].map(|id| CameraId::new(id).unwrap()));
        arrivals.count(&stranger);
        assert_eq!(
            (arrivals.counted(&key), arrivals.counted(&stranger)),
            (3, 1)
        );
    }

    #[test]
    fn cameras_that_stay_in_the_rig_keep_their_counts() {
        let (mut intake, key) = intake();
        intake.take(&key, &message("north"), after(0));
        let ids = ["north", "south"].map(|id| CameraId::new(id).unwrap());
        intake.take_rig(ids.clone());
        let received = |intake: &mut Intake| -> Vec<u64> {
            intake
                .cameras(1.0)
                .iter()
                .map(|camera| camera.received)
                .collect()
        };
        assert_eq!(received(&mut intake), [1, 0]);
        intake.take_rig(ids.into_iter().skip(1));
        assert_eq!(received(&mut intake), [0]);
    }

    #[test]
    fn garbage_of_a_camera_that_the_rig_lacks_is_counted_as_foreign() {
        let (mut intake, _) = intake();
        let key = "sextant/v1/site/camera/stranger/observations";
        assert!(intake.take(key, b"garbage", after(0)).is_none());
        intake.count_too_long(key);
        assert_eq!(
            (intake.foreign().bad_magic, intake.foreign().too_long),
            (1, 1)
        );
    }
}
