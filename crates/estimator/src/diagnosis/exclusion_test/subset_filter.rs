//! A track without one that may be wrong, what it costs, and what is held against the one.

use std::collections::BTreeMap;

use crate::diagnosis::fault_bank::{MEMORY, RAISED, RECENT};
use crate::diagnosis::fault_estimate::FaultEstimate;
use crate::diagnosis::fault_model::FaultModel;
use crate::diagnosis::fault_model::camera::{CameraPoseFault, apparent_angles};
use crate::diagnosis::fault_model::clock::ClockFault;
use crate::diagnosis::fault_model::tag_pose::TagPoseFault;
use crate::diagnosis::fault_model::tag_size::TagSizeFault;
use crate::diagnosis::predictive_cost::{PredictiveCost, are_of_one_link};
use crate::diagnosis::replay_buffer::Instant;
use crate::measurement::pose_innovation::PoseInnovation;
use crate::site::{ClockPrior, ObjectImage, Site};
use crate::tracker::finalised_views::FinalisedView;
use crate::tracker::track::Track;
use crate::{ClockOffset, FusionOptions, TagId};

/// Sigmas by which a clock must be off, and seconds.
const SURE: f64 = 5.0;
const LEAST_S: f64 = 0.001;

/// What is left out of a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Excluded {
    Camera(usize),
    Tag(TagId),
    /// What a camera's stamps say: its clock is estimated.
    Clock(usize),
}

/// A track without one that may be wrong.
#[derive(Debug)]
pub(crate) struct SubsetFilter {
    pub left_out: Option<Excluded>,
    track: Track,
    /// Whether it began with what motion has told of clocks.
    knows_clocks: bool,
    /// Instants that it has been taken through.
    pub done: usize,
    pub cost: Cost,
    /// Of a camera whose clock is estimated.
    trial: Trial,
    /// Fault of what is left out, and what speaks for it by camera and tag: for one parameter and for a displacement.
    pub estimate: FaultEstimate,
    pub cells: BTreeMap<(usize, TagId), [f64; 2]>,
    /// By which a camera displaces what it sees, and turns it.
    pub angles: [f64; 2],
}

/// What a track costs, as logarithms of odds.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cost {
    /// By which what remains contradicts.
    pub misfit: f64,
    /// What noise alone makes of that on the average.
    pub usual: f64,
    /// By how much less sure the track was than what it sees.
    pub vague: f64,
}

/// How a clock is tried. When it jumped is not known, but that it was before the contest: until then the camera is left out.
#[derive(Debug, Clone, Copy, Default)]
struct Trial {
    /// The instant with which it begins.
    from: usize,
    /// The offset that was known before, in seconds.
    offset_s: f64,
    /// The camera's images since.
    images: usize,
}

impl Excluded {
    pub fn covers(self, camera: usize, tag: TagId) -> bool {
        match self {
            Self::Camera(own) | Self::Clock(own) => own == camera,
            Self::Tag(own) => own == tag,
        }
    }

    /// The camera that it is about.
    pub fn camera(self) -> Option<usize> {
        match self {
            Self::Camera(camera) | Self::Clock(camera) => Some(camera),
            Self::Tag(_) => None,
        }
    }
}

impl SubsetFilter {
    /// It begins with this track; its clock, if it is about one, is tried from the instant `from` on.
    pub fn new(left_out: Option<Excluded>, track: Track, from: usize) -> Self {
        Self {
            left_out,
            knows_clocks: track.knows_clocks(),
            track,
            done: 0,
            cost: Cost::default(),
            trial: Trial {
                from,
                ..Trial::default()
            },
            estimate: match left_out {
                Some(Excluded::Tag(_)) => FaultEstimate::tag(),
                _ => FaultEstimate::camera(),
            },
            cells: BTreeMap::new(),
            angles: [0.0; 2],
        }
    }

    /// Goes on by an instant, without what is known to be wrong.
    pub fn take(
        &mut self,
        instant: &Instant,
        known: &[Excluded],
        site: &Site,
        options: &FusionOptions,
    ) {
        let tried = self.try_clock(options);
        self.done += 1;
        let out = self.left_out.filter(|_| tried.is_none());
        let is_known = |camera, tag| known.iter().any(|one| one.covers(camera, tag));
        let is_own = |camera, tag| out.is_some_and(|one| one.covers(camera, tag));
        let images = instant.images.values();
        let part = |own: bool| {
            let of = move |camera, tag| !is_known(camera, tag) && is_own(camera, tag) == own;
            let parts = images.clone().map(|image| image.of(of));
            let parts = parts.filter(|image| !image.views.is_empty());
            parts.collect::<Vec<ObjectImage>>()
        };
        let (mut rest, own) = (part(false), part(true));
        let of_tried = |image: &&mut ObjectImage| Some(image.camera_index) == tried;
        for image in rest.iter_mut().filter(of_tried) {
            image.clock = ClockPrior::Within(options.unknown_clock_s);
            self.trial.images += 1;
        }
        if !self.knows_clocks {
            let left_out = || known.iter().chain(&self.left_out);
            let out = |camera| left_out().any(|one| one.camera() == Some(camera));
            put_first_in_charge(&mut rest, site, out);
        }
        if !rest.is_empty() {
            let rest: Vec<&ObjectImage> = rest.iter().collect();
            self.track = self.track.advanced(instant.time_ns, &rest, site, options);
            let views = self.track.finalised_views(&rest, site, options, |_| true);
            if views.is_empty() {
                // Where even the attitude is in doubt nothing is explained.
                self.cost.misfit += options.refused_odds;
            }
            self.score(&views, options);
        }
        for image in own {
            let views = self.track.excluded_views(&image, site, options);
            self.update_fault(&views, options);
        }
    }

    /// The camera whose clock is tried with the next instant, if one is. What is known of it may be of no use any more.
    fn try_clock(&mut self, options: &FusionOptions) -> Option<usize> {
        let camera = self.clock().filter(|_| self.done >= self.trial.from)?;
        if self.done == self.trial.from {
            self.trial.offset_s = self.offset().map_or(0.0, |own| own.offset_s);
            self.track.doubt_clocks(&[camera], options.unknown_clock_s);
        }
        Some(camera)
    }

    /// What remains contradicts by so much; a single image by no more than one that takes no part.
    fn score(&mut self, views: &[FinalisedView], options: &FusionOptions) {
        for image in views.chunk_by(are_of_one_link) {
            let hit = image.iter().any(|view| view.hit);
            self.cost.misfit += if hit { options.jolt_odds } else { 0.0 };
            if let Some(misfit) = PredictiveCost::of(image) {
                let most = options.refused_odds;
                self.cost.misfit += misfit.shared.min(most) + misfit.apart.min(most);
                self.cost.usual += misfit.usual;
                self.cost.vague += misfit.vague;
            }
        }
    }

    /// Hears what is left out. To leave a camera out excuses where all that it sees seems to be, not how its views lie to each other.
    fn update_fault(&mut self, views: &[FinalisedView], options: &FusionOptions) {
        let is_tag = matches!(self.left_out, Some(Excluded::Tag(_)));
        for image in views.chunk_by(are_of_one_link) {
            if let Some(misfit) = PredictiveCost::of(image) {
                let most = if is_tag { 0.0 } else { options.refused_odds };
                self.cost.misfit += misfit.apart.min(most);
                self.cost.vague += misfit.vague;
            }
        }
        for view in views {
            let residual = view.residual.as_ref();
            if let Some(marginalised) =
                residual.and_then(|one| one.apart_from(&one.bias_covariance()))
            {
                self.record((view.camera_index, view.tag), &marginalised);
            }
        }
    }

    fn record(&mut self, cell: (usize, TagId), marginalised: &PoseInnovation) {
        let square = (marginalised.square, marginalised.weight);
        let FaultEstimate { simple, whole, .. } = &mut self.estimate;
        let gains = match self.left_out {
            Some(Excluded::Tag(_)) => [
                simple.gain(&TagSizeFault::equations(marginalised), square),
                whole.gain(&TagPoseFault::equations(marginalised), square),
            ],
            _ => [
                simple.gain(&ClockFault::equations(marginalised), square),
                whole.gain(&CameraPoseFault::equations(marginalised), square),
            ],
        };
        let now = apparent_angles(marginalised, &whole.at());
        for (angle, now) in self.angles.iter_mut().zip(now) {
            *angle += (now - *angle) / RECENT;
        }
        let cell = self.cells.entry(cell).or_default();
        for (evidence, gain) in cell.iter_mut().zip(gains) {
            *evidence += gain - *evidence / MEMORY;
        }
    }

    /// What speaks for a fault of one parameter, and for a displacement: never more than their own parameters do.
    pub fn evidences(&self) -> [f64; 2] {
        let strengths = self.estimate.strengths();
        let sum = |cause: usize| self.cells.values().map(|cell| cell[cause]).sum::<f64>();
        [0, 1].map(|cause| sum(cause).min(strengths[cause]))
    }

    fn evidence(&self) -> f64 {
        let [simple, whole] = self.evidences();
        simple.max(whole)
    }

    /// Whether what is left out has a fault that explains it.
    pub fn is_faulty(&self) -> bool {
        match self.clock() {
            Some(_) => self.has_jumped(),
            None => self.evidence() > RAISED && self.estimate.explain().contains(&true),
        }
    }

    /// Whether the clock that is tried is off by more than was known.
    fn has_jumped(&self) -> bool {
        self.offset().is_some_and(|own| {
            (own.offset_s - self.trial.offset_s).abs() > LEAST_S.max(SURE * own.sigma_s)
        })
    }

    /// The camera that it is about.
    pub fn camera(&self) -> Option<usize> {
        self.left_out?.camera()
    }

    /// If a clock is tried, with how many images.
    pub fn images_tried(&self) -> Option<usize> {
        self.clock().map(|_| self.trial.images)
    }

    fn clock(&self) -> Option<usize> {
        match self.left_out {
            Some(Excluded::Clock(camera)) => Some(camera),
            _ => None,
        }
    }

    fn offset(&self) -> Option<ClockOffset> {
        let mut offsets = self.track.clock_offsets();
        let own = offsets.find(|(camera, _)| Some(*camera) == self.clock());
        own.map(|(_, own)| own)
    }
}

/// Where the reference is left out of what is told of clocks, the first of the others is: else what contradicts would pass for the
/// offset that all of them have in common.
fn put_first_in_charge(images: &mut [ObjectImage], site: &Site, out: impl Fn(usize) -> bool) {
    let first = (0..site.cameras().len()).find(|camera| !out(*camera));
    let is_first = |image: &&mut ObjectImage| Some(image.camera_index) == first;
    let is_open = |image: &&mut ObjectImage| image.clock == ClockPrior::Unknown;
    if out(site.reference()) {
        let first = images.iter_mut().filter(is_first).filter(is_open);
        first.for_each(|image| image.clock = ClockPrior::Right);
    }
}
