//! Stamps are put right before anything else, and what contradicts is looked into: is it the clock?

use std::collections::{BTreeMap, BTreeSet};

use crate::clocks::offset_search::Arrival;
use crate::fusion::{Fusion, faults};
use crate::site::AssociatedImage;
use crate::tracker::timeline::Timeline;
use crate::{CameraId, ClockOffset, ImageObservation};

/// Seconds of an offset estimated by a filter from which on it is taken off the stamps instead: the motion between is taken
/// to be uniform there.
const FAR_S: f64 = 0.03;
/// Seconds (one sigma) to which it must be known for that, and seconds beyond which a filter may have been led astray.
const KNOWN_S: f64 = 0.001;
const ASTRAY_S: f64 = 0.06;
/// Nanoseconds between two looks at what the filters say.
const LOOK_NS: u64 = 100_000_000;

impl Fusion {
    /// The image with its stamp put right, unless it is kept from the tracks.
    pub(crate) fn correct_timestamp(
        &mut self,
        now_ns: u64,
        image: &ImageObservation,
    ) -> Option<ImageObservation> {
        let mut image = image.clone();
        let Some((index, _)) = self.site.camera(&image.camera) else {
            return Some(image);
        };
        self.clock_search.right(index, &mut image);
        self.clock_search.record(index, now_ns, image.capture_ns);
        let stated_s = image.clock_error_ns as f64 * 1e-9;
        let vouched = stated_s <= self.options.right_clock_s;
        self.clock_search.note_vouched(index, vouched);
        let ahead = image.capture_ns > now_ns.saturating_add((self.options.ahead_s * 1e9) as u64);
        let aside = self
            .clock_search
            .is_set_aside(index, &self.site, &self.options);
        if !ahead && !aside {
            return Some(image);
        }
        let associated = self.site.associate(index, &image, &self.options);
        self.intake.count_untimely(&image, now_ns);
        self.look_at_clock(index, &associated, Arrival::No);
        None
    }

    /// What an image says about the clocks, once it is taken in or not.
    pub(crate) fn look_at_clock(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        timely: Arrival,
    ) {
        let now_ns = self.now_ns;
        self.clock_search.count(camera_index, now_ns, timely);
        let contradicted = self.health.contradicted_cameras();
        let moved = self.health.moved_cameras().filter(|one| !one.timely);
        let suspects = contradicted
            .chain(moved.map(|one| one.camera))
            .chain(self.health.clocks());
        self.clock_search.suspect(now_ns, suspects);
        self.clock_search
            .watch(camera_index, associated, &self.site, &self.options);
        let found = self.clock_search.look(now_ns);
        if !found.is_empty() {
            self.begin_anew();
        }
    }

    /// What a camera contradicts may be its clock, whoever vouches for it. Where most cameras contradict, it is the tracks that are
    /// wrong.
    pub(crate) fn look_at_jumps(&mut self) {
        if 2 * self.health.contradicted_cameras().count() > self.clock_search.cameras() {
            return;
        }
        for camera in self.health.take_clocks() {
            let doubted = self.clock_search.doubted(camera, &self.site);
            self.doubt_clocks(&doubted);
        }
    }

    /// Clocks may have jumped by as much as clocks differ.
    fn doubt_clocks(&mut self, cameras: &[usize]) {
        let sigma_s = self.options.unknown_clock_s;
        for timeline in &mut self.timelines {
            timeline.doubt_clocks(cameras, sigma_s);
        }
    }

    /// What was learned with wrong stamps is worth nothing.
    pub(crate) fn begin_anew(&mut self) {
        self.health.reset();
        for timeline in &mut self.timelines {
            *timeline = Timeline::new(timeline.object().clone());
        }
    }

    /// What the filters say of clocks is looked at now and then. Offsets that have grown beyond what they are good at are
    /// taken off the stamps.
    pub(crate) fn look_at_estimates(&mut self) {
        let now_ns = self.now_ns;
        if now_ns < self.next_look_ns {
            return;
        }
        self.next_look_ns = now_ns.saturating_add(LOOK_NS);
        let estimated = self.estimated_offsets();
        let off = estimated.iter().filter(|(_, clock)| faults::is_off(clock));
        let off: BTreeSet<usize> = off.map(|(index, _)| *index).collect();
        self.clock_search.note_off(now_ns, &off);
        let contradicted: Vec<usize> = self.health.contradicted_cameras().collect();
        let mut steady: BTreeSet<usize> = self.clock_search.long_off(now_ns).collect();
        steady.retain(|camera| !contradicted.contains(camera));
        for (index, found) in estimated {
            let off_s = found.offset_s.abs();
            if off_s > ASTRAY_S {
                self.clock_search.ask(now_ns, [index].into_iter());
            } else if off_s > FAR_S && found.sigma_s < KNOWN_S && steady.contains(&index) {
                self.clock_search.add(index, found);
                self.health.forget_past();
                self.catch_up();
                for timeline in &mut self.timelines {
                    timeline.shift_clock(index, found.offset_s);
                }
            }
        }
    }

    /// What the filters estimate of the stamps as they are put right, by camera index.
    fn estimated_offsets(&self) -> BTreeMap<usize, ClockOffset> {
        let mut offsets: BTreeMap<usize, ClockOffset> = BTreeMap::new();
        for (camera, found) in self.timelines.iter().flat_map(Timeline::clock_offsets) {
            let known = offsets.entry(camera).or_insert(found);
            if found.sigma_s < known.sigma_s {
                *known = found;
            }
        }
        offsets
    }

    /// What the motion has told about the clocks of cameras: the sharpest estimate of all objects.
    pub fn clock_offsets(&self) -> BTreeMap<CameraId, ClockOffset> {
        let estimated = self.estimated_offsets();
        let mut offsets: BTreeMap<usize, ClockOffset> = self.clock_search.offsets().collect();
        for (camera, more) in estimated {
            let before = offsets.get(&camera).map_or(0.0, |found| found.offset_s);
            let offset_s = before + more.offset_s;
            offsets.insert(camera, ClockOffset { offset_s, ..more });
        }
        let named = offsets.into_iter().filter_map(|(index, offset)| {
            let camera = self.site.cameras().get(index)?;
            self.site.camera(&camera.id)?;
            Some((camera.id.clone(), offset))
        });
        named.collect()
    }
}
