//! An open question about some cameras' clocks: what it has been shown, and what it makes of that.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::clocks::arrival_delays::ArrivalDelays;
use crate::clocks::consensus::ClockReading;
use crate::clocks::motion_matching::{MotionMatch, MotionPair};
use crate::clocks::single_camera_track::{Body, SingleCameraTrack};
use crate::clocks::{consensus, motion_matching, single_camera_track};
use crate::site::{AssociatedImage, ClockPrior, Site};
use crate::{ClockOffset, FusionOptions};

/// Nanoseconds between two looks at what is known.
const LOOK_NS: u64 = 150_000_000;
/// Nanoseconds after which those that see nothing are not waited for any longer.
const SILENCE_NS: u64 = 1_000_000_000;
/// Cameras that are followed: those asked about first. Enough for a majority.
const MOST_CAMERAS: usize = 6;
/// Bodies in the eyes of a camera that are followed in all.
const MOST_SHADOWS: usize = 48;
/// Cameras that others are compared with, if the first ones see too little of the same.
const MOST_BASES: usize = 3;

/// The question.
#[derive(Debug)]
pub(crate) struct OffsetQuery {
    pub since_ns: u64,
    look_ns: u64,
    suspects: BTreeSet<usize>,
    /// Cameras whose clocks are right, or not to blame as far as can be seen; and those of them whose clocks have been read.
    cleared: BTreeSet<usize>,
    read: BTreeSet<usize>,
    /// Cameras that are followed, with whether somebody vouches for their clock.
    followed: BTreeMap<usize, bool>,
    shadows: BTreeMap<(usize, Body), SingleCameraTrack>,
    /// What is being looked at.
    look: Option<Sweep>,
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
    pub fn about(suspects: BTreeSet<usize>, now_ns: u64) -> Self {
        Self {
            since_ns: now_ns,
            look_ns: now_ns.saturating_add(LOOK_NS),
            suspects,
            cleared: BTreeSet::new(),
            read: BTreeSet::new(),
            followed: BTreeMap::new(),
            shadows: BTreeMap::new(),
            look: None,
        }
    }

    /// More cameras are asked about.
    pub fn extend(&mut self, suspects: BTreeSet<usize>) {
        self.suspects.extend(suspects);
    }

    /// The cameras asked about.
    pub fn suspects(&self) -> impl Iterator<Item = usize> {
        self.suspects.iter().copied()
    }

    pub fn is_due(&self, now_ns: u64) -> bool {
        self.look.is_some() || now_ns >= self.look_ns
    }

    /// Whether it may be said what is wrong.
    pub fn is_answered(&self) -> bool {
        self.suspects.is_subset(&self.cleared)
    }

    /// Whether there is nothing left to find out: an offset longer than what has been seen may yet explain what nothing else
    /// does.
    pub fn is_over(&self) -> bool {
        self.suspects.is_subset(&self.read)
    }

    pub fn is_open_about(&self, camera_index: usize) -> bool {
        !self.cleared.contains(&camera_index)
    }

    /// Follows the bodies in a camera's image.
    pub fn watch(
        &mut self,
        camera_index: usize,
        associated: &AssociatedImage,
        site: &Site,
        options: &FusionOptions,
    ) {
        let missing = self
            .suspects
            .iter()
            .filter(|one| !self.followed.contains_key(one));
        let taken = self.followed.len() + missing.count();
        let asked_about =
            self.suspects.contains(&camera_index) && self.followed.len() < MOST_CAMERAS;
        let is_followed = self.followed.contains_key(&camera_index);
        if !is_followed && !asked_about && taken >= MOST_CAMERAS {
            return;
        }
        for (object, image) in &associated.objects {
            let vouched = matches!(image.clock, ClockPrior::Right | ClockPrior::Reference(_));
            self.followed.insert(camera_index, vouched);
            let Some(id) = site.objects().get(*object) else {
                continue;
            };
            for (body, alone) in single_camera_track::bodies(*object, image) {
                let key = (camera_index, body);
                if self.shadows.len() < MOST_SHADOWS || self.shadows.contains_key(&key) {
                    let shadow = self.shadows.entry(key).or_default();
                    shadow.take(id, &alone, site, options);
                }
            }
        }
    }

    /// The clocks that are found to be wrong by now; `None` while the look is under way.
    pub fn look(
        &mut self,
        now_ns: u64,
        latencies: &ArrivalDelays,
    ) -> Option<Vec<(usize, ClockOffset)>> {
        let mut look = self.look.take().unwrap_or_else(|| self.begin_look(now_ns));
        let Some((base, base_off, camera)) = self.next_pair(&mut look) else {
            return Some(self.conclude(now_ns, &look.readings, &look.differ));
        };
        match self.compare(base, camera, latencies) {
            MotionMatch::Open => {}
            MotionMatch::Differ => drop(look.differ.insert(camera)),
            MotionMatch::Agree => look.readings.push(self.reading(camera, base_off)),
            MotionMatch::Off(off) => {
                let offset_s = off.offset_s + base_off.offset_s;
                let off = ClockOffset { offset_s, ..off };
                look.readings.push(self.reading(camera, off));
            }
        }
        self.look = Some(look);
        None
    }

    fn begin_look(&mut self, now_ns: u64) -> Sweep {
        // What nobody waits for any longer may take its time.
        let pause = if self.is_answered() { 5 } else { 1 };
        self.look_ns = now_ns.saturating_add(pause * LOOK_NS);
        Sweep {
            bases: self.followed.keys().copied().take(MOST_BASES).collect(),
            compared: None,
            readings: Vec::new(),
            differ: BTreeSet::new(),
        }
    }

    /// The next two cameras to compare, and the first one's reading; `None` when all have been.
    fn next_pair(&self, look: &mut Sweep) -> Option<(usize, ClockOffset, usize)> {
        loop {
            let base = *look.bases.front()?;
            let base_off = self.begin(&mut look.readings, base);
            let first = look.compared.map_or(0, |camera| camera + 1);
            let is_read =
                |camera: usize| look.readings.iter().any(|one| one.camera_index == camera);
            let mut open = self.followed.range(first..).map(|(camera, _)| *camera);
            let next = open.find(|camera| !is_read(*camera));
            if let Some((base_off, camera)) = base_off.zip(next) {
                look.compared = Some(camera);
                return Some((base, base_off, camera));
            }
            // A camera that is alone with its time, or its place, is no base for the others.
            if base_off.is_some() && look.readings.len() == 1 {
                look.readings.clear();
            }
            look.bases.pop_front();
            look.compared = None;
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
            vouched: self.followed.get(&camera_index).copied().unwrap_or(false),
        }
    }

    /// Most can be told from few only when all have been asked, or those that are silent have had their time.
    fn conclude(
        &mut self,
        now_ns: u64,
        readings: &[ClockReading],
        differ: &BTreeSet<usize>,
    ) -> Vec<(usize, ClockOffset)> {
        let read = readings.iter().map(|one| one.camera_index);
        let heard: BTreeSet<usize> = read.chain(differ.iter().copied()).collect();
        let late = now_ns.saturating_sub(self.since_ns) >= SILENCE_NS;
        if !late && self.followed.keys().any(|camera| !heard.contains(camera)) {
            return Vec::new();
        }
        self.cleared.extend(heard);
        self.read
            .extend(readings.iter().map(|one| one.camera_index));
        consensus::wrong(readings)
    }

    fn compare(&self, base: usize, camera: usize, latencies: &ArrivalDelays) -> MotionMatch {
        let of_camera = self
            .shadows
            .range((camera, (0, None))..(camera + 1, (0, None)));
        let mut pairs = Vec::new();
        for ((_, body), shadow) in of_camera {
            pairs.extend(self.shadows.get(&(base, *body)).map(|other| MotionPair {
                a: other.samples(),
                b: shadow.samples(),
            }));
        }
        let ages = latencies.age_ns(base).zip(latencies.age_ns(camera));
        let implied_ns = ages.map_or(0, |(base, own)| base.saturating_sub(own));
        motion_matching::compare(&pairs, implied_ns)
    }
}
