//! The poses of a running site, one after the other, to a receiver: shared by the gateways that pass on poses only.

use crate::report::{Notice, Reporter};
use crate::site::{ModelWatch, RouterWatch, SiteSession, take};
use serde::Serialize;
use sextant_process::now_ns;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_proto::{AnyMessage, ObjectPose, limits};
use sextant_site_mirror::SiteMirror;
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_zenoh_bus::{BusError, DropRule, Item, Subscription};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Poses that wait while the receiver is slow; the oldest give way.
const QUEUE: usize = 1024;

/// Between two looks for the first models.
const MODELS_POLL: Duration = Duration::from_millis(5);

/// An output that poses are handed to, one after the other.
pub trait PoseReceiver {
    /// What ends the feed.
    type Error: From<BusError>;

    /// Takes a pose.
    ///
    /// # Errors
    /// What ends the feed.
    fn take(&mut self, pose: &ObjectPose) -> Result<Next, Self::Error>;

    /// Called several times a second, also without poses.
    fn tick(&mut self) {}

    /// Whether it is given models.
    const WANTS_MODELS: bool = false;

    /// Takes the model of a wanted object of the site: of each at the start, and of one that has changed.
    fn describe(&mut self, _model: &ObjectModel) {}

    /// A wanted object was removed from the site. It is described again when it comes back.
    fn remove(&mut self, _object: &ObjectId) {}
}

/// Whether a receiver takes more poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// It does.
    More,
    /// It has all that it wants.
    Done,
}

/// Counts of received poses since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct FeedCounts {
    /// Poses of the wanted objects.
    pub poses: u64,
    /// Payloads that are no pose of their key's object.
    pub refused: u64,
    /// Poses of a fusion node that another one has replaced.
    pub superseded: u64,
    /// Poses that gave way because the receiver was too slow, and those of more objects than are kept.
    pub dropped: u64,
}

/// Hands the poses of these objects to `receiver`, those of all objects when none is named, until `end`, a request to
/// stop, or the receiver is done. Closes the session unless it fails.
///
/// # Errors
/// A failed subscription, or an error of the receiver.
pub fn run<R: PoseReceiver>(
    site: SiteSession,
    objects: &[ObjectId],
    end: Option<Instant>,
    receiver: &mut R,
    reporter: &Reporter,
) -> Result<FeedCounts, R::Error> {
    let messages = subscribe(&site, objects)?;
    let models = R::WANTS_MODELS
        .then(|| ObjectModels::subscribe(&site))
        .transpose()?;
    let is_wanted = |object: &ObjectId| objects.is_empty() || objects.contains(object);
    let is_over = || end.is_some_and(|end| Instant::now() >= end);
    let (mut counts, mut mirror) = (FeedCounts::default(), SiteMirror::default());
    let mut router = RouterWatch::default();
    // Clients that are there at once are to find the models.
    if let Some(models) = &models {
        models.hand_on(&site, &mut mirror, &is_wanted, receiver)?;
        while models.watch.is_asking() && !site.shutdown.wait(MODELS_POLL) {
            models.hand_on(&site, &mut mirror, &is_wanted, receiver)?;
        }
    }
    let mut hint = NoPoseHint::new(objects);
    let mut next = Next::More;
    while next == Next::More && !site.shutdown.is_requested() && !is_over() {
        if let Some(item) = messages.recv_timeout(SHUTDOWN_POLL) {
            let update = take(&site.keys, &mut mirror, &item, now_ns());
            if let Some(AnyMessage::ObjectPose(pose)) = update.map(|update| update.message)
                && is_wanted(&pose.object)
            {
                counts.poses += 1;
                hint.saw(&pose.object);
                next = receiver.take(&pose)?;
            }
        }
        if let Some(models) = &models {
            models.hand_on(&site, &mut mirror, &is_wanted, receiver)?;
        }
        receiver.tick();
        if let Some(notice) = router.notice(&site.bus) {
            reporter.report(&notice);
        }
        if site.bus.is_connected() && hint.is_due(is_over()) {
            reporter.report(&Notice::NoPose {
                unseen: hint.unseen.clone(),
                objects: site.objects(),
            });
            hint.due = None;
        }
    }
    let rejections = mirror.rejections();
    counts.refused = rejections.invalid();
    counts.superseded = rejections.superseded();
    counts.dropped = messages.counts().dropped + rejections.too_many();
    site.bus.close();
    Ok(counts)
}

fn subscribe(site: &SiteSession, objects: &[ObjectId]) -> Result<Subscription, BusError> {
    let expression = match objects {
        [one] => site.keys.pose(one),
        _ => site.keys.all_poses(),
    };
    let most = limits::MAX_PAYLOAD_BYTES;
    site.bus
        .subscribe(&expression, QUEUE, DropRule::Oldest, most)
}

/// When to say that an object has no poses.
struct NoPoseHint {
    /// Wanted objects without a pose so far.
    unseen: Vec<ObjectId>,
    /// `None` once all have had one, or after it was said.
    due: Option<Instant>,
}

impl NoPoseHint {
    fn new(objects: &[ObjectId]) -> Self {
        Self {
            unseen: objects.to_vec(),
            due: Some(Instant::now() + Duration::from_nanos(SILENCE_NS)),
        }
    }

    fn saw(&mut self, object: &ObjectId) {
        self.unseen.retain(|unseen| unseen != object);
        self.due = self.due.filter(|_| !self.unseen.is_empty());
    }

    fn is_due(&self, is_over: bool) -> bool {
        self.due.is_some_and(|due| Instant::now() >= due || is_over)
    }
}

/// The models of a site's objects.
struct ObjectModels {
    changes: Subscription,
    watch: ModelWatch,
}

impl ObjectModels {
    fn subscribe(site: &SiteSession) -> Result<Self, BusError> {
        let key = site.keys.all_config_objects();
        let most = limits::MAX_PAYLOAD_BYTES;
        Ok(Self {
            changes: site.bus.subscribe(&key, QUEUE, DropRule::Oldest, most)?,
            watch: ModelWatch::open(site, key)?,
        })
    }

    /// Hands on what is new.
    fn hand_on<R: PoseReceiver>(
        &self,
        site: &SiteSession,
        mirror: &mut SiteMirror,
        is_wanted: &impl Fn(&ObjectId) -> bool,
        receiver: &mut R,
    ) -> Result<(), BusError> {
        let mut hand_on = |item: &Item| {
            let Some(update) = take(&site.keys, mirror, item, now_ns()) else {
                return;
            };
            let gone = update.gone.iter().filter(|object| is_wanted(object));
            gone.for_each(|object| receiver.remove(object));
            if let AnyMessage::ObjectConfig(config) = update.message
                && is_wanted(&config.id)
                && let Some(model) = mirror.object_model(&config.id)
            {
                receiver.describe(&model);
            }
        };
        let changes = std::iter::from_fn(|| self.changes.try_recv());
        changes
            .filter_map(|item| self.watch.admit(&site.keys, item))
            .for_each(|item| hand_on(&item));
        self.watch.poll(site, |item| {
            hand_on(item);
            Ok(())
        })
    }
}

/// Lets an object's poses through at most so often, evenly.
#[derive(Debug)]
pub struct RateLimit {
    period: Duration,
    due: BTreeMap<ObjectId, Instant>,
    /// Poses held back.
    pub skipped: u64,
}

impl RateLimit {
    /// At most `rate_hz` poses a second of each object; above 0.
    pub fn new(rate_hz: f64) -> Self {
        Self {
            period: Duration::from_secs_f64(1.0 / rate_hz),
            due: BTreeMap::new(),
            skipped: 0,
        }
    }

    /// Whether a pose that arrives `now` goes through. There are no more objects than a fusion node may have.
    pub fn admits(&mut self, object: &ObjectId, now: Instant) -> bool {
        let due = self.due.get(object).copied();
        let is_known = due.is_some() || self.due.len() < limits::MAX_OBJECTS;
        if !is_known || due.is_some_and(|due| now < due) {
            self.skipped += 1;
            return false;
        }
        // An early next pose after a late one, so that the rate is reached; at most by half a period.
        let start = due.unwrap_or(now).max(now - self.period / 2);
        self.due.insert(object.clone(), start + self.period);
        true
    }
}

/// How long a frame waits for the poses of further objects.
pub const GATHER: Duration = Duration::from_millis(2);

/// When a frame of the poses of several objects is sent: as soon as it is complete, or shortly after its first pose,
/// and at most so often.
#[derive(Debug)]
pub struct Gathering {
    period: Duration,
    due: Instant,
    /// Since when poses wait.
    waiting: Option<Instant>,
    is_complete: bool,
}

impl Gathering {
    /// At most `rate_hz` frames a second; above 0.
    pub fn new(rate_hz: f64) -> Self {
        Self {
            period: Duration::from_secs_f64(1.0 / rate_hz),
            due: Instant::now(),
            waiting: None,
            is_complete: false,
        }
    }

    /// A pose has arrived; `is_complete` where no further one is expected.
    pub fn note(&mut self, now: Instant, is_complete: bool) {
        self.waiting.get_or_insert(now);
        self.is_complete = is_complete;
    }

    /// Returns whether a frame is due, and begins the next period.
    pub fn is_due(&mut self, now: Instant) -> bool {
        let is_ripe = |since: Instant| now.saturating_duration_since(since) >= GATHER;
        let is_ready = self
            .waiting
            .is_some_and(|since| self.is_complete || is_ripe(since));
        if !is_ready || now < self.due {
            return false;
        }
        self.waiting = None;
        // An early next frame after a late one, by half a period at most, so that the rate is reached.
        self.due = self.due.max(now - self.period / 2) + self.period;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_reaches_its_rate_and_does_not_exceed_it() {
        for arrivals_hz in [20, 40, 100, 119] {
            let mut limit = RateLimit::new(30.0);
            let (cube, start) = (ObjectId::new("cube").unwrap(), Instant::now());
            let period = Duration::from_secs(1) / arrivals_hz;
            let passed = (0..10 * arrivals_hz).filter(|n| limit.admits(&cube, start + period * *n));
            let passed = passed.count();
            let wanted = 10 * arrivals_hz.min(30) as usize;
            assert!(passed <= wanted + 1 && passed + 10 >= wanted, "{passed}");
            assert_eq!(limit.skipped as usize + passed, 10 * arrivals_hz as usize);
        }
    }

    #[test]
    fn a_frame_waits_for_further_poses_a_little_and_keeps_to_its_rate() {
        let mut gathering = Gathering::new(100.0);
        let start = Instant::now();
        let ms = |ms| start + Duration::from_millis(ms);
        assert!(!gathering.is_due(ms(0)));
        gathering.note(ms(0), false);
        assert!(!gathering.is_due(ms(1)) && gathering.is_due(ms(2)));
        assert!(!gathering.is_due(ms(3)));
        gathering.note(ms(4), true);
        assert!(!gathering.is_due(ms(5)) && gathering.is_due(ms(12)));
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound() {
        let (mut limit, now) = (RateLimit::new(1.0), Instant::now());
        let ids = (0..4 * limits::MAX_OBJECTS).map(|n| ObjectId::new(&format!("o{n}")).unwrap());
        assert_eq!(
            ids.filter(|id| limit.admits(id, now)).count(),
            limits::MAX_OBJECTS
        );
        assert_eq!(limit.due.len(), limits::MAX_OBJECTS);
    }
}
