//! Which faults explain what the views of a site contradict: cameras and tags displaced, tags of another size, clocks off.
//!
//! Each fault's parameters are learned from the views, and each view is foretold by them before it is learned from: what that
//! gains over no fault is evidence for it (Dawid 1984, Present position and potential developments: the prequential approach). The
//! evidence is kept by camera and tag, so that what one fault explains is not counted for another.

pub(crate) mod confirmation;

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector6;

use crate::TagId;
use crate::diagnosis::fault_estimate::{ALERT, FaultEstimate};
use crate::diagnosis::fault_model::FaultModel;
use crate::diagnosis::fault_model::camera::{CameraPoseFault, apparent_angles};
use crate::diagnosis::fault_model::clock::ClockFault;
use crate::diagnosis::fault_model::tag_pose::TagPoseFault;
use crate::diagnosis::fault_model::tag_size::TagSizeFault;
use crate::measurement::pose_innovation::PoseInnovation;

/// Evidence, a logarithm of odds, from which on a fault is said, and below which it is over.
pub(crate) const RAISED: f64 = 40.0;
const CLEARED: f64 = 10.0;
/// The same from which on it is asked who is wrong.
pub(crate) const SUSPECTED: f64 = 15.0;
/// Nanoseconds after a camera contradicted others, which spoils tracks, in which none but loud evidence names a tag.
const AMID_NS: u64 = 2_000_000_000;
/// The same from which on it is no error of calibration that nobody states.
const LOUD: f64 = 300.0;
/// Evidence by which a fault must exceed another that explains the same; as which it counts that a fault is of one parameter.
const MARGIN: f64 = 15.0;
const SIMPLE: f64 = 10.0;
/// Share of the evidence against a camera that its clock must explain to be suspected.
pub(crate) const CLOCK_SHARE: f64 = 0.2;
/// Nanoseconds between two decisions.
const PAUSE_NS: u64 = 30_000_000;
/// Views over which angles are averaged.
pub(crate) const RECENT: f64 = 10.0;
/// Views after which one counts 1/e.
pub(crate) const MEMORY: f64 = 30.0;
/// An object and one of its tags.
type Tag = (usize, TagId);

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FaultHypothesis {
    Clock(usize),
    Camera(usize),
    Size(Tag),
    Place(Tag),
}

/// Evidence of the views of one tag by one camera, for each of the causes that they may have.
#[derive(Debug, Clone, Copy, Default)]
struct Cell([f64; 4]);

/// All that may be wrong with a site.
#[derive(Debug, Default)]
pub(crate) struct FaultBank {
    cells: BTreeMap<(usize, Tag), Cell>,
    cameras: BTreeMap<usize, FaultEstimate>,
    tags: BTreeMap<Tag, FaultEstimate>,
    /// Angles by which each camera displaces what is seen, lately.
    angles: BTreeMap<usize, [f64; 2]>,
    found: BTreeSet<FaultHypothesis>,
    /// Whether something may be wrong.
    alert: bool,
    judged_ns: u64,
    /// Until when a camera's contradiction may show in other views.
    amid_until_ns: u64,
    admitted: NamingPolicy,
}

/// What may be named by evidence alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct NamingPolicy {
    /// Tags whose sizes may be.
    pub sizes: Vec<Tag>,
    /// Whether whatever is loud may be.
    pub loud: bool,
}

/// For which causes a view's evidence counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Applicability {
    pub camera: bool,
    pub clock: bool,
    pub tag: bool,
}

impl FaultBank {
    /// What a view says of its camera and its tag.
    pub fn take(&mut self, camera: usize, tag: Tag, one: &PoseInnovation, counts: Applicability) {
        let (mut gains, square) = ([0.0; 4], (one.square, one.weight));
        if counts.camera || self.cameras.contains_key(&camera) {
            let of = self
                .cameras
                .entry(camera)
                .or_insert_with(FaultEstimate::camera);
            if one.twist != Vector6::zeros() {
                gains[0] = of.simple.gain(&ClockFault::equations(one), square);
            }
            gains[1] = of.whole.gain(&CameraPoseFault::equations(one), square);
            let (angles, now) = (
                self.angles.entry(camera).or_default(),
                apparent_angles(one, &of.whole.at()),
            );
            *angles = [0, 1].map(|n| angles[n] + (now[n] - angles[n]) / RECENT);
        }
        // A camera that is wrong says nothing about tags.
        let of_camera = [
            FaultHypothesis::Clock(camera),
            FaultHypothesis::Camera(camera),
        ];
        let is_sound = !of_camera.iter().any(|cause| self.found.contains(cause));
        if is_sound && (counts.tag || self.tags.contains_key(&tag)) {
            let of = self.tags.entry(tag).or_insert_with(FaultEstimate::tag);
            gains[2] = of.simple.gain(&TagSizeFault::equations(one), square);
            gains[3] = of.whole.gain(&TagPoseFault::equations(one), square);
        }
        let counted = [counts.clock, counts.camera, counts.tag, counts.tag];
        let cell = self.cells.entry((camera, tag)).or_default();
        for ((evidence, gain), counts) in cell.0.iter_mut().zip(gains).zip(counted) {
            let gain = if counts { gain } else { gain.min(0.0) };
            *evidence += gain - *evidence / MEMORY;
            self.alert |= *evidence > ALERT;
        }
    }

    /// A camera begins to contradict.
    pub fn unsettle_camera(&mut self, camera: usize) {
        self.cameras
            .entry(camera)
            .and_modify(FaultEstimate::unsettle);
    }

    /// A tag begins to contradict.
    pub fn unsettle_tag(&mut self, tag: Tag) {
        self.tags.entry(tag).and_modify(FaultEstimate::unsettle);
    }

    /// Whether something may be wrong, so that all images are to be looked at.
    pub fn is_alert(&self) -> bool {
        self.alert
    }

    pub fn found(&self) -> impl Iterator<Item = FaultHypothesis> {
        self.found.iter().copied()
    }

    /// Decides anew what is wrong, now and then while there is something: the cause that explains most, then what explains most
    /// of the rest.
    pub fn judge(&mut self, time_ns: u64) {
        if !self.alert || time_ns.abs_diff(self.judged_ns) < PAUSE_NS {
            return;
        }
        self.judged_ns = time_ns;
        self.drop_weak();
        self.find(time_ns < self.amid_until_ns);
        if self.found.iter().any(is_of_camera) {
            self.amid_until_ns = time_ns.saturating_add(AMID_NS);
        } else if self.amid_until_ns > 0 && time_ns >= self.amid_until_ns {
            self.amid_until_ns = 0;
            self.forget_tags();
        }
        let mut all = self.cells.values().flat_map(|cell| &cell.0);
        let amid = self.amid_until_ns > 0;
        self.alert = amid || !self.found.is_empty() || all.any(|evidence| *evidence > ALERT);
    }

    fn find(&mut self, mut amid: bool) {
        let mut open: Vec<(usize, Tag)> = self.cells.keys().copied().collect();
        let mut found = BTreeSet::new();
        loop {
            let mut causes = self.sorted_causes(&open);
            causes.retain(|(cause, _)| !found.iter().any(|other| spoils(other, cause)));
            amid |= found.iter().any(is_of_camera);
            let known = |(cause, evidence): &(FaultHypothesis, f64)| {
                self.found.contains(cause) && *evidence >= CLEARED + MARGIN
            };
            let is_new = |one: &&(FaultHypothesis, f64)| {
                self.is_admitted(one, amid) && self.stands_out(&causes, &open)
            };
            let first = causes.first().filter(is_new);
            let Some((cause, _)) = first.or_else(|| causes.iter().find(|one| known(one))) else {
                break;
            };
            open.retain(|cell| !covers(cause, cell));
            found.insert(*cause);
        }
        self.found = found;
    }

    /// Whether evidence alone may name a cause.
    fn is_admitted(&self, (cause, evidence): &(FaultHypothesis, f64), amid: bool) -> bool {
        let is_loud = self.admitted.loud && *evidence > LOUD;
        is_loud
            || !amid
                && matches!(cause, FaultHypothesis::Size(tag) if self.admitted.sizes.contains(tag))
    }

    /// Whether the first of the causes is beyond doubt, though it was not known.
    fn stands_out(&self, causes: &[(FaultHypothesis, f64)], open: &[(usize, Tag)]) -> bool {
        let Some(((cause, evidence), others)) = causes.split_first() else {
            return false;
        };
        let is_rival =
            |other: &FaultHypothesis| share(cause, other, open) && !is_part(cause, other);
        let alternative = others.iter().find(|(other, _)| is_rival(other));
        let alone = alternative.is_none_or(|(_, other)| *other <= evidence - MARGIN);
        *evidence >= RAISED && alone && self.explains(cause)
    }

    /// What was held against tags while tracks were spoilt, unless it was found to be wrong.
    fn forget_tags(&mut self) {
        let found = &self.found;
        let is_found = |tag: &Tag| {
            found.contains(&FaultHypothesis::Size(*tag))
                || found.contains(&FaultHypothesis::Place(*tag))
        };
        self.tags.retain(|tag, _| is_found(tag));
        let others = self.cells.iter_mut().filter(|((_, tag), _)| !is_found(tag));
        others.for_each(|(_, cell)| cell.0[2..].fill(0.0));
    }

    /// What its own parameters speak for no more is over.
    fn drop_weak(&mut self) {
        let mut cells = std::mem::take(&mut self.cells);
        for ((camera, tag), cell) in &mut cells {
            for (cause, evidence) in causes_of(*camera, *tag).iter().zip(&mut cell.0) {
                if *evidence > ALERT && self.strength(cause) < ALERT {
                    *evidence = 0.0;
                }
            }
        }
        self.cells = cells;
    }

    fn estimate(&self, cause: &FaultHypothesis) -> Option<&FaultEstimate> {
        match cause {
            FaultHypothesis::Clock(camera) | FaultHypothesis::Camera(camera) => {
                self.cameras.get(camera)
            }
            FaultHypothesis::Size(tag) | FaultHypothesis::Place(tag) => self.tags.get(tag),
        }
    }

    fn explains(&self, cause: &FaultHypothesis) -> bool {
        let estimate = self.estimate(cause);
        estimate.is_some_and(|of| of.explain()[usize::from(!is_simple(cause))])
    }

    fn strength(&self, cause: &FaultHypothesis) -> f64 {
        let estimate = self.estimate(cause);
        estimate.map_or(0.0, |of| of.strengths()[usize::from(!is_simple(cause))])
    }

    /// The same, the most evidence first.
    fn sorted_causes(&self, open: &[(usize, Tag)]) -> Vec<(FaultHypothesis, f64)> {
        let mut causes = self.causes(open);
        causes.sort_by(|a, b| b.1.total_cmp(&a.1));
        causes
    }

    /// The causes that some evidence speaks for, and how much: never more than their own parameters do.
    fn causes(&self, open: &[(usize, Tag)]) -> Vec<(FaultHypothesis, f64)> {
        let mut sums: BTreeMap<FaultHypothesis, f64> = BTreeMap::new();
        for cell in open {
            let (camera, tag) = *cell;
            for (cause, evidence) in causes_of(camera, tag).iter().zip(self.cells[cell].0) {
                *sums.entry(*cause).or_default() += evidence;
            }
        }
        let counted = |(cause, sum): (FaultHypothesis, f64)| {
            let sum = sum.min(self.strength(&cause));
            let simple = is_simple(&cause);
            let known = self.found.contains(&cause);
            let more =
                [(simple, SIMPLE), (known, MARGIN)].map(|(is, more)| if is { more } else { 0.0 });
            (cause, sum + more.iter().sum::<f64>())
        };
        let some = sums.into_iter().filter(|(_, sum)| *sum > 0.0);
        some.map(counted).collect()
    }

    /// The angles by which a camera's displacement displaces and turns what it sees, in radians.
    pub fn camera(&self, camera: usize) -> Option<[f64; 2]> {
        self.angles.get(&camera).copied()
    }

    /// Whether an offset of the clock explains much of what the camera's displacement does.
    pub fn may_be_clock(&self, camera: usize) -> bool {
        let of_camera = self.cells.iter().filter(|((one, _), _)| *one == camera);
        let [clock, moved] = of_camera.fold([0.0; 2], |sum, (_, cell)| {
            [sum[0] + cell.0[0], sum[1] + cell.0[1]]
        });
        clock > CLOCK_SHARE * moved
    }

    /// How a camera that was found to be moved is displaced.
    pub fn error_of(&self, camera: usize) -> Option<Vector6<f64>> {
        let is_found = self.found.contains(&FaultHypothesis::Camera(camera));
        let estimate = self.cameras.get(&camera).filter(|_| is_found)?;
        Some(estimate.whole.at())
    }

    /// Metres and radians by which a tag is displaced.
    pub fn place(&self, tag: Tag) -> Option<[f64; 2]> {
        let displaced = self.tags.get(&tag)?.whole.at();
        Some([0, 1].map(|part| displaced.fixed_rows::<3>(3 * part).norm()))
    }

    /// Share by which the tag is larger.
    pub fn size(&self, tag: Tag) -> Option<f64> {
        Some(self.tags.get(&tag)?.simple.at()[0])
    }

    /// Forgets what is held against a camera: its stamps mean something else now.
    pub fn forget_camera(&mut self, camera: usize) {
        self.cells.retain(|(one, _), _| *one != camera);
        self.cameras.remove(&camera);
        self.angles.remove(&camera);
        let of_camera = [
            FaultHypothesis::Clock(camera),
            FaultHypothesis::Camera(camera),
        ];
        self.found.retain(|cause| !of_camera.contains(cause));
    }
}

/// The causes of a cell's evidence, in its order.
fn causes_of(camera: usize, tag: Tag) -> [FaultHypothesis; 4] {
    [
        FaultHypothesis::Clock(camera),
        FaultHypothesis::Camera(camera),
        FaultHypothesis::Size(tag),
        FaultHypothesis::Place(tag),
    ]
}

fn covers(cause: &FaultHypothesis, (camera, tag): &(usize, Tag)) -> bool {
    match cause {
        FaultHypothesis::Clock(one) | FaultHypothesis::Camera(one) => one == camera,
        FaultHypothesis::Size(one) | FaultHypothesis::Place(one) => one == tag,
    }
}

fn is_of_camera(cause: &FaultHypothesis) -> bool {
    matches!(
        cause,
        FaultHypothesis::Clock(_) | FaultHypothesis::Camera(_)
    )
}

/// Whether it has one parameter.
fn is_simple(cause: &FaultHypothesis) -> bool {
    matches!(cause, FaultHypothesis::Clock(_) | FaultHypothesis::Size(_))
}

/// Whether what one cause does to a track would pass for the other: a tag that is wrong pulls at its whole object.
fn spoils(one: &FaultHypothesis, other: &FaultHypothesis) -> bool {
    match (one, other) {
        (
            FaultHypothesis::Size(a) | FaultHypothesis::Place(a),
            FaultHypothesis::Size(b) | FaultHypothesis::Place(b),
        ) => a.0 == b.0,
        _ => false,
    }
}

/// Whether the first is the second with fewer parameters.
fn is_part(simple: &FaultHypothesis, of: &FaultHypothesis) -> bool {
    match (simple, of) {
        (FaultHypothesis::Clock(one), FaultHypothesis::Camera(other)) => one == other,
        (FaultHypothesis::Size(one), FaultHypothesis::Place(other)) => one == other,
        _ => false,
    }
}

/// Whether two causes would explain some of the same views.
fn share(a: &FaultHypothesis, b: &FaultHypothesis, cells: &[(usize, Tag)]) -> bool {
    cells.iter().any(|cell| covers(a, cell) && covers(b, cell))
}

#[cfg(test)]
mod tests;
