//! Admission of images, and counts of those that are rejected.

use std::collections::{BTreeMap, BTreeSet};

use crate::site::{AssociatedImage, ModelledSite};
use crate::{CameraStatistics, FusionOptions, Statistics};
use sextant_site_model::{CameraId, ImageObservation};

/// Checks images against earlier ones, and counts.
#[derive(Debug)]
pub(crate) struct ImageIntake {
    statistics: Statistics,
    /// Capture times of each camera's images within the window, to know duplicates.
    recent_ns: BTreeMap<CameraId, BTreeSet<u64>>,
    /// When the last image of each camera of the rig arrived, ns.
    arrived_ns: BTreeMap<CameraId, u64>,
    /// Size of the last image of each camera whose images are of another size than the rig says.
    other_sizes: BTreeMap<CameraId, [u32; 2]>,
    /// When the clock was last set, by the clock as it is since; 0 where it never was.
    stepped_ns: u64,
}

/// Least time between two images of a camera, ns: no camera of a site is as fast as 500 images a second. It bounds how
/// many images a window holds, whatever their stamps say.
const LEAST_INTERVAL_NS: u64 = 2_000_000;
/// Most capture times remembered of a camera, however long the window.
const MOST_RECENT: usize = 4096;
/// After so long without an image nothing is known of a camera's images any more, ns.
const GONE_NS: u64 = 2_000_000_000;

impl ImageIntake {
    pub fn new(site: &ModelledSite) -> Self {
        let mut intake = Self {
            statistics: Statistics::default(),
            recent_ns: BTreeMap::new(),
            arrived_ns: BTreeMap::new(),
            other_sizes: BTreeMap::new(),
            stepped_ns: 0,
        };
        intake.rig_changed(site);
        intake
    }

    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    pub fn rig_changed(&mut self, site: &ModelledSite) {
        for camera in site.cameras() {
            self.statistics
                .cameras
                .entry(camera.id.clone())
                .or_default();
            self.recent_ns.entry(camera.id.clone()).or_default();
        }
        self.statistics
            .cameras
            .retain(|id, _| site.camera(id).is_some());
        self.recent_ns.retain(|id, _| site.camera(id).is_some());
        self.arrived_ns.retain(|id, _| site.camera(id).is_some());
        self.other_sizes.clear();
    }

    /// Notes that an image arrived at `now_ns`, whatever becomes of it.
    pub fn note_arrival(&mut self, now_ns: u64, camera: &CameraId, site: &ModelledSite) {
        if site.camera(camera).is_some() {
            self.arrived_ns.insert(camera.clone(), now_ns);
        }
    }

    /// Whether images of a camera of the rig arrive.
    pub fn is_present(&self, camera: &CameraId, now_ns: u64) -> bool {
        let arrived_ns = self.arrived_ns.get(camera);
        arrived_ns.is_some_and(|arrived_ns| now_ns < arrived_ns.saturating_add(GONE_NS))
    }

    /// When the first of the cameras whose images arrive will be gone if no other image comes, ns.
    pub fn next_gone_ns(&self, now_ns: u64) -> Option<u64> {
        let arrived_ns = self.arrived_ns.values();
        let gone_ns = arrived_ns.map(|arrived_ns| arrived_ns.saturating_add(GONE_NS));
        gone_ns.filter(|gone_ns| now_ns < *gone_ns).min()
    }

    /// Whether an image is of another size than the rig says, whose corners the lens can't place. Counts such images.
    pub fn is_of_other_size(&mut self, image: &ImageObservation, site: &ModelledSite) -> bool {
        let Some((_, camera)) = site.camera(&image.camera) else {
            return false;
        };
        match image.resolution.filter(|size| *size != camera.resolution) {
            Some(size) => {
                self.counts(&image.camera).other_size += 1;
                self.other_sizes.insert(image.camera.clone(), size);
                true
            }
            None => {
                self.other_sizes.remove(&image.camera);
                false
            }
        }
    }

    /// Cameras whose last image was of another size than the rig says, with that size.
    pub fn other_sizes(&self) -> impl Iterator<Item = (&CameraId, [u32; 2])> {
        self.other_sizes
            .iter()
            .map(|(camera, size)| (camera, *size))
    }

    /// The clock was set to `now_ns`: the capture times of former images are by another clock.
    pub fn clock_stepped(&mut self, now_ns: u64) {
        self.stepped_ns = now_ns;
        self.arrived_ns.clear();
    }

    /// Times before now can't be compared with those to come.
    pub fn forget_times(&mut self) {
        self.recent_ns.values_mut().for_each(BTreeSet::clear);
        for counts in self.statistics.cameras.values_mut() {
            counts.last_capture_ns = 0;
        }
    }

    /// Whether an image was under way when the clock was set. For a window after that, timestamps that do not lie
    /// between the step and the present are by the former clock. Counts such images.
    pub fn is_from_before_step(
        &mut self,
        now_ns: u64,
        image: &ImageObservation,
        options: &FusionOptions,
    ) -> bool {
        let window_ns = (options.window_s * 1e9) as u64;
        let is_recent = self.stepped_ns > 0 && now_ns < self.stepped_ns.saturating_add(window_ns);
        let is_before = is_recent && !(self.stepped_ns..=now_ns).contains(&image.capture_ns);
        if is_before && self.statistics.cameras.contains_key(&image.camera) {
            self.count_untimely(image, now_ns);
        }
        is_before
    }

    /// The views of an image by object, if it is admitted.
    pub fn admit(
        &mut self,
        now_ns: u64,
        image: &ImageObservation,
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Option<AssociatedImage> {
        let Some((index, camera)) = site.camera(&image.camera) else {
            self.statistics.unknown_cameras += 1;
            return None;
        };
        if camera.posed.is_none() {
            self.statistics.uncalibrated_cameras += 1;
            return None;
        }
        self.check_time(now_ns, image, options)?;
        let associated = site.associate(index, image, options);
        let counts = self.counts(&image.camera);
        counts.images += 1;
        counts.unknown_tags += associated.unknown_tags;
        counts.damaged_tags += associated.damaged_tags;
        counts.last_capture_ns = counts.last_capture_ns.max(image.capture_ns);
        Some(associated)
    }

    fn check_time(
        &mut self,
        now_ns: u64,
        image: &ImageObservation,
        options: &FusionOptions,
    ) -> Option<()> {
        if image.capture_ns > now_ns.saturating_add((options.ahead_s * 1e9) as u64) {
            self.counts(&image.camera).ahead += 1;
            return None;
        }
        let recent = self.recent_ns.entry(image.camera.clone()).or_default();
        let earliest = image.capture_ns.saturating_sub(LEAST_INTERVAL_NS - 1);
        let latest = image.capture_ns.saturating_add(LEAST_INTERVAL_NS - 1);
        if recent.range(earliest..=latest).next().is_some() {
            self.counts(&image.camera).duplicates += 1;
            return None;
        }
        recent.insert(image.capture_ns);
        let newest = recent.last().copied().unwrap_or(0);
        let oldest = newest.saturating_sub((options.window_s * 1e9) as u64);
        while recent.len() > MOST_RECENT || recent.first().is_some_and(|first| *first < oldest) {
            recent.pop_first();
        }
        if image.capture_ns < oldest {
            self.counts(&image.camera).late += 1;
            return None;
        }
        Some(())
    }

    /// Counts an image whose timestamp is too far from the present, or in doubt.
    pub fn count_untimely(&mut self, image: &ImageObservation, now_ns: u64) {
        let counts = self.counts(&image.camera);
        if image.capture_ns > now_ns {
            counts.ahead += 1;
        } else {
            counts.late += 1;
        }
    }

    pub fn count_late(&mut self, camera: &CameraId) {
        self.counts(camera).late += 1;
    }

    pub fn count_views(&mut self, camera: &CameraId, seen: usize, refused: usize) {
        let counts = self.counts(camera);
        counts.gated_tags += refused as u64;
        counts.used_tags += seen.saturating_sub(refused) as u64;
    }

    fn counts(&mut self, camera: &CameraId) -> &mut CameraStatistics {
        self.statistics.cameras.entry(camera.clone()).or_default()
    }
}
