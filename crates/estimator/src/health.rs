//! What is wrong with the site, by name: which camera was moved, which tag is loose, wrongly measured or there twice.
//!
//! A view that contradicts its track takes no part. Rarely that is a wrong detection; if most views of one camera do while
//! the others agree, the camera is not where the rig says, and if most views of one tag do while the object's other tags
//! agree, the tag is not where the model says, or not as large. Fed with instants that no late image can change any more.

mod strays;

use std::collections::{BTreeMap, BTreeSet};

use crate::TagId;
use strays::Strays;
pub(crate) use strays::{Elsewhere, Ray};

/// Seconds after which a view counts 1/e.
const MEMORY_S: f64 = 0.6;
/// Views, counted with that memory, from which on a share means something.
const FEWEST: f64 = 6.0;
/// Share of contradicting views that makes a fault, and below which it is over.
const RAISED: f64 = 0.7;
const CLEARED: f64 = 0.3;
/// Share of contradicting views from which on it is asked whether the camera's clock is the cause.
const DOUBTED: f64 = 0.5;
/// Share of contradicting views among all others up to which these can be believed.
const SOUND: f64 = 0.3;
/// Relative error of a tag's size that is worth a word, and its chi-square (1 degree of freedom).
const WRONG_SIZE: f64 = 0.01;
const SURE: f64 = 100.0;

/// Nanoseconds for which a tag that was seen twice is reported.
const TWINS_NS: u64 = 2_000_000_000;

/// A view of an instant that is settled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SettledView {
    pub camera_index: usize,
    pub tag: TagId,
    /// Whether it agreed with the track.
    pub agreed: bool,
    /// The ray on which it is seen, if that is far from where its object has it.
    pub ray: Option<Ray>,
    /// What is there.
    pub elsewhere: Option<Elsewhere>,
    /// Sums over the corners: residual times the corner's distance from the tag's centre, that
    /// distance squared, residual squared; px².
    pub size: [f64; 3],
}

/// The part of a count of then that still counts now.
fn kept(then_ns: u64, now_ns: u64) -> f64 {
    let age_s = now_ns.saturating_sub(then_ns) as f64 * 1e-9;
    (-age_s / MEMORY_S).exp()
}

/// Counts that fade.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Count {
    at_ns: u64,
    views: f64,
    refused: f64,
    size: [f64; 3],
}

impl Count {
    fn faded(&self, now_ns: u64) -> Self {
        let keep = kept(self.at_ns, now_ns);
        Self {
            at_ns: now_ns.max(self.at_ns),
            views: self.views * keep,
            refused: self.refused * keep,
            size: self.size.map(|sum| sum * keep),
        }
    }

    fn add(&mut self, now_ns: u64, view: &SettledView) {
        *self = self.faded(now_ns);
        self.views += 1.0;
        self.refused += if view.agreed { 0.0 } else { 1.0 };
        self.size = [0, 1, 2].map(|index| self.size[index] + view.size[index]);
    }

    fn share(&self) -> f64 {
        self.refused / self.views.max(f64::MIN_POSITIVE)
    }

    /// Size over the model's, where that is another beyond chance.
    fn wrong_size(&self) -> Option<f64> {
        let [cross, radius, residual] = self.size;
        let error = -cross / radius;
        // The residuals that a wrong size leaves are chance: eight coordinates a view.
        let chance = (residual - cross * cross / radius).max(0.0) / (8.0 * self.views);
        let sure = self.views >= FEWEST && cross * cross > SURE * radius * chance;
        (sure && error.abs() > WRONG_SIZE).then_some(1.0 + error)
    }
}

/// The counts of a site, and what is wrong by them.
#[derive(Debug, Default)]
pub(crate) struct Health {
    cameras: BTreeMap<usize, Count>,
    tags: BTreeMap<(usize, TagId), Count>,
    faulty_cameras: BTreeSet<usize>,
    faulty_tags: BTreeSet<(usize, TagId)>,
    strays: Strays,
    /// When a tag was last in an image twice, by camera index.
    twice_ns: BTreeMap<(usize, TagId), u64>,
    newest_ns: u64,
}

impl Health {
    /// Takes the views of one object at a settled instant in.
    pub fn take(&mut self, object: usize, time_ns: u64, views: &[SettledView]) {
        for view in views {
            let camera = self.cameras.entry(view.camera_index).or_default();
            camera.add(time_ns, view);
            if !view.agreed {
                self.strays.refuse(object, time_ns, view);
            }
            if view.elsewhere.is_some() {
                continue;
            }
            // A camera that is not where it should be says nothing about tags.
            if !self.faulty_cameras.contains(&view.camera_index) {
                let tag = self.tags.entry((object, view.tag)).or_default();
                tag.add(time_ns, view);
            }
        }
        self.judge_cameras(time_ns);
        self.judge_tags(time_ns);
        let of_camera = |camera: usize| {
            let count = self.cameras.get(&camera)?.faded(time_ns);
            Some((count.views, count.refused))
        };
        self.strays.judge(time_ns, of_camera);
    }

    /// Notes the tags that an image has more than once.
    pub fn look_for_twins(
        &mut self,
        camera_index: usize,
        time_ns: u64,
        tags: impl Iterator<Item = TagId>,
    ) {
        let mut seen = BTreeSet::new();
        self.newest_ns = self.newest_ns.max(time_ns);
        for tag in tags {
            if !seen.insert(tag) {
                self.twice_ns.insert((camera_index, tag), time_ns);
            }
        }
        let oldest_ns = self.newest_ns.saturating_sub(TWINS_NS);
        self.twice_ns.retain(|_, at_ns| *at_ns >= oldest_ns);
    }

    /// The tags that a camera has lately seen twice.
    pub fn twins(&self) -> impl Iterator<Item = (usize, TagId)> {
        self.twice_ns.keys().copied()
    }

    /// Forgets all: the models have changed.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The tags that are seen where their objects can't have them, by object index, and the object that they are seen on.
    pub fn strays(&self) -> impl Iterator<Item = (usize, TagId, Option<usize>)> {
        self.strays
            .found()
            .map(|((object, tag), on)| (object, tag, on))
    }

    /// The cameras most of whose views contradict their tracks, by index: for whatever cause.
    pub fn contradicted_cameras(&self) -> impl Iterator<Item = usize> {
        let is_contradicted =
            |count: &Count| count.views >= FEWEST / 2.0 && count.share() > DOUBTED;
        let cameras = self.cameras.iter();
        cameras
            .filter(move |(_, count)| is_contradicted(count))
            .map(|(camera, _)| *camera)
    }

    /// The cameras that are not where the rig says, by index.
    pub fn moved_cameras(&self) -> impl Iterator<Item = usize> {
        self.faulty_cameras.iter().copied()
    }

    /// The tags that are not as the models say, by object index; with the ratio of sizes where that explains it.
    pub fn wrong_tags(&self) -> impl Iterator<Item = (usize, TagId, Option<f64>)> {
        let ratio = |key| self.tags.get(key).and_then(Count::wrong_size);
        let in_place = |key: &&(usize, TagId)| !self.strays.contains(key);
        self.faulty_tags
            .iter()
            .filter(in_place)
            .map(move |key| (key.0, key.1, ratio(key)))
    }

    fn judge_cameras(&mut self, now_ns: u64) {
        let counts: Vec<(usize, Count)> = self
            .cameras
            .iter()
            .map(|(key, count)| (*key, count.faded(now_ns)))
            .collect();
        let before = self.faulty_cameras.len();
        let all = Sum::of(counts.iter().map(|(_, count)| count));
        for (camera, count) in &counts {
            judge(&mut self.faulty_cameras, *camera, count, &all);
        }
        if self.faulty_cameras.len() > before {
            self.tags.clear();
            self.faulty_tags.clear();
        }
    }

    fn judge_tags(&mut self, now_ns: u64) {
        let faded = |(key, count): (&(usize, TagId), &Count)| (*key, count.faded(now_ns));
        let counts: Vec<_> = self.tags.iter().map(faded).collect();
        for of_object in counts.chunk_by(|a, b| a.0.0 == b.0.0) {
            let all = Sum::of(of_object.iter().map(|(_, count)| count));
            let wrong_size = |(_, count): &&((usize, TagId), Count)| count.wrong_size().is_some();
            for (key, count) in of_object {
                judge(&mut self.faulty_tags, *key, count, &all);
            }
            let mut of_wrong_size = of_object.iter().filter(wrong_size);
            if let (Some((alone, _)), None) = (of_wrong_size.next(), of_wrong_size.next()) {
                self.faulty_tags.insert(*alone);
            }
        }
    }
}

/// Of some counts: views, and how many of them contradict.
struct Sum {
    views: f64,
    refused: f64,
}

impl Sum {
    fn of<'a>(counts: impl Iterator<Item = &'a Count>) -> Self {
        let none = Self {
            views: 0.0,
            refused: 0.0,
        };
        counts.fold(none, |sum, count| Self {
            views: sum.views + count.views,
            refused: sum.refused + count.refused,
        })
    }

    /// Without one of them.
    fn but(&self, count: &Count) -> Count {
        Count {
            views: self.views - count.views,
            refused: self.refused - count.refused,
            ..Count::default()
        }
    }
}

/// Raises the fault when most views contradict while the others are sound, clears it when few do.
fn judge<K: Ord>(faults: &mut BTreeSet<K>, key: K, count: &Count, all: &Sum) {
    let others = all.but(count);
    if count.views >= FEWEST
        && others.views >= FEWEST
        && count.share() > RAISED
        && others.share() < SOUND
    {
        faults.insert(key);
    } else if count.views >= FEWEST && count.share() < CLEARED {
        faults.remove(&key);
    }
}
