//! One search for the clock offsets of some cameras: the motion that each of them sees, and its comparison.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::FusionOptions;
use crate::clocks::arrival_delays::ArrivalDelays;
use crate::clocks::consensus::ClockReading;
use crate::clocks::motion_matching::{MotionMatch, MotionPair};
use crate::clocks::single_camera_track::{Body, SingleCameraTrack};
use crate::clocks::{consensus, motion_matching, single_camera_track};
use crate::site::{AssociatedImage, ClockPrior, ModelledSite};
use sextant_site_report::ClockOffset;

/// Time between two comparisons, ns.
const SWEEP_NS: u64 = 150_000_000;
/// Time after which cameras that see nothing are not waited for, ns.
const SILENCE_NS: u64 = 1_000_000_000;
/// Most cameras that are followed, the suspected ones first. Enough for a majority.
const MOST_CAMERAS: usize = 6;
/// Most tracks of bodies by single cameras.
const MOST_TRACKS: usize = 48;
/// Cameras that others are compared with, if the first ones see too little of the same.
const MOST_BASES: usize = 3;

/// A search under way.
#[derive(Debug)]
pub(crate) struct OffsetQuery {
    pub since_ns: u64,
    sweep_ns: u64,
    candidates: BTreeSet<usize>,
    /// Cameras whose clocks are right, or not the cause as far as can be seen; and those of them whose clocks have been
    /// read.
    cleared: BTreeSet<usize>,
    read: BTreeSet<usize>,
    /// Cameras that are followed, with whether their clock is verified.
    followed: BTreeMap<usize, bool>,
    tracks: BTreeMap<(usize, Body), SingleCameraTrack>,
    /// The comparison under way.
    sweep: Option<Sweep>,
}

/// A look under way. It takes an image for each two cameras that are compared, so that none waits for all comparisons.
#[derive(Debug)]
struct Sweep {
    /// Cameras to compare others with, the present one first.
    bases: VecDeque<usize>,
    /// The camera last compared with it.
    compared: Option<usize>,
    readings: Vec<ClockReading>,
    differ: BTreeSet<usize>,
}

impl OffsetQuery {
    pub fn new(candidates: BTreeSet<usize>, now_ns: u64) -> Self {
        Self {
            since_ns: now_ns,
            sweep_ns: now_ns.saturating_add(SWEEP_NS),
            candidates,
            cleared: BTreeSet::new(),
            read: BTreeSet::new(),
            followed: BTreeMap::new(),
            tracks: BTreeMap::new(),
            sweep: None,
        }
    }

    /// Adds cameras whose clocks are suspected to be off.
    pub fn extend(&mut self, candidates: BTreeSet<usize>) {
        self.candidates.extend(candidates);
    }

    /// Indices of the cameras whose clocks are suspected to be off.
    pub fn candidates(&self) -> impl Iterator<Item = usize> {
        self.candidates.iter().copied()
    }

    pub fn is_due(&self, now_ns: u64) -> bool {
        self.sweep.is_some() || now_ns >= self.sweep_ns
    }

    /// Whether all suspected clocks have been compared.
    pub fn is_answered(&self) -> bool {
        self.candidates.is_subset(&self.cleared)
    }

    /// Whether there is nothing left to find out: an offset longer than what has been seen may yet explain what nothing
    /// else does.
    pub fn is_over(&self) -> bool {
        self.candidates.is_subset(&self.read)
    }

    pub fn is_open_about(&self, camera_index: usize) -> bool {
        !self.cleared.contains(&camera_index)
    }

    /// Updates the tracks of the bodies in an image.
    pub fn record(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        site: &ModelledSite,
        options: &FusionOptions,
    ) {
        let missing = self
            .candidates
            .iter()
            .filter(|one| !self.followed.contains_key(one));
        let taken = self.followed.len() + missing.count();
        let asked_about =
            self.candidates.contains(&camera_index) && self.followed.len() < MOST_CAMERAS;
        let is_followed = self.followed.contains_key(&camera_index);
        if !is_followed && !asked_about && taken >= MOST_CAMERAS {
            return;
        }
        for (object, image) in &associated.objects {
            let verified = matches!(image.clock, ClockPrior::Right | ClockPrior::Reference(_));
            self.followed.insert(camera_index, verified);
            let Some(id) = site.objects().get(*object) else {
                continue;
            };
            for (body, alone) in single_camera_track::bodies(*object, image) {
                let key = (camera_index, body);
                if self.tracks.len() < MOST_TRACKS || self.tracks.contains_key(&key) {
                    let track = self.tracks.entry(key).or_default();
                    track.take(id, &alone, site, options);
                }
            }
        }
    }

    /// The clocks that are found to be wrong; `None` while the comparison is under way.
    pub fn evaluate(
        &mut self,
        now_ns: u64,
        latencies: &ArrivalDelays,
    ) -> Option<Vec<(usize, ClockOffset)>> {
        let mut sweep = self
            .sweep
            .take()
            .unwrap_or_else(|| self.begin_sweep(now_ns));
        let Some((base, base_off, camera)) = self.next_pair(&mut sweep) else {
            return Some(self.conclude(now_ns, &sweep.readings, &sweep.differ, latencies));
        };
        match self.compare(base, camera, latencies) {
            MotionMatch::Open => {}
            MotionMatch::Differ => drop(sweep.differ.insert(camera)),
            MotionMatch::Agree => sweep.readings.push(self.reading(camera, base_off)),
            MotionMatch::Off(off) => {
                let offset_s = off.offset_s + base_off.offset_s;
                let off = ClockOffset { offset_s, ..off };
                sweep.readings.push(self.reading(camera, off));
            }
        }
        self.sweep = Some(sweep);
        None
    }

    fn begin_sweep(&mut self, now_ns: u64) -> Sweep {
        // What nobody waits for any longer may take its time.
        let pause = if self.is_answered() { 5 } else { 1 };
        self.sweep_ns = now_ns.saturating_add(pause * SWEEP_NS);
        Sweep {
            bases: self.followed.keys().copied().take(MOST_BASES).collect(),
            compared: None,
            readings: Vec::new(),
            differ: BTreeSet::new(),
        }
    }

    /// The next two cameras to compare, and the first one's reading; `None` when all have been.
    fn next_pair(&self, sweep: &mut Sweep) -> Option<(usize, ClockOffset, usize)> {
        loop {
            let base = *sweep.bases.front()?;
            let base_off = self.begin(&mut sweep.readings, base);
            let first = sweep.compared.map_or(0, |camera| camera + 1);
            let is_read =
                |camera: usize| sweep.readings.iter().any(|one| one.camera_index == camera);
            let mut open = self.followed.range(first..).map(|(camera, _)| *camera);
            let next = open.find(|camera| !is_read(*camera));
            if let Some((base_off, camera)) = base_off.zip(next) {
                sweep.compared = Some(camera);
                return Some((base, base_off, camera));
            }
            // A camera that is alone with its time, or its place, is no base for the others.
            if base_off.is_some() && sweep.readings.len() == 1 {
                sweep.readings.clear();
            }
            sweep.bases.pop_front();
            sweep.compared = None;
        }
    }

    /// A camera to compare others with: the first one, or one whose reading is known; `None` for any other.
    fn begin(&self, readings: &mut Vec<ClockReading>, base: usize) -> Option<ClockOffset> {
        let known = readings.iter().find(|one| one.camera_index == base);
        if let Some(known) = known {
            return Some(known.off);
        }
        let none = ClockOffset {
            offset_s: 0.0,
            sigma_s: 0.0,
        };
        readings.is_empty().then(|| {
            readings.push(self.reading(base, none));
            none
        })
    }

    fn reading(&self, camera_index: usize, off: ClockOffset) -> ClockReading {
        ClockReading {
            camera_index,
            off,
            verified: self.followed.get(&camera_index).copied().unwrap_or(false),
        }
    }

    /// A majority counts only when all cameras have been compared, or those without motion have had their time.
    fn conclude(
        &mut self,
        now_ns: u64,
        readings: &[ClockReading],
        differ: &BTreeSet<usize>,
        latencies: &ArrivalDelays,
    ) -> Vec<(usize, ClockOffset)> {
        let read = readings.iter().map(|one| one.camera_index);
        let compared: BTreeSet<usize> = read.chain(differ.iter().copied()).collect();
        let late = now_ns.saturating_sub(self.since_ns) >= SILENCE_NS;
        if !late
            && self
                .followed
                .keys()
                .any(|camera| !compared.contains(camera))
        {
            return Vec::new();
        }
        self.cleared.extend(compared);
        self.read
            .extend(readings.iter().map(|one| one.camera_index));
        let is_timely = |camera: usize| {
            let majority = latencies.majority();
            majority.is_none_or(|majority| majority.cameras.contains(&camera))
        };
        consensus::wrong(readings, is_timely)
    }

    fn compare(&self, base: usize, camera: usize, latencies: &ArrivalDelays) -> MotionMatch {
        let of_camera = self
            .tracks
            .range((camera, (0, None))..(camera + 1, (0, None)));
        let mut pairs = Vec::new();
        for ((_, body), track) in of_camera {
            pairs.extend(self.tracks.get(&(base, *body)).map(|other| MotionPair {
                a: other.samples(),
                b: track.samples(),
            }));
        }
        let ages = latencies.age_ns(base).zip(latencies.age_ns(camera));
        let implied_ns = ages.map_or(0, |(base, own)| base.saturating_sub(own));
        motion_matching::compare(&pairs, implied_ns)
    }
}
