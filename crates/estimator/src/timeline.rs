//! One object's last half second: images by capture time, with the track after each instant.
//!
//! A late image is put where it belongs and the instants after it are gone through again, so that what comes out depends
//! on the capture times alone. Instants older than the window become the base, which nothing changes any more.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::health::SettledView;
use crate::site::{ObjectImage, Site};
use crate::track::Track;
use crate::{ClockOffset, FusionOptions, ObjectEstimate, ObjectId};

/// Cameras whose simultaneous images are taken jointly; further ones follow in the order of the rig, so that one more
/// image of an instant costs no more than its own group.
const GROUP: usize = 8;

/// Capture time in ns, and group of cameras.
type Key = (u64, usize);

#[derive(Debug)]
struct Instant {
    /// By camera index: taken jointly.
    images: BTreeMap<usize, Arc<ObjectImage>>,
    after: Track,
}

/// The window of one object.
#[derive(Debug)]
pub(crate) struct Timeline {
    object: ObjectId,
    base: Track,
    instants: BTreeMap<Key, Instant>,
}

/// What became of the views of an instant, for good.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled {
    pub time_ns: u64,
    pub views: Vec<SettledView>,
}

/// An image that came too late to be inserted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TooLate;

impl Timeline {
    pub fn new(object: ObjectId) -> Self {
        Self {
            object,
            base: Track::default(),
            instants: BTreeMap::new(),
        }
    }

    pub fn object(&self) -> &ObjectId {
        &self.object
    }

    /// By camera index, as of the newest image.
    pub fn clock_offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        self.at(u64::MAX).clock_offsets()
    }

    /// Inserts an image and goes through the instants from its own on.
    pub fn insert(
        &mut self,
        image: Arc<ObjectImage>,
        site: &Site,
        options: &FusionOptions,
    ) -> Result<Vec<Settled>, TooLate> {
        let time_ns = image.capture_ns;
        let window_ns = (options.window_s * 1e9) as u64;
        let too_old = time_ns.saturating_add(window_ns) < self.newest_ns();
        if too_old || (self.base.time_ns > 0 && time_ns <= self.base.time_ns) {
            return Err(TooLate);
        }
        let key = (time_ns, image.camera_index / GROUP);
        let instant = self.instants.entry(key).or_insert_with(|| Instant {
            images: BTreeMap::new(),
            after: Track::default(),
        });
        instant.images.insert(image.camera_index, image);
        self.replay(key, site, options);
        Ok(self.forget(window_ns, site))
    }

    fn replay(&mut self, from: Key, site: &Site, options: &FusionOptions) {
        let first = self.before(from).clone();
        let mut before = &first;
        for ((time_ns, _), instant) in self.instants.range_mut(from..) {
            let images: Vec<&ObjectImage> = instant.images.values().map(Arc::as_ref).collect();
            instant.after = before.advanced(*time_ns, &images, site, options);
            before = &instant.after;
        }
    }

    fn before(&self, key: Key) -> &Track {
        let before = self.instants.range(..key).next_back();
        before.map_or(&self.base, |(_, instant)| &instant.after)
    }

    /// Drops the instants older than the window, which no late image can change any more; the newest always stays.
    fn forget(&mut self, window_ns: u64, site: &Site) -> Vec<Settled> {
        let oldest = self.newest_ns().saturating_sub(window_ns);
        let kept = self.instants.split_off(&(oldest, 0));
        let gone = std::mem::replace(&mut self.instants, kept);
        let settled = gone.iter().map(|((time_ns, _), instant)| Settled {
            time_ns: *time_ns,
            views: instant
                .after
                .settled_views(instant.images.values().map(Arc::as_ref), site),
        });
        let settled = settled.collect();
        if let Some((_, last)) = gone.into_iter().next_back() {
            self.base = last.after;
        }
        settled
    }

    /// Capture time of the newest image, 0 before the first.
    pub fn newest_ns(&self) -> u64 {
        self.instants
            .last_key_value()
            .map_or(self.base.time_ns, |((time_ns, _), _)| *time_ns)
    }

    /// The track at or before an instant.
    pub fn at(&self, time_ns: u64) -> &Track {
        self.instants
            .range(..=(time_ns, usize::MAX))
            .next_back()
            .map_or(&self.base, |(_, instant)| &instant.after)
    }

    /// The estimate for an instant, from the images up to it.
    pub fn estimate(&self, time_ns: u64, options: &FusionOptions) -> Option<ObjectEstimate> {
        let track = self.at(time_ns);
        if !track.is_known_at(time_ns, options) {
            return None;
        }
        track.estimate(&self.object, time_ns, options)
    }

    /// The last that is known of an object that was last seen before `time_ns`.
    pub fn last_estimate(&self, time_ns: u64, options: &FusionOptions) -> Option<ObjectEstimate> {
        self.at(time_ns)
            .last_estimate(&self.object, time_ns, options)
    }

    /// Forgets the images, not what they taught: the models that they were read with are no longer in force.
    pub fn settle(&mut self) {
        if let Some((_, last)) = std::mem::take(&mut self.instants).into_iter().next_back() {
            self.base = last.after;
        }
    }

    /// So many seconds more are taken off a camera's stamps from now on.
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        self.settle();
        self.base.shift_clock(camera_index, by_s);
    }
}
