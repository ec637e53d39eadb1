//! The fixed lag of one object: images by capture time, with the track after each instant.
//!
//! A late image is inserted at its capture time and the instants after it are processed again, so that the result
//! depends on the capture times alone. Instants older than the window become the base, which is final.
//!
//! Instants are processed again only as far as an estimate is asked for: where a clock is ahead all images of the other
//! cameras are late, and each asks for its own instant only.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::Arc;

use sextant_geometry::Pose;

use crate::FusionOptions;
use crate::site::{ModelledSite, ObjectImage, SiteCamera};
use crate::tracker::report::{FinalisedInstant, report, report_loss};
use crate::tracker::track::Track;
use sextant_site_model::ObjectId;
use sextant_site_report::{ClockOffset, ObjectEstimate};

/// Cameras whose simultaneous images are processed jointly; further ones follow in the order of the rig, so that an
/// image costs no more than its own group.
const GROUP: usize = 8;

/// Capture time in ns, and group of cameras.
type Key = (u64, usize);

#[derive(Debug)]
struct Instant {
    /// By camera index: taken jointly.
    images: BTreeMap<usize, Arc<ObjectImage>>,
    /// Boxed, since the instants of a map are moved about.
    after: Box<Track>,
}

impl Instant {
    /// The track after its images.
    fn advance(
        &self,
        before: &Track,
        time_ns: u64,
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Box<Track> {
        let images: Vec<&ObjectImage> = self.images.values().map(Arc::as_ref).collect();
        Box::new(before.advance(time_ns, &images, site, options))
    }
}

/// The window of one object.
#[derive(Debug)]
pub(crate) struct Timeline {
    object: ObjectId,
    base: Track,
    instants: BTreeMap<Key, Instant>,
    /// First instant that lacks late images.
    stale_from: Option<Key>,
    /// Whether the instants were processed by former models.
    is_outdated: bool,
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
            is_outdated: false,
        }
    }

    pub fn object(&self) -> &ObjectId {
        &self.object
    }

    /// By camera index, as of the newest image gone through.
    pub fn clock_offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        self.processed().clock_offsets()
    }

    /// Inserts an image; the instants from it on are to be processed again. Returns the instants that leave the window.
    pub fn insert(
        &mut self,
        image: Arc<ObjectImage>,
        site: &ModelledSite,
        options: &FusionOptions,
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
            after: Box::default(),
        });
        instant.images.insert(image.camera_index, image);
        self.stale_from = Some(self.stale_from.map_or(key, |stale| stale.min(key)));
        Ok(self.forget(window_ns, site, options))
    }

    /// Processes the instants up to a time again, where late images have come for them.
    pub fn catch_up(&mut self, time_ns: u64, site: &ModelledSite, options: &FusionOptions) {
        let upto = (time_ns, usize::MAX);
        let Some(stale) = self.stale_from.filter(|stale| *stale <= upto) else {
            return;
        };
        let last_good = self.instants.range(..stale).next_back();
        let from = last_good.map_or(stale, |(key, _)| *key);
        let mut before = &self.base;
        for (key, instant) in self.instants.range_mut(from..=upto) {
            if *key >= stale {
                instant.after = instant.advance(before, key.0, site, options);
            }
            before = &instant.after;
        }
        let mut later = self
            .instants
            .range((Bound::Excluded(upto), Bound::Unbounded));
        self.stale_from = later.next().map(|(key, _)| *key);
    }

    /// The newest track that has all images.
    fn processed(&self) -> &Track {
        self.before(self.stale_from.unwrap_or((u64::MAX, usize::MAX)))
    }

    /// The track at or before an instant with all late images.
    fn processed_at(
        &self,
        time_ns: u64,
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Cow<'_, Track> {
        let upto = (time_ns, usize::MAX);
        let Some(stale) = self.stale_from.filter(|stale| *stale <= upto) else {
            return Cow::Borrowed(self.at(time_ns));
        };
        let mut track = Cow::Borrowed(self.before(stale));
        for ((time_ns, _), instant) in self.instants.range(stale..=upto) {
            track = Cow::Owned(*instant.advance(&track, *time_ns, site, options));
        }
        track
    }

    fn before(&self, key: Key) -> &Track {
        let before = self.instants.range(..key).next_back();
        before.map_or(&self.base, |(_, instant)| &instant.after)
    }

    /// Drops the instants older than the window, which no late image can change any more; the newest always stays. What
    /// former models made of them is not returned.
    fn forget(
        &mut self,
        window_ns: u64,
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Vec<FinalisedInstant> {
        let oldest = self.newest_ns().saturating_sub(window_ns);
        self.catch_up(oldest.saturating_sub(1), site, options);
        let mut finalised = Vec::new();
        while let Some(first) = self.instants.first_entry()
            && first.key().0 < oldest
        {
            let Instant { images, after } = first.remove();
            finalised.push(FinalisedInstant {
                track: after,
                images,
            });
        }
        if let Some(last) = finalised.last() {
            self.base.clone_from(&last.track);
        }
        if self.is_outdated {
            finalised.clear();
        }
        finalised
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
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        self.estimate_ahead(time_ns, 0.0, site, options)
    }

    /// The same after an image of a clock that is ahead by `ahead_s` seconds: at the time of its capture.
    pub fn estimate_ahead(
        &self,
        stamp_ns: u64,
        ahead_s: f64,
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let track = self.processed_at(stamp_ns, site, options);
        if !track.is_known_at(stamp_ns, options) {
            return None;
        }
        report(&track, &self.object, stamp_ns, ahead_s, options)
    }

    /// The last that is known of an object that was last seen before `time_ns`.
    pub fn last_estimate(&self, time_ns: u64, options: &FusionOptions) -> Option<ObjectEstimate> {
        report_loss(self.at(time_ns), &self.object, time_ns, options)
    }

    /// Discards the images and keeps the track: the models that they were taken in with are no longer in force. All
    /// instants must have been processed.
    pub fn discard_images(&mut self) {
        self.stale_from = None;
        self.is_outdated = false;
        if let Some((_, last)) = std::mem::take(&mut self.instants).into_iter().next_back() {
            self.base = *last.after;
        }
    }

    /// Another rig is in force: the track is moved along with the cameras that saw the object lately, and begins anew
    /// where they see it elsewhere now.
    pub fn take_rig(&mut self, before: &[SiteCamera], site: &ModelledSite) {
        self.base.take_rig(before, site);
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
            (&*instant.after, images)
        })
    }

    /// The models have been corrected: the tracks are moved along, until [`Self::reprocess`].
    pub fn remodel(&mut self, moved: Option<(Pose, Pose)>) {
        self.is_outdated = !self.instants.is_empty();
        let Some((before, after)) = moved else {
            return;
        };
        self.base.move_along(&before, &after);
        for instant in self.instants.values_mut() {
            instant.after.move_along(&before, &after);
        }
    }

    /// Whether the models have been corrected since the window was processed.
    pub fn is_outdated(&self) -> bool {
        self.is_outdated
    }

    /// Processes the window again by the models in force, from a base that has been moved along, where it is outdated.
    /// Returns the number of instants that were.
    pub fn reprocess(&mut self, site: &ModelledSite, options: &FusionOptions) -> usize {
        if !std::mem::take(&mut self.is_outdated) {
            return 0;
        }
        for instant in self.instants.values_mut() {
            for image in instant.images.values_mut() {
                *image = Arc::new(site.remodelled(image, options));
            }
        }
        self.stale_from = self.instants.keys().next().copied();
        self.catch_up(u64::MAX, site, options);
        self.instants.len()
    }

    /// Clocks may have jumped before the window, by a standard deviation of `sigma_s`: it is processed again.
    pub fn restart_clocks(&mut self, cameras: &[usize], sigma_s: f64) {
        self.base.restart_clocks(cameras, sigma_s);
        self.stale_from = self.instants.keys().next().copied();
    }

    /// From now on `by_s` seconds more are subtracted from the timestamps of a camera. As [`Self::discard_images`].
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        self.discard_images();
        self.base.shift_clock(camera_index, by_s);
    }
}
