//! Clocks that are off by more than a filter can estimate: tenths of a second, seconds, years.
//!
//! When a camera contradicts the others, or its images come too late or too early to be taken in, it may be its clock. The
//! question is then put to the motion: what the camera sees of a body by itself is compared with what others see by
//! themselves, at any offset ([`matching`]). An offset that is found is taken off the camera's stamps; what is left of it is
//! a filter's business. Otherwise the camera is where it should not be, or nothing has moved yet.
//!
//! Bounded: a question ends after some seconds and is put again to the same cameras after ever longer rests; with an image no
//! more than two cameras are compared.

use std::collections::{BTreeMap, BTreeSet};

use crate::clocks::arrival_delays::ArrivalDelays;
use crate::clocks::offset_query::OffsetQuery;
use crate::site::{AssociatedImage, Site};
use crate::{ClockOffset, FusionOptions, ImageObservation};

/// Seconds for which a question is put at most.
const QUESTION_S: f64 = 4.0;
/// Seconds for which a camera is not asked about again, to begin with and at most.
const REST_S: (f64, f64) = (5.0, 60.0);
/// Seconds for which other names for what is wrong wait for the answer.
const PATIENCE_S: f64 = 1.3;
/// Seconds of an offset that is worth taking off.
const WORTH_S: f64 = 0.003;
/// Seconds (one sigma) at least of what is left to the filters.
const LEFT_S: f64 = 0.003;
/// Seconds of age on arrival that say nothing about a clock.
const USUAL_AGE_S: std::ops::Range<f64> = -0.25..0.5;
/// Seconds for which a filter must have said the same of a clock.
const STEADY_S: f64 = 0.6;
/// Nanoseconds that arrivals must differ by to say something about clocks.
const TELLING_NS: i64 = 60_000_000;
/// Images, fading with a second, of which most must be untimely.
const FEWEST: f64 = 5.0;
const MOST_SHARE: f64 = 0.6;

/// Finds the offsets of clocks that are far off.
#[derive(Debug, Default)]
pub(crate) struct OffsetSearch {
    latencies: ArrivalDelays,
    timeliness: BTreeMap<usize, Timeliness>,
    /// By camera index: what is taken off its stamps.
    found: BTreeMap<usize, ClockOffset>,
    /// Since when the filters say that a camera's clock is off.
    off_since_ns: BTreeMap<usize, u64>,
    question: Option<OffsetQuery>,
    rests: BTreeMap<usize, Rest>,
    /// Cameras for whose clocks somebody vouches, by index.
    vouched: BTreeSet<usize>,
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
    /// Takes what was found off the stamp of an image; what its camera states of its clock is replaced by how well that is
    /// known.
    pub fn right(&self, camera_index: usize, image: &mut ImageObservation) {
        if let Some(found) = self.found.get(&camera_index) {
            let off_ns = (found.offset_s * 1e9).round() as i64;
            image.capture_ns = image
                .capture_ns
                .saturating_add_signed(off_ns.saturating_neg());
            image.clock_error_ns = (LEFT_S.max(3.0 * found.sigma_s) * 1e9) as u64;
        }
    }

    /// Somebody vouches for a camera's clock, or nobody does.
    pub fn note_vouched(&mut self, camera_index: usize, vouched: bool) {
        if vouched {
            self.vouched.insert(camera_index);
        } else {
            self.vouched.remove(&camera_index);
        }
    }

    /// Whose clocks to doubt where one camera's seems to be off: of two the reference is right, and so it is unless several are
    /// vouched for that agree with each other.
    pub fn doubted(&self, camera_index: usize, site: &Site) -> Vec<usize> {
        let is_reference = camera_index == site.reference();
        if !is_reference || (self.vouched.len() > 2 && self.vouched.contains(&camera_index)) {
            return vec![camera_index];
        }
        let all = self.latencies.all();
        all.filter(|other| *other != camera_index).collect()
    }

    /// The cameras whose stamps are put right, by index.
    pub fn offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        self.found.iter().map(|(camera, found)| (*camera, *found))
    }

    /// An image arrived, its stamp put right. Where a camera's images arrive before they were taken, and others' don't, the question
    /// is put at once: until it is answered all images of the others would be late, and its own contradict them. Where they come later
    /// than the others', it is put once: the camera may be slow, or the past is gone through again in vain.
    pub fn record(&mut self, camera_index: usize, now_ns: u64, stamp_ns: u64) {
        self.latencies.record(camera_index, now_ns, stamp_ns);
        let lead_ns = self.latencies.lead_ns(camera_index).unwrap_or(0);
        let age_ns = self.latencies.age_ns(camera_index);
        let is_early = lead_ns > TELLING_NS && age_ns < Some(-TELLING_NS);
        let last_lead_ns = self.latencies.last_lead_ns(camera_index);
        let is_late = last_lead_ns.is_some_and(|lead_ns| lead_ns < -TELLING_NS);
        if is_early || (is_late && !self.rests.contains_key(&camera_index)) {
            self.ask(now_ns, std::iter::once(camera_index));
        }
    }

    /// Whether a camera's last images came steadily later or earlier than the others'.
    pub fn is_out_of_step(&self, camera_index: usize) -> bool {
        let lead_ns = self.latencies.last_lead_ns(camera_index);
        lead_ns.is_some_and(|lead_ns| lead_ns.saturating_abs() > TELLING_NS)
    }

    /// Cameras whose images have arrived.
    pub fn cameras(&self) -> usize {
        self.latencies.cameras()
    }

    /// Whether a camera's images are to be kept from the tracks: its stamps would shut out the others', or are in doubt and
    /// arrive as if they were ahead.
    pub fn is_set_aside(&self, camera_index: usize, site: &Site, options: &FusionOptions) -> bool {
        let Some(lead_ns) = self.latencies.lead_ns(camera_index) else {
            return false;
        };
        let shuts_out = lead_ns as f64 * 1e-9 > options.window_s;
        let is_ahead = self.is_open_about(camera_index) && lead_ns > TELLING_NS;
        self.may_lie(camera_index, site) && (shuts_out || is_ahead)
    }

    /// Whether a camera's images are not worth going back for: its stamps are in doubt and arrive as if they were behind.
    pub fn is_behind(&self, camera_index: usize, site: &Site) -> bool {
        let lead_ns = self.latencies.lead_ns(camera_index);
        self.is_open_about(camera_index)
            && lead_ns.is_some_and(|lead_ns| lead_ns < -TELLING_NS)
            && self.may_lie(camera_index, site)
    }

    fn is_open_about(&self, camera_index: usize) -> bool {
        let question = self.question.as_ref();
        question.is_some_and(|question| question.is_open_about(camera_index))
    }

    /// Of two, the reference is right.
    fn may_lie(&self, camera_index: usize, site: &Site) -> bool {
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

    /// The cameras most of whose images are not taken in for their stamps.
    fn shut_out(&self) -> impl Iterator<Item = usize> {
        let untimely = self.timeliness.iter();
        untimely
            .filter(|(_, count)| count.is_untimely())
            .map(|(camera, _)| *camera)
    }

    /// Those of them whose stamps do not fit the arrivals, with their images' apparent age in seconds.
    pub fn untimely(&self) -> impl Iterator<Item = (usize, f64)> {
        let with_age = |camera| Some((camera, self.latencies.age_ns(camera)? as f64 * 1e-9));
        let ages = self.shut_out().filter_map(with_age);
        ages.filter(|(_, age_s)| !USUAL_AGE_S.contains(age_s))
    }

    /// The cameras whose clocks it may be: those contradicted, and those shut out.
    pub fn suspect(&mut self, now_ns: u64, contradicted: impl Iterator<Item = usize>) {
        let suspects: Vec<usize> = self.shut_out().chain(contradicted).collect();
        self.ask(now_ns, suspects.into_iter());
    }

    /// What the filters say of clocks: those that have been off for a while, by index. What is off but briefly is a filter
    /// led astray.
    pub fn long_off(&self, now_ns: u64) -> impl Iterator<Item = usize> {
        let long = self.off_since_ns.iter();
        long.filter(move |(_, since_ns)| age_s(**since_ns, now_ns) >= STEADY_S)
            .map(|(camera, _)| *camera)
    }

    /// The cameras whose clocks the filters say are off.
    pub fn note_off(&mut self, now_ns: u64, off: &BTreeSet<usize>) {
        self.off_since_ns.retain(|camera, _| off.contains(camera));
        for camera in off {
            self.off_since_ns.entry(*camera).or_insert(now_ns);
        }
    }

    /// Whether the question is put and young, so that what is wrong may yet be called otherwise.
    pub fn is_young(&self, now_ns: u64) -> bool {
        let question = self.question.as_ref();
        question.is_some_and(|one| !one.is_answered() && age_s(one.since_ns, now_ns) < PATIENCE_S)
    }

    /// Puts the question about some cameras, unless one is put or they have been asked about lately.
    pub fn ask(&mut self, now_ns: u64, suspects: impl Iterator<Item = usize>) {
        let rested = |camera: &usize| {
            self.rests
                .get(camera)
                .is_none_or(|rest| now_ns >= rest.until_ns)
        };
        let suspects: BTreeSet<usize> = suspects.filter(rested).collect();
        if suspects.is_empty() {
            return;
        }
        match &mut self.question {
            Some(question) => question.extend(suspects),
            None => self.question = Some(OffsetQuery::about(suspects, now_ns)),
        }
    }

    /// Shows an image, as sorted with its stamp put right, to an open question.
    pub fn watch(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        site: &Site,
        options: &FusionOptions,
    ) {
        if let Some(question) = &mut self.question {
            question.watch(camera_index, associated, site, options);
        }
    }

    /// The cameras whose offsets have just been found, or found to be others.
    pub fn look(&mut self, now_ns: u64) -> Vec<usize> {
        let Some(question) = self.question.as_mut().filter(|one| one.is_due(now_ns)) else {
            return Vec::new();
        };
        let Some(found) = question.look(now_ns, &self.latencies) else {
            return Vec::new();
        };
        let age_s = age_s(question.since_ns, now_ns);
        if !found.is_empty() || question.is_over() || age_s > QUESTION_S {
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

    /// What others have found out in addition is taken off as well. An open question has been shown other stamps.
    pub fn add(&mut self, camera_index: usize, more: ClockOffset) {
        self.question = None;
        self.apply(camera_index, more);
    }

    fn close(&mut self, now_ns: u64) {
        let Some(question) = self.question.take() else {
            return;
        };
        for camera in question.suspects() {
            let before = self.rests.get(&camera).map(|rest| rest.span_s * 2.0);
            let span_s = before.unwrap_or(REST_S.0).min(REST_S.1);
            let until_ns = now_ns.saturating_add((span_s * 1e9) as u64);
            self.rests.insert(camera, Rest { until_ns, span_s });
        }
    }

    /// Forgets what is open; what was found stays: the cameras or the objects have changed.
    pub fn models_changed(&mut self) {
        self.question = None;
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
