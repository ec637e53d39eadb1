//! From bytes on a key to an observation, or to a count: nothing that arrives is lost without a number.
//!
//! In: key and payload as the network gave them. Out: the image's observation in the estimator's types. Knows neither
//! network nor clock.

use sextant_estimator::{CameraId, ImageObservation};
use sextant_proto::{CameraIntake, KeyRef, Keys, Observations, Rejections, decode};
use std::collections::BTreeMap;

/// Takes messages apart and keeps count, per camera of the rig.
#[derive(Debug)]
pub struct Intake {
    keys: Keys,
    cameras: BTreeMap<CameraId, Counts>,
    foreign: Rejections,
}

/// What one camera sent.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Counts {
    /// Messages taken.
    pub received: u64,
    /// Messages dropped, by cause.
    pub rejected: Rejections,
    /// Messages taken when the last status was made.
    at_last_status: u64,
    /// Seconds of statuses without a message.
    silent_s: f64,
}

/// A camera that has sent nothing for so long while others do is named, s.
const SILENCE_S: f64 = 3.0;

impl Intake {
    /// An intake for the cameras of a rig.
    #[must_use]
    pub fn new(keys: Keys, cameras: impl IntoIterator<Item = CameraId>) -> Self {
        let cameras = cameras
            .into_iter()
            .map(|camera| (camera, Counts::default()))
            .collect();
        Self {
            keys,
            cameras,
            foreign: Rejections::default(),
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
    }

    /// The observation of a message, or nothing and a count.
    pub fn take(&mut self, key: &str, payload: &[u8]) -> Option<ImageObservation> {
        let Some(KeyRef::Observations(camera)) = self.keys.parse(key) else {
            self.foreign.wrong_kind = self.foreign.wrong_kind.saturating_add(1);
            return None;
        };
        let counts = self.cameras.get_mut(&camera);
        let (received, rejected) = match counts {
            Some(counts) => (Some(&mut counts.received), &mut counts.rejected),
            None => (None, &mut self.foreign),
        };
        match decode::<Observations>(payload) {
            Ok(message) if message.camera == camera => {
                match received {
                    Some(received) => *received = received.saturating_add(1),
                    None => rejected.wrong_camera = rejected.wrong_camera.saturating_add(1),
                }
                Some(ImageObservation::from(&message))
            }
            Ok(_) => {
                rejected.wrong_camera = rejected.wrong_camera.saturating_add(1);
                None
            }
            Err(why) => {
                rejected.count(&why);
                None
            }
        }
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

    /// The cameras that had sent and send no more while others do, in words; as of the last status lines.
    #[must_use]
    pub fn silences(&self) -> Vec<String> {
        if !self.cameras.values().any(|counts| counts.silent_s == 0.0) {
            // Nobody sends: that is no camera's fault.
            return Vec::new();
        }
        let gone = |counts: &Counts| counts.received > 0 && counts.silent_s >= SILENCE_S;
        let silent = self.cameras.iter().filter(|(_, counts)| gone(counts));
        let words = silent.map(|(camera, counts)| {
            let seconds = counts.silent_s;
            format!(
                "camera {camera} has sent nothing for {seconds:.0} s: is it on, and its network?"
            )
        });
        words.collect()
    }

    /// The status lines of every camera, with rates over the `elapsed_s` since the last call.
    pub fn cameras(&mut self, elapsed_s: f64) -> Vec<CameraIntake> {
        self.cameras
            .iter_mut()
            .map(|(camera, counts)| counts.status(camera, elapsed_s))
            .collect()
    }
}

impl Counts {
    fn status(&mut self, camera: &CameraId, elapsed_s: f64) -> CameraIntake {
        let new = self.received - self.at_last_status;
        self.at_last_status = self.received;
        self.silent_s = if new > 0 {
            0.0
        } else {
            self.silent_s + elapsed_s
        };
        CameraIntake {
            camera: camera.clone(),
            received: self.received,
            rejected: self.rejected,
            unknown_tags: 0,
            late: 0,
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

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ClockQuality, Timing, encode};

    fn intake() -> (Intake, String) {
        let keys = Keys::new("site").unwrap();
        let north = CameraId::new("north").unwrap();
        let key = keys.observations(&north);
        (Intake::new(keys, [north]), key)
    }

    fn message(camera: &str) -> Vec<u8> {
        let message = Observations {
            camera: CameraId::new(camera).unwrap(),
            sequence: 1,
            capture_ns: 1,
            exposure_ns: 0,
            clock: ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        };
        encode(&message).unwrap()
    }

    #[test]
    fn a_good_message_is_received() {
        let (mut intake, key) = intake();
        assert!(intake.take(&key, &message("north")).is_some());
        let status = &intake.cameras(2.0)[0];
        assert_eq!((status.received, status.rate_hz), (1, 0.5));
    }

    #[test]
    fn a_message_on_another_cameras_key_is_refused() {
        let (mut intake, key) = intake();
        assert!(intake.take(&key, &message("south")).is_none());
        assert_eq!(intake.cameras(1.0)[0].rejected.wrong_camera, 1);
    }

    #[test]
    fn a_camera_that_falls_silent_is_named_until_it_is_back() {
        let keys = Keys::new("site").unwrap();
        let ids = ["north", "south", "never"].map(|id| CameraId::new(id).unwrap());
        let key_of = |id: &CameraId| keys.observations(id);
        let (north, south) = (key_of(&ids[0]), key_of(&ids[1]));
        let mut intake = Intake::new(keys.clone(), ids);
        intake.take(&south, &message("south"));
        for _ in 0..3 {
            intake.take(&north, &message("north"));
            intake.cameras(2.0);
        }
        let told = intake.silences();
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(
            told[0].starts_with("camera south has sent nothing for 4 s"),
            "{told:?}"
        );
        // Where nobody sends the network is at fault.
        intake.cameras(2.0);
        assert!(intake.silences().is_empty());
        intake.take(&south, &message("south"));
        intake.take(&north, &message("north"));
        intake.cameras(2.0);
        assert!(intake.silences().is_empty());
    }

    #[test]
    fn cameras_that_stay_in_the_rig_keep_their_counts() {
        let (mut intake, key) = intake();
        intake.take(&key, &message("north"));
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
        assert!(intake.take(key, b"garbage").is_none());
        intake.count_too_long(key);
        assert_eq!(
            (intake.foreign().bad_magic, intake.foreign().too_long),
            (1, 1)
        );
    }
}
