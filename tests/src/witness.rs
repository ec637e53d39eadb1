//! A subscriber that keeps every pose with the time of its arrival.

use sextant_process::now_ns;
use sextant_proto::{EpochFilter, Keys, ObjectPose, limits};
use sextant_zenoh_bus::{Bus, BusOptions, CallbackSubscription};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// A pose that arrived.
#[derive(Debug, Clone)]
pub struct Sight {
    /// When, by this machine's monotonic clock.
    pub at: Instant,
    /// When, ns since the Unix epoch.
    pub at_ns: u64,
    /// Whether a subscriber uses it: its epoch is not older than the newest so far.
    pub is_current: bool,
    /// The pose.
    pub pose: ObjectPose,
}

/// Watches all poses of a site.
pub struct Witness {
    sights: Arc<Mutex<Vec<Sight>>>,
    _subscription: CallbackSubscription,
    _bus: Bus,
}

impl Witness {
    /// A subscriber behind one of these routers.
    ///
    /// # Panics
    /// When none answers.
    #[must_use]
    pub fn start(keys: &Keys, routers: &[&str]) -> Self {
        Self::new(client_of(routers), keys)
    }

    /// A subscriber at this place on the network.
    ///
    /// # Panics
    /// When the network is gone.
    #[must_use]
    pub fn new(bus: Bus, keys: &Keys) -> Self {
        let sights: Arc<Mutex<Vec<Sight>>> = Arc::default();
        let (intake, epochs) = (Arc::clone(&sights), Mutex::new(EpochFilter::default()));
        let take = move |item: sextant_zenoh_bus::Item| {
            let (at, at_ns) = (Instant::now(), now_ns());
            let pose: ObjectPose = item.decode().expect("a pose");
            let mut epochs = epochs.lock().unwrap_or_else(PoisonError::into_inner);
            let is_current = epochs.admits(&pose.object, pose.epoch, at_ns);
            let mut sights = intake.lock().unwrap_or_else(PoisonError::into_inner);
            sights.push(Sight {
                at,
                at_ns,
                is_current,
                pose,
            });
        };
        let subscription = bus
            .subscribe_with(&keys.all_poses(), limits::MAX_PAYLOAD_BYTES, take)
            .expect("a subscription");
        Self {
            sights,
            _subscription: subscription,
            _bus: bus,
        }
    }

    /// Everything so far.
    #[must_use]
    pub fn sights(&self) -> Vec<Sight> {
        self.lock().clone()
    }

    /// What a subscriber used since then, in the order of arrival.
    #[must_use]
    pub fn used_since(&self, since: Instant) -> Vec<Sight> {
        let sights = self.lock();
        let used = sights
            .iter()
            .filter(|one| one.is_current && one.at >= since);
        used.cloned().collect()
    }

    /// Waits for a pose after `since` that is as wanted; returns when it arrived.
    ///
    /// # Panics
    /// When there is none in time.
    pub fn await_pose(&self, since: Instant, wanted: impl Fn(&ObjectPose) -> bool) -> Instant {
        let mut found = None;
        crate::fault_proxy::until("such a pose", || {
            let sights = self.lock();
            let mut late = sights.iter().rev().take_while(|one| one.at >= since);
            found = late
                .by_ref()
                .filter(|one| wanted(&one.pose))
                .last()
                .map(|one| one.at);
            found.is_some()
        });
        found.expect("it was found")
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Sight>> {
        self.sights.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A session that goes on with another of these routers when one dies.
pub(crate) fn client_of(routers: &[&str]) -> Bus {
    let options = BusOptions {
        connect: Some(routers.iter().map(|&router| router.to_owned()).collect()),
        ..BusOptions::default()
    };
    Bus::open(&options).expect("a router answers")
}
