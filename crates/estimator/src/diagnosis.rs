//! What is wrong with the site, by name: which camera was moved, which tag is loose, wrongly measured or there twice, which clock
//! is off.
//!
//! Fed with instants that no late image can change any more. What the views of a tag by a camera contradict is explained by the
//! fault that foretells it best ([`fault_bank`]), if those that have nothing to do with that fault go on to agree ([`support`]). Who is
//! wrong is found by leaving each suspect out ([`inquiry`], [`exclusion_test`]).

pub(crate) mod consistency_tally;
pub(crate) mod duty_cycle;
pub(crate) mod exclusion_test;
pub(crate) mod fading_counter;
pub(crate) mod fault_bank;
pub(crate) mod fault_estimate;
pub(crate) mod fault_model;
pub(crate) mod isolation;
pub(crate) mod manoeuvre_detector;
pub(crate) mod misplaced_tags;
pub(crate) mod predictive_cost;
pub(crate) mod recursive_estimate;
pub(crate) mod replay_buffer;

use std::collections::{BTreeMap, BTreeSet};

use crate::TagId;
use crate::diagnosis::consistency_tally::ConsistencyTally;
use crate::diagnosis::duty_cycle::DutyCycle;
use crate::diagnosis::exclusion_test::ExclusionTest;
use crate::diagnosis::fading_counter::FadingCounter;
use crate::diagnosis::fault_bank::{Applicability, FaultBank, FaultHypothesis};
use crate::diagnosis::manoeuvre_detector::ManoeuvreDetector;
use crate::diagnosis::misplaced_tags::MisplacedTags;
use crate::diagnosis::replay_buffer::ReplayBuffer;
pub(crate) use crate::measurement::pose_innovation::{PoseInnovation, ViewResidual};
use crate::tracker::finalised_views::FinalisedView;

/// Views, counted with that memory, from which on a share means something.
const FEWEST: f64 = 3.0;
/// Share of contradicting views from which on it is asked whether the camera's clock is the cause.
const DOUBTED: f64 = 0.5;
/// The same down to which a camera that was found to be moved stays so.
const RIGHTED: f64 = 0.3;
/// Angles by which a camera displaces what it sees, or turns it, that are worth a word.
const MOVED: [f64; 2] = [0.0026, 0.0087];
/// Metres and radians of a tag that are.
const MISPLACED: [f64; 2] = [0.001, 0.035];
/// Relative error of a tag's size that is.
const WRONG_SIZE: f64 = 0.01;

/// Nanoseconds after a hit by another camera's image for which a body's speed tells nothing of clocks.
const HIT_NS: u64 = 300_000_000;
/// Nanoseconds for which a tag that was seen twice is reported.
const TWINS_NS: u64 = 2_000_000_000;
/// Such tags at one time; further ones are passed over.
const MOST_TWINS: usize = 1024;
/// Instants at which an object seemed to be hit, fading, that are too many to be hits.
const OFTEN: f64 = 2.5;
/// Nanoseconds for which a camera contradicts after which no question about clocks keeps it from being named.
const OLD_NS: u64 = 1_000_000_000;

/// A camera that is not where the rig says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MovedCamera {
    pub camera: usize,
    /// The only other camera that it contradicts: it may be that one as well.
    pub or: Option<usize>,
    /// Whether its clock is out of question.
    pub timely: bool,
}

/// The counts of a site, and what is wrong by them.
#[derive(Debug, Default)]
pub(crate) struct Diagnosis {
    cameras: BTreeMap<usize, FadingCounter>,
    fault_bank: FaultBank,
    of_cameras: ConsistencyTally<usize>,
    of_tags: ConsistencyTally<TagId>,
    /// By object, when it last seemed to be hit, and by which camera's image.
    hit: BTreeMap<usize, (u64, usize)>,
    /// By object, how often it lately seemed to be hit.
    hits: BTreeMap<usize, FadingCounter>,
    /// Cameras that seem to have been moved. Such a one stays while most of its views contradict: a track that gives way to some of
    /// them, by doubting its clock, makes what they foretell weaker, not the camera right.
    /// With the time since when, ns, and whether its clock is out of question.
    moved: BTreeMap<usize, (u64, bool)>,
    /// By camera that may have been moved, those that it contradicts.
    against: BTreeMap<usize, BTreeSet<usize>>,
    misplaced_tags: MisplacedTags,
    /// When a tag was last in an image twice, by camera index.
    twice_ns: BTreeMap<(usize, TagId), u64>,
    newest_ns: u64,
    /// By object, its last settled images.
    replay_buffers: BTreeMap<usize, ReplayBuffer>,
    exclusion_test: Option<ExclusionTest>,
    /// Until when no contest is held, ns.
    rests_until_ns: u64,
    duty_cycle: DutyCycle,
    manoeuvring: ManoeuvreDetector,
}

impl Diagnosis {
    /// Takes the views of one object at a settled instant in.
    pub fn take(&mut self, object: usize, time_ns: u64, views: &[FinalisedView]) {
        self.count(object, time_ns, views);
        for view in views {
            if !view.agreed && self.others_agree(object, time_ns, view) {
                self.misplaced_tags.refuse(object, time_ns, view);
            }
            self.record(object, time_ns, view);
        }
        if self.fault_bank.is_alert() {
            self.fault_bank.judge(time_ns);
            self.note_whom_moved_cameras_contradict(object, time_ns);
        }
        let of_camera = |camera: usize| {
            let count = self.cameras.get(&camera)?.faded(time_ns);
            Some((count.views, count.refused))
        };
        self.misplaced_tags.judge(time_ns, of_camera);
    }

    /// Who agrees and who contradicts.
    fn count(&mut self, object: usize, time_ns: u64, views: &[FinalisedView]) {
        if !views.is_empty() {
            let is_hit = views.iter().any(|view| view.hit);
            self.hits.entry(object).or_default().add(time_ns, !is_hit);
        }
        for view in views {
            let camera = self.cameras.entry(view.camera_index).or_default();
            camera.add(time_ns, view.agreed);
            if self.of_tags.note(object, view.tag, time_ns, view.agreed) {
                self.fault_bank.unsettle_tag((object, view.tag));
            }
            if view.hit {
                self.hit.insert(object, (time_ns, view.camera_index));
            }
        }
        for image in views.chunk_by(|a, b| a.camera_index == b.camera_index) {
            let camera = image[0].camera_index;
            let agreed = image.iter().any(|view| view.agreed);
            if self.of_cameras.note(object, camera, time_ns, agreed) {
                self.fault_bank.unsettle_camera(camera);
            }
        }
    }

    /// Whether other tags or cameras go on to agree with the object's track: else it is the track that is wrong.
    fn others_agree(&self, object: usize, time_ns: u64, view: &FinalisedView) -> bool {
        let mut cameras = self.of_cameras.of(object, view.camera_index, time_ns);
        let mut tags = self.of_tags.of(object, view.tag, time_ns);
        cameras.next().is_some() || tags.next().is_some()
    }

    fn record(&mut self, object: usize, time_ns: u64, view: &FinalisedView) {
        let Some(residual) = &view.residual else {
            return;
        };
        let Some(innovation) = self.marginalised(view.camera_index, residual) else {
            return;
        };
        let mut cameras = self.of_cameras.of(object, view.camera_index, time_ns);
        let mut tags = self.of_tags.of(object, view.tag, time_ns);
        let hit = self.hit.get(&object).copied().unwrap_or_default();
        let is_steady = hit.1 == view.camera_index || hit.0.saturating_add(HIT_NS) < time_ns;
        let is_near = view.elsewhere.is_none();
        let camera_is_wrong = self.of_cameras.contradicts(object, view.camera_index);
        let camera = cameras.next().is_some() && (is_near || camera_is_wrong);
        let counts = Applicability {
            camera,
            clock: camera && is_steady,
            tag: tags.next().is_some() && is_near,
        };
        let tag = (object, view.tag);
        self.fault_bank
            .take(view.camera_index, tag, &innovation, counts);
    }

    /// What a view says apart from what stated errors explain.
    fn marginalised(&self, camera: usize, residual: &ViewResidual) -> Option<PoseInnovation> {
        if residual.displacing.is_empty() {
            return residual.marginalised();
        }
        let mut biases = residual.bias_covariance();
        for one in &residual.displacing {
            let other = one.of_camera().filter(|other| *other != camera);
            if let Some(error) = other.and_then(|other| self.fault_bank.error_of(other)) {
                let displacement = one.by * error;
                biases += displacement * displacement.transpose();
            }
        }
        residual.apart_from(&biases)
    }

    fn note_whom_moved_cameras_contradict(&mut self, object: usize, time_ns: u64) {
        let cameras = &self.cameras;
        let is_wrong = |camera: &usize| cameras.get(camera).is_some_and(|of| of.share() > RIGHTED);
        self.moved.retain(|camera, _| is_wrong(camera));
        for camera in self.fault_bank.found().filter_map(of_moved) {
            let angles = self.fault_bank.camera(camera).unwrap_or_default();
            if angles[0] > MOVED[0] || angles[1] > MOVED[1] {
                let (_, timely) = self.moved.entry(camera).or_insert((time_ns, false));
                *timely |= !self.fault_bank.may_be_clock(camera);
            }
        }
        self.against
            .retain(|camera, _| self.moved.contains_key(camera));
        for camera in self.moved.keys() {
            let against = self.against.entry(*camera).or_default();
            against.extend(self.of_cameras.of(object, *camera, time_ns));
        }
    }

    /// Whether something may be wrong, so that all images are to be looked at.
    pub fn is_alert(&self) -> bool {
        self.fault_bank.is_alert()
    }

    /// Notes the tags that an image has more than once.
    pub fn record_duplicates(
        &mut self,
        camera_index: usize,
        time_ns: u64,
        tags: impl Iterator<Item = TagId>,
    ) {
        let mut seen = BTreeSet::new();
        self.newest_ns = self.newest_ns.max(time_ns);
        for tag in tags {
            let key = (camera_index, tag);
            let has_room = self.twice_ns.len() < MOST_TWINS || self.twice_ns.contains_key(&key);
            if !seen.insert(tag) && has_room {
                self.twice_ns.insert(key, time_ns);
            }
        }
        let oldest_ns = self.newest_ns.saturating_sub(TWINS_NS);
        self.twice_ns.retain(|_, at_ns| *at_ns >= oldest_ns);
    }

    /// The tags that a camera has lately seen twice.
    pub fn duplicate_tags(&self) -> impl Iterator<Item = (usize, TagId)> {
        self.twice_ns.keys().copied()
    }

    /// Forgets all: the models have changed.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The tags that are seen where their objects can't have them, by object index, and the object that they are seen on.
    pub fn misplaced_tags(&self) -> impl Iterator<Item = (usize, TagId, Option<usize>)> {
        self.misplaced_tags
            .found()
            .map(|((object, tag), on)| (object, tag, on))
    }

    /// The cameras most of whose views contradict their tracks, by index: for whatever cause.
    pub fn contradicted_cameras(&self) -> impl Iterator<Item = usize> {
        let is_contradicted =
            |count: &FadingCounter| count.views >= FEWEST && count.share() > DOUBTED;
        let cameras = self.cameras.iter();
        cameras
            .filter(move |(_, count)| is_contradicted(count))
            .map(|(camera, _)| *camera)
    }

    /// The cameras that are not where the rig says.
    pub fn moved_cameras(&self) -> impl Iterator<Item = MovedCamera> {
        let moved = |(&camera, &(since_ns, timely)): (&usize, &(u64, bool))| {
            let mut against = self.against.get(&camera)?.iter().copied();
            let first = against.next()?;
            let or = against.next().is_none().then_some(first);
            let is_old = self.newest_ns.saturating_sub(since_ns) > OLD_NS;
            let timely = timely || is_old;
            Some(MovedCamera { camera, or, timely })
        };
        self.moved.iter().filter_map(moved)
    }

    /// The tags that are not as the models say, by object index; with the ratio of sizes where that explains it.
    pub fn wrong_tags(&self) -> impl Iterator<Item = (usize, TagId, Option<f64>)> {
        let wrong = |cause| match cause {
            FaultHypothesis::Size(tag) if !self.misplaced_tags.contains(&tag) => {
                let more = self.fault_bank.size(tag)?;
                let worth = more.abs() > WRONG_SIZE;
                worth.then_some((tag.0, tag.1, Some(1.0 + more)))
            }
            FaultHypothesis::Place(tag) if !self.misplaced_tags.contains(&tag) => {
                let [place, turn] = self.fault_bank.place(tag)?;
                let worth = place > MISPLACED[0] || turn > MISPLACED[1];
                worth.then_some((tag.0, tag.1, None))
            }
            _ => None,
        };
        self.fault_bank.found().filter_map(wrong)
    }

    /// The cameras whose stamps explain what they contradict, by index.
    pub fn clocks(&self) -> impl Iterator<Item = usize> {
        let of_clock = |cause| match cause {
            FaultHypothesis::Clock(camera) => Some(camera),
            _ => None,
        };
        self.fault_bank.found().filter_map(of_clock)
    }

    /// The same, and what is held against them is forgotten: their clocks are estimated from now on.
    pub fn take_clocks(&mut self) -> Vec<usize> {
        let clocks: Vec<usize> = self.clocks().collect();
        for camera in &clocks {
            self.fault_bank.forget_camera(*camera);
        }
        clocks
    }
}

fn of_moved(cause: FaultHypothesis) -> Option<usize> {
    match cause {
        FaultHypothesis::Camera(camera) => Some(camera),
        _ => None,
    }
}
