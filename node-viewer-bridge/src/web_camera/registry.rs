//! Which browser has which camera's name, and what waits for the network.

use sextant_proto::{CameraStatus, Observations, Preview};
use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::watch;

/// Browsers at a time.
const MAX_CAMERAS: usize = 32;
/// A name is its device's for so long after the device has gone: its screen may be dark, or its page in the background.
const NAME_KEPT: Duration = Duration::from_secs(600);
/// Names of devices that have gone; the one that is gone longest gives way.
const MAX_ABSENT: usize = 256;
/// What waits for the network: half a second of all of them, the oldest gives way.
const WAITING: StreamBounds = StreamBounds::new(1024, 16 << 20);

/// A message to be published.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outgoing {
    Observations(Observations),
    Status(Box<CameraStatus>),
    Preview(Preview),
}

impl Outgoing {
    pub(crate) fn camera(&self) -> &CameraId {
        match self {
            Self::Observations(message) => &message.camera,
            Self::Status(message) => &message.camera,
            Self::Preview(message) => &message.camera,
        }
    }
}

/// How far a browser has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum JoinState {
    /// Its name is being taken on the network.
    Waiting,
    Joined,
    /// Another connection with the same key has replaced this one.
    Replaced,
    /// Its link was freed for another device.
    Freed,
    /// The session is to end, with the cause.
    Ended(String),
}

/// Why a browser gets no place.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Rejected {
    /// The name is another device's.
    #[error("{0}")]
    Taken(String),
    /// As many as may be are there.
    #[error("{MAX_CAMERAS} browsers are cameras already")]
    Full,
}

/// Browsers that are cameras of the site.
#[derive(Debug)]
pub(crate) struct WebCameras {
    seats: Mutex<BTreeMap<CameraId, Seat>>,
    /// The keys of devices that have gone, and when. Locked after the seats.
    absent: Mutex<BTreeMap<CameraId, (String, Instant)>>,
    n_seats: AtomicU64,
    outgoing: Queue<Outgoing>,
}

#[derive(Debug)]
struct Seat {
    number: u64,
    /// Chosen by the browser, which may take its own name again before its former connection has ended.
    key: String,
    standing: watch::Sender<JoinState>,
}

impl Default for WebCameras {
    fn default() -> Self {
        Self {
            seats: Mutex::default(),
            absent: Mutex::default(),
            n_seats: AtomicU64::new(0),
            outgoing: Queue::new(WAITING, DropRule::Oldest),
        }
    }
}

/// A camera's place; left when it is dropped.
pub(crate) struct Place {
    cameras: Arc<WebCameras>,
    camera: CameraId,
    number: u64,
    pub(crate) standing: watch::Receiver<JoinState>,
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut seats = self.cameras.seats();
        let is_own = |seat: &Seat| seat.number == self.number;
        if seats.get(&self.camera).is_some_and(is_own)
            && let Some(seat) = seats.remove(&self.camera)
        {
            self.cameras.keep_name(&self.camera, seat, Instant::now());
        }
    }
}

impl WebCameras {
    /// A place for a browser under this name; `key` is what the browser shows when it comes back. The name stays its
    /// own for [`NAME_KEPT`] after it has gone.
    ///
    /// # Errors
    /// Why not.
    pub(crate) fn enter(
        self: &Arc<Self>,
        camera: CameraId,
        key: &str,
        now: Instant,
    ) -> Result<Place, Rejected> {
        let mut seats = self.seats();
        match seats.get(&camera) {
            Some(seat) if seat.key == key => {
                seat.standing.send_replace(JoinState::Replaced);
            }
            Some(_) => return Err(Rejected::Taken(taken(&camera))),
            None if seats.len() >= MAX_CAMERAS => return Err(Rejected::Full),
            None => self.check_absent(&camera, key, now)?,
        }
        let number = self.n_seats.fetch_add(1, Ordering::Relaxed);
        let (sender, standing) = watch::channel(JoinState::Waiting);
        let seat = Seat {
            number,
            key: key.to_owned(),
            standing: sender,
        };
        seats.insert(camera.clone(), seat);
        Ok(Place {
            cameras: Arc::clone(self),
            camera,
            number,
            standing,
        })
    }

    /// Whether a device that has gone lets this one have its name; if so, the name is no longer kept.
    fn check_absent(&self, camera: &CameraId, key: &str, now: Instant) -> Result<(), Rejected> {
        let mut absent = self.absent();
        absent.retain(|_, (_, gone)| now.saturating_duration_since(*gone) < NAME_KEPT);
        match absent.get(camera) {
            Some((owner, gone)) if owner != key => {
                let gone = now.saturating_duration_since(*gone);
                let left_min = (NAME_KEPT.saturating_sub(gone).as_secs() / 60) + 1;
                Err(Rejected::Taken(format!(
                    "the name {camera} is another device's, for {left_min} more min: choose another name"
                )))
            }
            _ => {
                absent.remove(camera);
                Ok(())
            }
        }
    }

    /// A device has gone and may come back.
    fn keep_name(&self, camera: &CameraId, seat: Seat, now: Instant) {
        // Another camera of the site has the name.
        if matches!(*seat.standing.borrow(), JoinState::Ended(_)) {
            return;
        }
        let mut absent = self.absent();
        if absent.len() >= MAX_ABSENT {
            let oldest = absent.iter().min_by_key(|(_, (_, gone))| *gone);
            let oldest = oldest.map(|(camera, _)| camera.clone());
            oldest.map(|camera| absent.remove(&camera));
        }
        absent.insert(camera.clone(), (seat.key, now));
    }

    /// Ends the connection of a browser whose link or name another device is to use.
    pub(crate) fn free(&self, camera: &CameraId) {
        let seat = self.seats().remove(camera);
        self.absent().remove(camera);
        if let Some(seat) = seat {
            seat.standing.send_replace(JoinState::Freed);
        }
    }

    fn absent(&self) -> MutexGuard<'_, BTreeMap<CameraId, (String, Instant)>> {
        self.absent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn seats(&self) -> MutexGuard<'_, BTreeMap<CameraId, Seat>> {
        self.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The cameras that are to be on the network.
    pub(crate) fn names(&self) -> Vec<CameraId> {
        let seats = self.seats();
        let is_wanted = |seat: &Seat| !matches!(*seat.standing.borrow(), JoinState::Ended(_));
        let wanted = seats.iter().filter(|(_, seat)| is_wanted(seat));
        wanted.map(|(camera, _)| camera.clone()).collect()
    }

    /// Tells a browser how far it has come.
    pub(crate) fn set(&self, camera: &CameraId, standing: JoinState) {
        if let Some(seat) = self.seats().get(camera) {
            seat.standing.send_if_modified(|now| {
                let is_news = *now != standing && !matches!(now, JoinState::Ended(_));
                if is_news {
                    *now = standing;
                }
                is_news
            });
        }
    }

    /// A message for the network.
    pub(crate) fn send(&self, message: Outgoing, bytes: usize) {
        self.outgoing.push(message, bytes);
    }

    /// The next message for the network.
    pub(crate) fn next(&self, wait: Duration) -> Option<Outgoing> {
        self.outgoing.pop_timeout(wait)
    }
}

/// Why a name cannot be had.
pub(crate) fn taken(camera: &CameraId) -> String {
    format!("a camera named {camera} is there already: choose another name")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(name: &str) -> CameraId {
        CameraId::new(name).unwrap()
    }

    #[test]
    fn a_name_has_one_browser_which_may_come_back() {
        let cameras = Arc::new(WebCameras::default());
        let now = Instant::now();
        let enter = |key: &str, now| cameras.enter(id("pocket"), key, now);
        let first = enter("a", now).unwrap();
        assert!(matches!(enter("b", now), Err(Rejected::Taken(_))));
        let again = enter("a", now).unwrap();
        assert_eq!(*first.standing.borrow(), JoinState::Replaced);
        drop(first);
        assert_eq!(cameras.names(), [id("pocket")]);
        cameras.set(&id("pocket"), JoinState::Joined);
        assert_eq!(*again.standing.borrow(), JoinState::Joined);
        drop(again);
        assert_eq!(cameras.names(), []);
    }

    #[test]
    fn a_name_stays_with_its_device_for_minutes_or_until_it_is_freed() {
        let cameras = Arc::new(WebCameras::default());
        let enter = |key: &str, now| cameras.enter(id("pocket"), key, now);
        let now = Instant::now();
        drop(enter("a", now).unwrap());
        let Err(refused) = enter("b", now + NAME_KEPT / 2) else {
            panic!()
        };
        assert!(
            refused.to_string().contains("choose another name"),
            "{refused}"
        );
        drop(enter("a", now + NAME_KEPT / 2).unwrap());
        drop(enter("b", Instant::now() + NAME_KEPT).unwrap());
        assert!(enter("a", Instant::now()).is_err());
        cameras.free(&id("pocket"));
        assert!(enter("a", Instant::now()).is_ok());
        // A name that another camera of the site has is nobody's here.
        let other = cameras.enter(id("north"), "a", now).unwrap();
        cameras.set(&id("north"), JoinState::Ended("taken".to_owned()));
        drop(other);
        assert!(cameras.enter(id("north"), "b", now).is_ok());
    }

    #[test]
    fn a_flood_of_names_and_keys_ends_at_the_bound() {
        let cameras = Arc::new(WebCameras::default());
        let now = Instant::now();
        let enter = |i: usize| cameras.enter(id(&format!("c{i}")), "a", now);
        let places: Vec<Place> = (0..2 * MAX_CAMERAS).filter_map(|i| enter(i).ok()).collect();
        assert_eq!(places.len(), MAX_CAMERAS);
        assert!(cameras.enter(id("z"), &"k".repeat(999), now).is_err());
        drop(places);
        for i in 0..2 * MAX_ABSENT {
            drop(enter(i));
            assert!(cameras.absent().len() <= MAX_ABSENT);
        }
    }
}
