//! Which browser has which camera's name, and what waits for the network.

use sextant_proto::{CameraStatus, Observations, Preview};
use sextant_queue::{DropRule, Queue, StreamBounds};
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// Browsers at a time.
const MAX_CAMERAS: usize = 32;
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

/// Browsers that are cameras of the site.
#[derive(Debug)]
pub(crate) struct WebCameras {
    seats: Mutex<BTreeMap<CameraId, Seat>>,
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
        if seats.get(&self.camera).is_some_and(is_own) {
            seats.remove(&self.camera);
        }
    }
}

impl WebCameras {
    /// A place for a browser under this name; `key` is what the browser shows when it comes back.
    ///
    /// # Errors
    /// In words for a person.
    pub(crate) fn enter(self: &Arc<Self>, camera: CameraId, key: &str) -> Result<Place, String> {
        let mut seats = self.seats();
        match seats.get(&camera) {
            Some(seat) if seat.key == key => {
                seat.standing.send_replace(JoinState::Replaced);
            }
            Some(_) => return Err(taken(&camera)),
            None if seats.len() >= MAX_CAMERAS => {
                return Err(format!("{MAX_CAMERAS} browsers are cameras already"));
            }
            None => {}
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

    /// Ends the connection of a browser whose link another device is to use.
    pub(crate) fn free(&self, camera: &CameraId) {
        if let Some(seat) = self.seats().remove(camera) {
            seat.standing.send_replace(JoinState::Freed);
        }
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
        let first = cameras.enter(id("pocket"), "a").unwrap();
        assert!(cameras.enter(id("pocket"), "b").is_err());
        let again = cameras.enter(id("pocket"), "a").unwrap();
        assert_eq!(*first.standing.borrow(), JoinState::Replaced);
        drop(first);
        assert_eq!(cameras.names(), [id("pocket")]);
        cameras.set(&id("pocket"), JoinState::Joined);
        assert_eq!(*again.standing.borrow(), JoinState::Joined);
        drop(again);
        assert_eq!(cameras.names(), []);
    }

    #[test]
    fn a_flood_of_names_and_keys_ends_at_the_bound() {
        let cameras = Arc::new(WebCameras::default());
        let enter = |i: usize| cameras.enter(id(&format!("c{i}")), "a");
        let places: Vec<Place> = (0..2 * MAX_CAMERAS).filter_map(|i| enter(i).ok()).collect();
        assert_eq!(places.len(), MAX_CAMERAS);
        assert!(cameras.enter(id("z"), &"k".repeat(999)).is_err());
        assert!(cameras.enter(id("z"), "").is_err());
    }
}
