//! The session on a running site that every tool has: connecting, asking for last values, watching the router.

use crate::report::{Notice, objects_in_words};
use sextant_process::{Shutdown, monotonic_ns, now_ns};
use sextant_proto::{ANNOUNCED, KeyRef, Keys, Message, SiteId, limits};
use sextant_site_mirror::{Renewal, SiteMirror, Update};
use sextant_site_model::ObjectId;
use sextant_zenoh_bus::{
    AliveWatch, Bus, BusError, BusOptions, Item, Presence, Question, Role, Security, why_no_router,
};
use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a router may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// Timeout of a query for last values.
const ANSWER: Duration = Duration::from_secs(1);

/// A session on a site's network.
pub struct SiteSession {
    /// The network.
    pub bus: Bus,
    /// The site's keys.
    pub keys: Keys,
    /// The request to stop.
    pub shutdown: Shutdown,
    /// What the site lets this program do; none where members have no roles.
    pub role: Option<Role>,
}

/// Why there is no session.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// A request to stop came first.
    #[error("interrupted")]
    Interrupted,
    /// No router answers within three seconds.
    #[error("no router answers at {endpoint}")]
    NoRouter {
        /// The endpoint of the router.
        endpoint: String,
        /// Why, if that is known.
        cause: Option<String>,
    },
    /// The network refuses.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl SiteSession {
    /// Connects to the router of a site at the endpoint `connect`.
    ///
    /// # Errors
    /// See [`OpenError`].
    pub fn open(
        connect: &str,
        site: SiteId,
        security: &Security,
        shutdown: Shutdown,
    ) -> Result<Self, OpenError> {
        let deadline = Instant::now() + PATIENCE;
        let give_up = || shutdown.is_requested() || Instant::now() >= deadline;
        let options = BusOptions::client_of(connect);
        let bus = match Bus::open_unless(&options, security, &give_up) {
            Err(BusError::Abandoned { .. }) if shutdown.is_requested() => {
                return Err(OpenError::Interrupted);
            }
            Err(BusError::Abandoned { .. }) => {
                return Err(OpenError::NoRouter {
                    endpoint: connect.to_owned(),
                    cause: why_no_router(&options, security),
                });
            }
            opened => opened?,
        };
        Ok(Self {
            bus,
            keys: Keys::for_site(site),
            shutdown,
            role: security.role(),
        })
    }

    /// The site as its nodes answer: their tokens, and their last messages under these keys. Waits for a second at most
    /// a key.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn mirror(&self, keys: &[String]) -> Result<SiteMirror, BusError> {
        let mut mirror = SiteMirror::default();
        for token in self.bus.alive_keys(&self.keys.all_alive())? {
            take_token(&self.keys, &mut mirror, &Presence::Joined(token), now_ns());
        }
        for key in keys {
            for item in &self.last_items(key)? {
                take(&self.keys, &mut mirror, item, now_ns());
            }
        }
        Ok(mirror)
    }

    /// The sites that the router has where nothing runs on this one; none where something does. A router lets nobody
    /// see the sites of others without their keys.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn other_sites(&self) -> Result<BTreeSet<String>, BusError> {
        if !self.bus.alive_keys(&self.keys.all_alive())?.is_empty() {
            return Ok(BTreeSet::new());
        }
        let tokens = self.bus.alive_keys("sextant/v1/*/alive/*/*")?;
        let sites = tokens.iter().filter_map(|key| key.split('/').nth(2));
        Ok(sites.map(str::to_owned).collect())
    }

    /// The newest messages of a type under a key or several, in the order of the keys. Waits for a second at most.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn latest<M: Message>(&self, key: &str) -> Result<Vec<M>, BusError> {
        self.latest_within(key, ANSWER)
    }

    /// As [`Self::latest`], with another time limit.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn latest_within<M: Message>(
        &self,
        key: &str,
        timeout: Duration,
    ) -> Result<Vec<M>, BusError> {
        let items = self.bus.latest(key, limits::MAX_PAYLOAD_BYTES, timeout)?;
        Ok(items.iter().filter_map(|item| item.decode().ok()).collect())
    }

    fn last_items(&self, key: &str) -> Result<Vec<Item>, BusError> {
        self.bus.latest(key, limits::MAX_PAYLOAD_BYTES, ANSWER)
    }

    /// The objects that the site has. Takes up to two seconds.
    pub fn objects(&self) -> Vec<ObjectId> {
        let mirror = self.mirror(&[self.keys.all_config_objects()]);
        let mirror = mirror.unwrap_or_default();
        mirror.configs().map(|object| object.id.clone()).collect()
    }

    /// The objects that the site has, for a person who waits for messages of another one. Takes up to two seconds.
    pub fn objects_in_words(&self) -> String {
        objects_in_words(&self.objects())
    }
}

/// Asks for the models in force whenever they may have changed unnoticed.
#[derive(Debug)]
pub struct ModelWatch {
    key: String,
    tokens: AliveWatch,
    renewal: Mutex<Renewal<Item>>,
    question: Mutex<Option<Question>>,
}

impl ModelWatch {
    /// For the models under a key or several. Subscribe to them before.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn open(site: &SiteSession, key: String) -> Result<Self, BusError> {
        Ok(Self {
            key,
            tokens: site.bus.watch_alive(&site.keys.all_fusion_alive())?,
            renewal: Mutex::default(),
            question: Mutex::default(),
        })
    }

    /// Takes a message that was published: it is to be handled now if it is returned, else [`poll`](Self::poll) has it
    /// handled. Requests, which are not in force, are left out.
    pub fn admit(&self, keys: &Keys, item: Item) -> Option<Item> {
        if is_request(keys, &item) {
            return None;
        }
        let is_model = keys.parse(&item.key).is_some_and(|key| key.is_config());
        match is_model {
            true => self.renewal().hold(item),
            false => Some(item),
        }
    }

    /// Asks for the models where that is due, and has the answers handled when they are there. Call it several times a
    /// second; it does not wait.
    ///
    /// # Errors
    /// A session that is closed, and those of `handle`.
    pub fn poll<E: From<BusError>>(
        &self,
        site: &SiteSession,
        mut handle: impl FnMut(&Item) -> Result<(), E>,
    ) -> Result<(), E> {
        while let Some(presence) = self.tokens.try_recv() {
            if matches!(presence, Presence::Joined(_)) {
                self.renewal().joined();
            }
        }
        let is_connected = site.bus.is_connected();
        let mut question = self.question.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(asked) = &*question {
            let Some(items) = asked.poll() else {
                return Ok(());
            };
            *question = None;
            items.iter().try_for_each(&mut handle)?;
            let next_held = || self.renewal().next_held();
            while let Some(item) = next_held() {
                handle(&item)?;
            }
        }
        let mut renewal = self.renewal();
        renewal.link(is_connected);
        if renewal.take_due(monotonic_ns()) {
            drop(renewal);
            let longest = limits::MAX_PAYLOAD_BYTES;
            *question = Some(site.bus.ask_others(&self.key, longest, ANSWER)?);
        }
        Ok(())
    }

    /// Whether answers are waited for.
    pub fn is_asking(&self) -> bool {
        let question = self.question.lock();
        question.unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn renewal(&self) -> MutexGuard<'_, Renewal<Item>> {
        self.renewal.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Notices when the router goes out of reach, and when it is back.
#[derive(Debug, Default)]
pub struct RouterWatch {
    lost: Option<Instant>,
    is_reported: bool,
}

/// Time without a router before it is reported.
const HICCUP: Duration = Duration::from_secs(3);

impl RouterWatch {
    /// Seconds since the router is unreachable, if that is reported.
    pub fn silent_s(&mut self, bus: &Bus) -> Option<f64> {
        if bus.is_connected() {
            self.lost = None;
            return None;
        }
        let lost = *self.lost.get_or_insert_with(Instant::now);
        let silent = lost.elapsed();
        (silent >= HICCUP).then_some(silent.as_secs_f64())
    }

    /// One notice that the router is unreachable, and one that it is back.
    pub fn notice(&mut self, bus: &Bus) -> Option<Notice> {
        match self.silent_s(bus) {
            Some(seconds) if !self.is_reported => {
                self.is_reported = true;
                Some(Notice::RouterSilent { seconds })
            }
            None if self.is_reported && self.lost.is_none() => {
                self.is_reported = false;
                Some(Notice::RouterBack)
            }
            _ => None,
        }
    }
}

/// Hands a message that arrived at `now_ns` to a mirror of its site; returns what it brought. Refused ones change
/// nothing: `echo` and the statuses of the fusion nodes show them.
pub fn take(keys: &Keys, mirror: &mut SiteMirror, item: &Item, now_ns: u64) -> Option<Update> {
    let key = keys.parse(&item.key)?;
    let update = mirror.handle(now_ns, &key, item.sender.as_deref(), item.try_bytes());
    update.ok()
}

/// Hands a change of liveliness to a mirror of its site.
pub fn take_token(keys: &Keys, mirror: &mut SiteMirror, presence: &Presence, now_ns: u64) {
    let (Presence::Joined(key) | Presence::Left(key)) = presence;
    let Some(KeyRef::Alive(kind, id)) = keys.parse(key) else {
        return;
    };
    match presence {
        // Beyond the limit it is left out.
        Presence::Joined(_) => drop(mirror.handle_joined(now_ns, kind, &id)),
        Presence::Left(_) => mirror.handle_left(now_ns, kind, &id),
    }
}

/// A request to change a model, as opposed to what a fusion node announces to be in force.
pub fn is_request(keys: &Keys, item: &Item) -> bool {
    let about = keys.parse(&item.key);
    let sender = item.sender.as_deref().unwrap_or_default();
    about.is_some_and(|about| about.is_config()) && !sender.starts_with(ANNOUNCED)
}
