//! One object's last half second: images by capture time, with the track after each instant.
//!
//! A late image is put where it belongs and the instants after it are gone through again, so that what comes out depends
//! on the capture times alone. Instants older than the window become the base, which nothing changes any more.
//!
//! They are gone through again only as far as somebody looks: where a clock is ahead all images of the other cameras are late, and
//! each asks for its own instant only.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::Arc;

use sextant_geometry::Pose;

use crate::site::{ObjectImage, Site};
use crate::tracker::finalised_views::FinalisedView;
use crate::tracker::track::Track;
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

impl Instant {
    /// The track after its images.
    fn following(
        &self,
        before: &Track,
        time_ns: u64,
        site: &Site,
        options: &FusionOptions,
    ) -> Track {
        let images: Vec<&ObjectImage> = self.images.values().map(Arc::as_ref).collect();
        before.advanced(time_ns, &images, site, options)
    }
}

/// The window of one object.
#[derive(Debug)]
pub(crate) struct Timeline {
    object: ObjectId,
    base: Track,
    instants: BTreeMap<Key, Instant>,
    /// From here on the instants don't know yet of images that came late.
    stale_from: Option<Key>,
    /// Settled images of each camera, by its index.
    settled: Vec<usize>,
}

/// How closely views are looked at for what is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sampling {
    /// Each.
    All,
    /// Those of an image now and then, since a fault stays.
    Some,
}

/// Images of a camera of which one is looked at.
const NOW_AND_THEN: usize = 3;

/// What became of the views of an instant, for good.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FinalisedInstant {
    pub time_ns: u64,
    pub views: Vec<FinalisedView>,
    /// By camera index: taken jointly.
    pub images: BTreeMap<usize, Arc<ObjectImage>>,
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
            stale_from: None,
            settled: Vec::new(),
        }
    }

    pub fn object(&self) -> &ObjectId {
        &self.object
    }

    /// By camera index, as of the newest image gone through.
    pub fn clock_offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        self.gone_through().clock_offsets()
    }

    /// Inserts an image, from whose instant on all is to be gone through again. What is settled by that is returned.
    pub fn insert(
        &mut self,
        image: Arc<ObjectImage>,
        site: &Site,
        options: &FusionOptions,
        attention: Sampling,
    ) -> Result<Vec<FinalisedInstant>, TooLate> {
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
        self.stale_from = Some(self.stale_from.map_or(key, |stale| stale.min(key)));
        Ok(self.forget(window_ns, site, options, attention))
    }

    /// Goes through the instants up to a time, where late images have come for them.
    pub fn catch_up(&mut self, time_ns: u64, site: &Site, options: &FusionOptions) {
        let upto = (time_ns, usize::MAX);
        let Some(stale) = self.stale_from.filter(|stale| *stale <= upto) else {
            return;
        };
        let first = self.before(stale).clone();
        let mut before = &first;
        for ((time_ns, _), instant) in self.instants.range_mut(stale..=upto) {
            instant.after = instant.following(before, *time_ns, site, options);
            before = &instant.after;
        }
        let mut later = self
            .instants
            .range((Bound::Excluded(upto), Bound::Unbounded));
        self.stale_from = later.next().map(|(key, _)| *key);
    }

    /// The newest track that knows of all images.
    fn gone_through(&self) -> &Track {
        self.before(self.stale_from.unwrap_or((u64::MAX, usize::MAX)))
    }

    /// The track at or before an instant as it is once all late images are gone through.
    fn caught_up(&self, time_ns: u64, site: &Site, options: &FusionOptions) -> Cow<'_, Track> {
        let upto = (time_ns, usize::MAX);
        let Some(stale) = self.stale_from.filter(|stale| *stale <= upto) else {
            return Cow::Borrowed(self.at(time_ns));
        };
        let mut track = self.before(stale).clone();
        for ((time_ns, _), instant) in self.instants.range(stale..=upto) {
            track = instant.following(&track, *time_ns, site, options);
        }
        Cow::Owned(track)
    }

    fn before(&self, key: Key) -> &Track {
        let before = self.instants.range(..key).next_back();
        before.map_or(&self.base, |(_, instant)| &instant.after)
    }

    /// Drops the instants older than the window, which no late image can change any more; the newest always stays.
    fn forget(
        &mut self,
        window_ns: u64,
        site: &Site,
        options: &FusionOptions,
        attention: Sampling,
    ) -> Vec<FinalisedInstant> {
        let oldest = self.newest_ns().saturating_sub(window_ns);
        self.catch_up(oldest.saturating_sub(1), site, options);
        let kept = self.instants.split_off(&(oldest, 0));
        let gone = std::mem::replace(&mut self.instants, kept);
        let mut settled = Vec::with_capacity(gone.len());
        for ((time_ns, _), instant) in gone {
            let images: Vec<&ObjectImage> = instant.images.values().map(Arc::as_ref).collect();
            for image in &images {
                self.count(image.camera_index);
            }
            let asked = |camera: usize| {
                attention == Sampling::All || self.settled[camera].is_multiple_of(NOW_AND_THEN)
            };
            let views = instant.after.finalised_views(&images, site, options, asked);
            settled.push(FinalisedInstant {
                time_ns,
                views,
                images: instant.images,
            });
            self.base = instant.after;
        }
        settled
    }

    fn count(&mut self, camera_index: usize) {
        if self.settled.len() <= camera_index {
            self.settled.resize(camera_index + 1, camera_index);
        }
        self.settled[camera_index] += 1;
    }

    /// The track that no late image can change any more.
    pub fn finalised_track(&self) -> &Track {
        &self.base
    }

    /// Capture time of the newest image, 0 before the first.
    pub fn newest_ns(&self) -> u64 {
        self.instants
            .last_key_value()
            .map_or(self.base.time_ns, |((time_ns, _), _)| *time_ns)
    }

    /// The track at or before an instant, as far as it was gone through.
    pub fn at(&self, time_ns: u64) -> &Track {
        self.instants
            .range(..=(time_ns, usize::MAX))
            .next_back()
            .map_or(&self.base, |(_, instant)| &instant.after)
    }

    /// The estimate for an instant, from the images up to it.
    pub fn estimate(
        &self,
        time_ns: u64,
        site: &Site,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let track = self.caught_up(time_ns, site, options);
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

    /// Forgets the images, not what they taught: the models that they were read with are no longer in force. All must have been
    /// gone through.
    pub fn settle(&mut self) {
        self.stale_from = None;
        if let Some((_, last)) = std::mem::take(&mut self.instants).into_iter().next_back() {
            self.base = last.after;
        }
    }

    /// The instants after one time and before another, oldest first: the track after each, and its images.
    pub fn between(
        &self,
        after_ns: Option<u64>,
        before_ns: u64,
    ) -> impl Iterator<Item = (&Track, Vec<&ObjectImage>)> {
        let from = (after_ns.map_or(0, |after| after.saturating_add(1)), 0);
        let instants = self.instants.range(from..from.max((before_ns, 0)));
        instants.map(|(_, instant)| {
            let images = instant.images.values().map(Arc::as_ref).collect();
            (&instant.after, images)
        })
    }

    /// The models have been corrected: the window is gone through again with them, from a track that was moved along.
    pub fn remodel(&mut self, moved: Option<(Pose, Pose)>, site: &Site, options: &FusionOptions) {
        for instant in self.instants.values_mut() {
            for image in instant.images.values_mut() {
                *image = Arc::new(site.remodelled(image, options));
            }
        }
        if let Some((before, after)) = moved {
            self.base.move_along(&before, &after);
        }
        self.stale_from = self.instants.keys().next().copied();
    }

    /// Clocks may have jumped, by so many seconds (one sigma), before the window: it is to be gone through again.
    pub fn doubt_clocks(&mut self, cameras: &[usize], sigma_s: f64) {
        self.base.doubt_clocks(cameras, sigma_s);
        self.stale_from = self.instants.keys().next().copied();
    }

    /// So many seconds more are taken off a camera's stamps from now on. As [`Self::settle`].
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        self.settle();
        self.base.shift_clock(camera_index, by_s);
    }
}
