//! Correction of timestamps, and the clock offsets that are published.

use std::collections::{BTreeMap, BTreeSet};

use crate::clocks::offset_search::Arrival;
use crate::diagnosis::Action;
use crate::fusion::RigFusion;
use crate::site::AssociatedImage;
use crate::tracker::timeline::Timeline;
use sextant_site_model::{CameraId, ImageObservation};
use sextant_site_report::ClockOffset;

/// Offset estimated by a filter from which on it is subtracted from the timestamps instead, s, so that poses have the
/// time of the reference clock, and since the filter assumes uniform motion within it.
const FAR_S: f64 = 0.004;
/// Standard deviation that such an offset needs, s, and how many of its own it exceeds; and offset beyond which a
/// filter may have been led astray, s.
const KNOWN_S: f64 = 0.003;
const SIGNIFICANT: f64 = 4.0;
const ASTRAY_S: f64 = 0.06;
/// Change of this host's offset to the cameras' clocks from which on earlier times can't be compared with later ones,
/// ns.
const MOST_HOST_CHANGE_NS: u64 = 500_000_000;
/// Time between two evaluations of the estimated offsets, ns.
const PERIOD_NS: u64 = 100_000_000;

/// Whether an offset is large and certain enough to be subtracted from the timestamps.
fn is_far(offset: &ClockOffset) -> bool {
    let off_s = offset.offset_s.abs();
    off_s > FAR_S && offset.sigma_s < KNOWN_S.min(off_s / SIGNIFICANT)
}

/// By which factor estimates of one offset differ more than their sigmas say; 1 where they do not.
fn disagreement(estimates: &[ClockOffset]) -> f64 {
    let weight = |one: &ClockOffset| one.sigma_s.powi(-2);
    let weights: f64 = estimates.iter().map(weight).sum();
    let weighted = estimates.iter().map(|one| weight(one) * one.offset_s);
    let mean_s = weighted.sum::<f64>() / weights;
    let squares = estimates
        .iter()
        .map(|one| weight(one) * (one.offset_s - mean_s).powi(2));
    let chi_squared: f64 = squares.sum();
    let degrees = estimates.len().saturating_sub(1).max(1);
    (chi_squared / degrees as f64).sqrt().max(1.0)
}

impl RigFusion {
    /// Offset of a camera's clock as the filter of an object estimates it, s; zero unless [`is_far`]. Until it is
    /// subtracted from the timestamps, it is subtracted from the times of published poses.
    pub(crate) fn ahead_s(&self, object: usize, camera_index: usize) -> f64 {
        let mut offsets = self.timelines[object].clock_offsets();
        let own = offsets.find(|(camera, _)| *camera == camera_index);
        let far = own.filter(|(_, offset)| is_far(offset));
        far.map_or(0.0, |(_, offset)| offset.offset_s)
    }

    /// The image with its timestamp corrected; `None` if it is kept from the tracks.
    pub(crate) fn correct_timestamp(
        &mut self,
        now_ns: u64,
        image: &ImageObservation,
    ) -> Option<ImageObservation> {
        let mut image = image.clone();
        let Some((index, _)) = self.site.camera(&image.camera) else {
            return Some(image);
        };
        self.offset_search.correct(index, &mut image);
        let host_offset_ns = self.offset_search.host_offset_ns();
        self.offset_search
            .record(index, now_ns, image.capture_ns, &self.options);
        if host_offset_ns.abs_diff(self.offset_search.host_offset_ns()) > MOST_HOST_CHANGE_NS {
            self.forget_times();
        }
        let stated_s = image.clock_error_ns as f64 * 1e-9;
        let is_verified = stated_s <= self.options.right_clock_s;
        self.offset_search.note_verified(index, is_verified);
        let present_ns = self.present_ns();
        let ahead =
            image.capture_ns > present_ns.saturating_add((self.options.ahead_s * 1e9) as u64);
        let aside = self.offset_search.is_set_aside(index, now_ns, &self.site);
        if !ahead && !aside {
            return Some(image);
        }
        let associated = self.site.associate(index, &image, &self.options);
        self.intake.count_untimely(&image, present_ns);
        self.update_clock_search(index, &associated, Arrival::No);
        None
    }

    /// The present by the clocks of most cameras, ns.
    pub(crate) fn present_ns(&self) -> u64 {
        let host_offset_ns = self.offset_search.host_offset_ns();
        self.now_ns
            .saturating_add_signed(host_offset_ns.saturating_neg())
    }

    /// Updates the search for far clocks with an image.
    pub(crate) fn update_clock_search(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        timely: Arrival,
    ) {
        let now_ns = self.now_ns;
        self.offset_search.count(camera_index, now_ns, timely);
        let contradicted = self.diagnosis.contradicting_cameras();
        let moved = self.diagnosis.moved_cameras().filter(|one| !one.is_timely);
        let suspects = contradicted.chain(moved.map(|one| one.camera));
        self.offset_search.search_suspected(now_ns, suspects);
        self.offset_search
            .record_views(camera_index, associated, &self.site, &self.options);
        let found = self.offset_search.evaluate(now_ns);
        if !found.is_empty() {
            self.begin_anew(|camera| found.contains(&camera));
        }
    }

    /// Applies the actions of diagnosis. Where most cameras contradict, the tracks are wrong.
    pub(crate) fn apply_actions(&mut self) {
        let actions = std::mem::take(&mut self.actions);
        if 2 * self.diagnosis.contradicting_cameras().count() > self.offset_search.cameras() {
            return;
        }
        for Action::RestartClock(camera) in actions {
            self.offset_search
                .search_suspected(self.now_ns, [camera].into_iter());
            let doubted = self.offset_search.unverified_by(camera, &self.site);
            self.restart_clocks(&doubted);
        }
    }

    /// Estimates clocks anew.
    fn restart_clocks(&mut self, cameras: &[usize]) {
        let sigma_s = self.options.unknown_clock_s;
        for timeline in &mut self.timelines {
            timeline.restart_clocks(cameras, sigma_s);
        }
    }

    /// Discards what was estimated with wrong timestamps of some cameras.
    pub(crate) fn begin_anew(&mut self, is_affected: impl Fn(usize) -> bool) {
        self.diagnosis.reset();
        self.contradictions.forget();
        self.self_calibration.forget_clocks(is_affected);
        for timeline in &mut self.timelines {
            *timeline = Timeline::new(timeline.object().clone());
        }
    }

    /// Evaluates the estimated offsets now and then. Offsets that have grown beyond the range of a filter are
    /// subtracted from the timestamps.
    pub(crate) fn move_far_offsets(&mut self) {
        let now_ns = self.now_ns;
        if now_ns < self.next_offsets_ns {
            return;
        }
        self.next_offsets_ns = now_ns.saturating_add(PERIOD_NS);
        let estimated = self.estimated_offsets();
        let is_off = |clock: &ClockOffset| clock.offset_s.abs() > SIGNIFICANT * clock.sigma_s;
        let off = estimated.iter().filter(|(_, clock)| is_off(clock));
        let off: BTreeSet<usize> = off.map(|(index, _)| *index).collect();
        self.offset_search.note_off(now_ns, &off);
        let contradicted: Vec<usize> = self.diagnosis.contradicting_cameras().collect();
        // The offsets of all clocks are spoilt while a camera is moved.
        let is_spoilt = self.diagnosis.moved_cameras().next().is_some();
        let mut steady: BTreeSet<usize> = self.offset_search.steadily_off(now_ns).collect();
        steady.retain(|camera| !contradicted.contains(camera));
        for (index, found) in estimated {
            let off_s = found.offset_s.abs();
            if off_s > ASTRAY_S {
                self.offset_search.search(now_ns, [index].into_iter());
            } else if is_far(&found) && steady.contains(&index) && !is_spoilt {
                self.offset_search.add(index, found);
                self.diagnosis.forget_images();
                self.contradictions.forget();
                self.self_calibration.discard_quarantine();
                self.self_calibration.shift_clock(index, found.offset_s);
                self.catch_up();
                for timeline in &mut self.timelines {
                    timeline.shift_clock(index, found.offset_s);
                }
            }
        }
    }

    /// Offsets that the filters estimate for the corrected timestamps, by camera index: the most precise estimate of
    /// all objects, its sigma widened by what they disagree by.
    fn estimated_offsets(&self) -> BTreeMap<usize, ClockOffset> {
        let mut by_camera: BTreeMap<usize, Vec<ClockOffset>> = BTreeMap::new();
        for (camera, found) in self.timelines.iter().flat_map(Timeline::clock_offsets) {
            by_camera.entry(camera).or_default().push(found);
        }
        let combined = by_camera.into_iter().filter_map(|(camera, all)| {
            let precise = |a: &ClockOffset, b: &ClockOffset| a.sigma_s.total_cmp(&b.sigma_s);
            let best = all.iter().copied().min_by(precise)?;
            let sigma_s = best.sigma_s * disagreement(&all);
            Some((camera, ClockOffset { sigma_s, ..best }))
        });
        combined.collect()
    }

    /// Clock offsets of cameras by the motion of objects: the most precise estimate of all objects.
    pub fn clock_offsets(&self) -> BTreeMap<CameraId, ClockOffset> {
        let estimated = self.estimated_offsets();
        let mut offsets: BTreeMap<usize, ClockOffset> = self.offset_search.offsets().collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    fn offset(offset_s: f64) -> ClockOffset {
        ClockOffset {
            offset_s,
            sigma_s: 0.001,
        }
    }

    #[test]
    fn estimates_that_disagree_are_less_certain_than_each_says() {
        assert_eq!(disagreement(&[offset(0.007)]), 1.0);
        assert_eq!(disagreement(&[offset(0.007), offset(0.0071)]), 1.0);
        let factor = disagreement(&[offset(-0.010), offset(0.0), offset(0.010)]);
        assert!((factor - 10.0).abs() < 1e-9, "{factor}");
    }
}
