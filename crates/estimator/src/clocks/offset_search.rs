//! Search for clock offsets that a filter cannot estimate: tenths of a second, seconds, years.
//!
//! A camera that contradicts the others, or whose images arrive too late or too early, may have a wrong clock. The
//! search then compares the motion that the camera sees of a body with that of other cameras at any offset
//! ([`motion_matching`](crate::clocks::motion_matching)). An offset that is found is subtracted from the timestamps of
//! the camera; a filter estimates the rest.
//!
//! Bounded: a search ends after some seconds and is not repeated for the same cameras for a while; each image compares
//! one pair of cameras.

use std::collections::{BTreeMap, BTreeSet};

use crate::FusionOptions;
use crate::clocks::arrival_delays::ArrivalDelays;
use crate::clocks::offset_query::OffsetQuery;
use crate::site::{AssociatedImage, ModelledSite};
use sextant_site_model::ImageObservation;
use sextant_site_report::ClockOffset;

/// Longest search, s.
const QUERY_S: f64 = 4.0;
/// Seconds for which a camera is not asked about again, to begin with and at most.
const REST_S: (f64, f64) = (5.0, 60.0);
/// Time for which moved cameras are not named while a search is open, s.
const PATIENCE_S: f64 = 1.3;
/// Smallest offset that is subtracted from timestamps, s.
const WORTH_S: f64 = 0.003;
/// Least standard deviation of the offset that is left to the filters, s.
const LEFT_S: f64 = 0.003;
/// Age on arrival that is usual, s.
const USUAL_AGE_S: std::ops::Range<f64> = -0.25..0.5;
/// Time for which filters must estimate a clock to be off, s.
const STEADY_S: f64 = 0.6;
/// Age on arrival up to which a host that was off is right again, ns.
const RIGHT_NS: i64 = 500_000_000;
/// Difference of arrivals that matters, ns.
const TELLING_NS: i64 = 60_000_000;
/// Images, fading with a second, of which most must be untimely.
const FEWEST: f64 = 5.0;
const MOST_SHARE: f64 = 0.6;

/// Offsets found so far, and the search under way.
#[derive(Debug, Default)]
pub(crate) struct OffsetSearch {
    latencies: ArrivalDelays,
    /// When the first image arrived, ns.
    first_ns: Option<u64>,
    /// How far this host's clock is ahead of that of most cameras, ns: 0 where it agrees with them.
    host_offset_ns: i64,
    timeliness: BTreeMap<usize, Timeliness>,
    /// Offset that is subtracted from the timestamps, by camera index.
    found: BTreeMap<usize, ClockOffset>,
    /// Since when the filters estimate a clock to be off, ns.
    off_since_ns: BTreeMap<usize, u64>,
    query: Option<OffsetQuery>,
    rests: BTreeMap<usize, Rest>,
    /// Cameras with verified clocks, by index.
    verified: BTreeSet<usize>,
}

/// How many of a camera's images came in time; fading.
#[derive(Debug, Clone, Copy, Default)]
struct Timeliness {
    at_ns: u64,
    images: f64,
    untimely: f64,
}

#[derive(Debug, Clone, Copy)]
struct Rest {
    until_ns: u64,
    span_s: f64,
}

impl OffsetSearch {
    /// Subtracts the offset that was found from the timestamp of an image, and replaces the clock error that its camera
    /// reports.
    pub fn correct(&self, camera_index: usize, image: &mut ImageObservation) {
        if let Some(found) = self.found.get(&camera_index) {
            let off_ns = (found.offset_s * 1e9).round() as i64;
            image.capture_ns = image
                .capture_ns
                .saturating_add_signed(off_ns.saturating_neg());
            image.clock_error_ns = (LEFT_S.max(3.0 * found.sigma_s) * 1e9) as u64;
        }
    }

    /// Notes whether the clock of a camera is verified.
    pub fn note_verified(&mut self, camera_index: usize, verified: bool) {
        if verified {
            self.verified.insert(camera_index);
        } else {
            self.verified.remove(&camera_index);
        }
    }

    /// The clocks that may be off if one camera contradicts: its own, or all others if it is the reference and not one
    /// of several verified clocks that agree.
    pub fn unverified_by(&self, camera_index: usize, site: &ModelledSite) -> Vec<usize> {
        let is_reference = camera_index == site.reference();
        if !is_reference || (self.verified.len() > 2 && self.verified.contains(&camera_index)) {
            return vec![camera_index];
        }
        let all = self.latencies.all();
        all.filter(|other| *other != camera_index).collect()
    }

    /// Offsets that are subtracted, by camera index.
    pub fn offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        self.found.iter().map(|(camera, found)| (*camera, *found))
    }

    /// Records the arrival of an image, its timestamp corrected. Where images of a camera arrive before they were
    /// taken, and others do not, a search begins at once: until it ends all images of the others would be late. Where
    /// they arrive later than those of the others it begins once: the camera may just be slow.
    pub fn record(
        &mut self,
        camera_index: usize,
        now_ns: u64,
        stamp_ns: u64,
        options: &FusionOptions,
    ) {
        let together_ns = (options.window_s * 1e9) as i64;
        self.first_ns.get_or_insert(now_ns);
        self.latencies
            .record(camera_index, now_ns, stamp_ns, together_ns);
        self.update_host_offset();
        let lead_ns = self.latencies.lead_ns(camera_index).unwrap_or(0);
        let age_ns = self.latencies.age_ns(camera_index);
        let is_early = lead_ns > TELLING_NS && age_ns < Some(-TELLING_NS);
        let last_lead_ns = self.latencies.last_lead_ns(camera_index);
        let is_late = last_lead_ns.is_some_and(|lead_ns| lead_ns < -TELLING_NS);
        if is_early || (is_late && !self.rests.contains_key(&camera_index)) {
            self.search(now_ns, std::iter::once(camera_index));
        }
    }

    /// Whether the last images of a camera arrived steadily later or earlier than those of the others.
    pub fn is_out_of_step(&self, camera_index: usize) -> bool {
        let lead_ns = self.latencies.last_lead_ns(camera_index);
        lead_ns.is_some_and(|lead_ns| lead_ns.saturating_abs() > TELLING_NS)
    }

    /// Cameras whose images have arrived.
    pub fn cameras(&self) -> usize {
        self.latencies.cameras()
    }

    /// Whether images of a camera are kept from the tracks: most clocks, this host's among them, tell another time, or
    /// its timestamps are being searched and seem to be ahead. While a single camera contradicts the host, others are
    /// waited for.
    pub fn is_set_aside(&self, camera_index: usize, now_ns: u64, site: &ModelledSite) -> bool {
        let Some(majority) = self.latencies.majority() else {
            return false;
        };
        let is_lone = !majority.has_host && majority.cameras.len() == 1;
        let is_early = self
            .first_ns
            .is_none_or(|first_ns| age_s(first_ns, now_ns) < PATIENCE_S);
        let awaits_others = is_lone && is_early && !site.has_one_camera();
        let lead_ns = self.latencies.lead_ns(camera_index).unwrap_or(0);
        let is_ahead = self.is_open_about(camera_index) && lead_ns > TELLING_NS;
        awaits_others
            || !majority.cameras.contains(&camera_index)
            || (self.may_lie(camera_index, site) && is_ahead)
    }

    /// How far this host's clock is ahead of that of most cameras, ns: 0 where it agrees with them.
    pub fn host_offset_ns(&self) -> i64 {
        self.host_offset_ns
    }

    /// Once it is off, it agrees again only where it is clearly right, so that ages about the limit don't make it
    /// waver.
    fn update_host_offset(&mut self) {
        let Some(majority) = self.latencies.majority() else {
            return;
        };
        let is_wavering = self.host_offset_ns != 0 && majority.age_ns.saturating_abs() > RIGHT_NS;
        self.host_offset_ns = if majority.has_host && !is_wavering {
            0
        } else {
            majority.age_ns
        };
    }

    /// Whether images of a camera are dropped where they are late: its timestamps are being searched and seem to be
    /// behind.
    pub fn is_behind(&self, camera_index: usize, site: &ModelledSite) -> bool {
        let lead_ns = self.latencies.lead_ns(camera_index);
        self.is_open_about(camera_index)
            && lead_ns.is_some_and(|lead_ns| lead_ns < -TELLING_NS)
            && self.may_lie(camera_index, site)
    }

    fn is_open_about(&self, camera_index: usize) -> bool {
        let query = self.query.as_ref();
        query.is_some_and(|query| query.is_open_about(camera_index))
    }

    /// Whether the timestamps may be wrong: of two cameras the reference is right.
    fn may_lie(&self, camera_index: usize, site: &ModelledSite) -> bool {
        self.cameras() > 2 || site.reference() != camera_index
    }

    /// Counts an image that came in time, or did not.
    pub fn count(&mut self, camera_index: usize, now_ns: u64, timely: Arrival) {
        let count = self.timeliness.entry(camera_index).or_default();
        let keep = (-(now_ns.saturating_sub(count.at_ns) as f64) * 1e-9).exp();
        let untimely = f64::from(u8::from(timely == Arrival::No));
        *count = Timeliness {
            at_ns: now_ns.max(count.at_ns),
            images: count.images * keep + 1.0,
            untimely: count.untimely * keep + untimely,
        };
    }

    /// Cameras most of whose images are rejected for their timestamps.
    fn shut_out(&self) -> impl Iterator<Item = usize> {
        let untimely = self.timeliness.iter();
        untimely
            .filter(|(_, count)| count.is_untimely())
            .map(|(camera, _)| *camera)
    }

    /// Those of them whose timestamps do not fit the arrivals, with the apparent age of their images, s.
    pub fn untimely(&self) -> impl Iterator<Item = (usize, f64)> {
        let with_age = |camera| Some((camera, self.latencies.age_ns(camera)? as f64 * 1e-9));
        let ages = self.shut_out().filter_map(with_age);
        ages.filter(|(_, age_s)| !USUAL_AGE_S.contains(age_s))
    }

    /// Searches for the clocks of cameras that contradict or are shut out.
    pub fn search_suspected(&mut self, now_ns: u64, contradicted: impl Iterator<Item = usize>) {
        let candidates: Vec<usize> = self.shut_out().chain(contradicted).collect();
        self.search(now_ns, candidates.into_iter());
    }

    /// Cameras whose clocks have been off for a while by the filters, by index. What is off but briefly is a filter led
    /// astray.
    pub fn steadily_off(&self, now_ns: u64) -> impl Iterator<Item = usize> {
        let long = self.off_since_ns.iter();
        long.filter(move |(_, since_ns)| age_s(**since_ns, now_ns) >= STEADY_S)
            .map(|(camera, _)| *camera)
    }

    /// Notes the cameras whose clocks are off by the filters.
    pub fn note_off(&mut self, now_ns: u64, off: &BTreeSet<usize>) {
        self.off_since_ns.retain(|camera, _| off.contains(camera));
        for camera in off {
            self.off_since_ns.entry(*camera).or_insert(now_ns);
        }
    }

    /// Whether a search is under way that may yet explain a fault.
    pub fn is_young(&self, now_ns: u64) -> bool {
        let query = self.query.as_ref();
        query.is_some_and(|one| !one.is_answered() && age_s(one.since_ns, now_ns) < PATIENCE_S)
    }

    /// Begins or extends a search for the clocks of some cameras, unless they have been searched lately.
    pub fn search(&mut self, now_ns: u64, candidates: impl Iterator<Item = usize>) {
        let rested = |camera: &usize| {
            self.rests
                .get(camera)
                .is_none_or(|rest| now_ns >= rest.until_ns)
        };
        let candidates: BTreeSet<usize> = candidates.filter(rested).collect();
        if candidates.is_empty() {
            return;
        }
        match &mut self.query {
            Some(query) => query.extend(candidates),
            None => self.query = Some(OffsetQuery::new(candidates, now_ns)),
        }
    }

    /// Records the views of an image for the search.
    pub fn record_views(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        site: &ModelledSite,
        options: &FusionOptions,
    ) {
        if let Some(query) = &mut self.query {
            query.record(camera_index, associated, site, options);
        }
    }

    /// Continues the search; the cameras whose offsets have just been found.
    pub fn evaluate(&mut self, now_ns: u64) -> Vec<usize> {
        let Some(query) = self.query.as_mut().filter(|one| one.is_due(now_ns)) else {
            return Vec::new();
        };
        let Some(found) = query.evaluate(now_ns, &self.latencies) else {
            return Vec::new();
        };
        let age_s = age_s(query.since_ns, now_ns);
        if !found.is_empty() || query.is_over() || age_s > QUERY_S {
            self.close(now_ns);
        }
        for (camera, off) in &found {
            self.apply(*camera, *off);
        }
        found.into_iter().map(|(camera, _)| camera).collect()
    }

    fn apply(&mut self, camera_index: usize, off: ClockOffset) {
        let before = self.found.remove(&camera_index);
        let offset_s = before.map_or(0.0, |before| before.offset_s) + off.offset_s;
        if offset_s.abs() > WORTH_S {
            self.found
                .insert(camera_index, ClockOffset { offset_s, ..off });
        }
        self.latencies.forget(camera_index);
        self.timeliness.remove(&camera_index);
        self.rests.remove(&camera_index);
    }

    /// Subtracts a further offset. A search under way has seen other timestamps, and ends.
    pub fn add(&mut self, camera_index: usize, more: ClockOffset) {
        self.query = None;
        self.apply(camera_index, more);
    }

    fn close(&mut self, now_ns: u64) {
        let Some(query) = self.query.take() else {
            return;
        };
        for camera in query.candidates() {
            let before = self.rests.get(&camera).map(|rest| rest.span_s * 2.0);
            let span_s = before.unwrap_or(REST_S.0).min(REST_S.1);
            let until_ns = now_ns.saturating_add((span_s * 1e9) as u64);
            self.rests.insert(camera, Rest { until_ns, span_s });
        }
    }

    /// Ends the search and keeps the offsets: the cameras or the objects have changed.
    pub fn models_changed(&mut self) {
        self.query = None;
        self.rests.clear();
        self.timeliness.clear();
        self.off_since_ns.clear();
    }
}

/// Whether an image came in time to be taken in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Arrival {
    Yes,
    No,
}

impl Timeliness {
    fn is_untimely(&self) -> bool {
        self.images >= FEWEST && self.untimely > MOST_SHARE * self.images
    }
}

fn age_s(since_ns: u64, now_ns: u64) -> f64 {
    now_ns.saturating_sub(since_ns) as f64 * 1e-9
}
