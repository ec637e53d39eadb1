//! Who is wrong where views contradict one another: the one without whom all others agree.
//!
//! After a fault a track follows what is wrong in part, and innocent ones contradict it as loudly. So from before the suspicion on the
//! object is tracked anew without the images of each camera, and without the views of each tag, that may be to blame, and what
//! remains is scored: by how far each image is from what is expected of it ([`super::misfit`]). To leave a camera out excuses where all that
//! it sees seems to be, not how its views lie to each other. What is left out is held against that track, which it can't spoil,
//! and must be explained by a fault of its own.
//!
//! Bounded: each image takes each of the tracks a few instants further, those of one object and of few contenders.

use std::collections::BTreeMap;

use super::accused::Accused;
use super::lasting::Lasting;
use super::misfit::{Misfit, are_of_one_link};
use super::recall::{Instant, Recall};
use super::suspects::{Admitted, MEMORY, RAISED, RECENT};
use super::testimony::Testimony;
use super::{Account, SettledView};
use crate::site::{ObjectImage, Site, StatedClock};
use crate::track::Track;
use crate::{FusionOptions, TagId};

/// Contenders at most.
const MOST: usize = 16;
/// Instants that a track is taken on at most with each that comes.
const STEPS: usize = 6;
/// Share of the misfit that must be gone without the one that is named, and the most that may be left of what is left without another.
const GONE: f64 = 0.7;
const LESS: f64 = 0.5;
/// Share of the misfit by which another may explain more than one that other evidence speaks against, and as a logarithm of odds.
const HARDLY_MORE: f64 = 0.2;
const ABOUT_AS_MUCH: f64 = 10.0;
/// Nanoseconds of a contest before which it says nothing of tags.
const YOUNG_NS: u64 = 200_000_000;
/// The same after which it is enough to explain half, and more than others do.
const LONG_NS: u64 = 1_000_000_000;

/// What is left out of a track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LeftOut {
    Camera(usize),
    Tag(TagId),
}

/// The contest about one object.
#[derive(Debug)]
pub(super) struct Contest {
    pub object: usize,
    since_ns: u64,
    /// How long it has been held, ns.
    age_ns: u64,
    /// As it was known before.
    lasting: Lasting,
    /// What is known to be wrong, and left out of all tracks.
    known: Vec<LeftOut>,
    /// Cameras that it is among.
    cameras: usize,
    /// The track of all that remain, and those without one of them.
    all: Contender,
    contenders: Vec<Contender>,
    /// Instants that there are.
    instants: usize,
}

/// A track without one that may be wrong.
#[derive(Debug)]
pub(super) struct Contender {
    pub left_out: Option<LeftOut>,
    track: Track,
    /// Whether it began with what motion has told of clocks.
    knows_clocks: bool,
    /// What its images have shown of stated errors.
    lasting: Lasting,
    /// Instants that it has been taken through.
    done: usize,
    /// By which what remains contradicts, as a logarithm of odds.
    misfit: f64,
    /// Fault of what is left out, and what speaks for it by camera and tag: for one parameter and for a displacement.
    pub accused: Accused,
    pub cells: BTreeMap<(usize, TagId), [f64; 2]>,
    /// By which a camera displaces what it sees, and turns it.
    pub angles: [f64; 2],
}

impl LeftOut {
    fn covers(self, camera: usize, tag: TagId) -> bool {
        match self {
            Self::Camera(own) => own == camera,
            Self::Tag(own) => own == tag,
        }
    }
}

impl Contest {
    pub fn new(object: usize, now_ns: u64, lasting: &Lasting, recall: &Recall) -> Self {
        Self {
            object,
            since_ns: now_ns,
            age_ns: 0,
            lasting: lasting.clone(),
            known: Vec::new(),
            cameras: 0,
            all: Contender::new(None, recall.start(), lasting),
            contenders: Vec::new(),
            instants: recall.len(),
        }
    }

    /// Who may be wrong: those who are new join in. `known` is wrong for certain.
    pub fn call(
        &mut self,
        known: Vec<LeftOut>,
        cameras: &[usize],
        tags: &[TagId],
        recall: &Recall,
    ) {
        if known != self.known {
            self.known = known;
            self.all = Contender::new(None, recall.start(), &self.lasting);
            self.contenders.clear();
        }
        let cameras = cameras.iter().map(|camera| LeftOut::Camera(*camera));
        let mut cameras: Vec<_> = cameras.filter(|one| !self.known.contains(one)).collect();
        self.cameras = cameras.len();
        // One camera alone contradicts nobody.
        cameras.retain(|_| self.cameras > 1);
        for one in cameras
            .into_iter()
            .chain(tags.iter().copied().map(LeftOut::Tag))
        {
            let has = |other: &Contender| other.left_out == Some(one);
            let is_new = !self.known.contains(&one) && !self.contenders.iter().any(has);
            if is_new && self.contenders.len() < MOST {
                let contender = Contender::new(Some(one), recall.start(), &self.lasting);
                self.contenders.push(contender);
            }
        }
    }

    /// Takes the tracks further on.
    pub fn advance(&mut self, now_ns: u64, recall: &Recall, site: &Site, options: &FusionOptions) {
        self.age_ns = now_ns.saturating_sub(self.since_ns);
        let come = recall.len().saturating_sub(self.instants).max(1);
        self.instants = recall.len();
        let known = &self.known;
        for one in std::iter::once(&mut self.all).chain(&mut self.contenders) {
            for _ in 0..STEPS * come {
                let Some(instant) = recall.instant(one.done) else {
                    break;
                };
                one.take(instant, known, site, options);
            }
        }
    }

    /// The contenders by how much is gone without them, the most first, but those who have not caught up; `None` while the track of all
    /// has not.
    fn ranked(&self) -> Option<Vec<(f64, &Contender)>> {
        let is_level = |one: &&Contender| one.done == self.instants;
        if !is_level(&&self.all) {
            return None;
        }
        let ranked = self.contenders.iter().filter(is_level);
        let mut ranked: Vec<_> = ranked
            .map(|one| (self.all.misfit - one.misfit, one))
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        Some(ranked)
    }

    /// The one that is wrong, if that is clear. Of two cameras nobody can tell which it is: either stands for both.
    pub fn verdict(&self) -> Option<LeftOut> {
        let ranked = self.ranked()?;
        let (most, _) = ranked.first()?;
        let mut faulty = ranked.iter().filter(|(_, one)| one.is_faulty());
        let (gone, first) = faulty.next()?;
        let of_two = |one: &Contender| {
            let is_camera = |of: &Contender| matches!(of.left_out, Some(LeftOut::Camera(_)));
            self.cameras == 2 && is_camera(first) && is_camera(one)
        };
        let rival = faulty.find(|(_, one)| !of_two(one));
        let left_by_rival = rival.map_or(self.all.misfit, |(_, one)| one.misfit);
        let gone_by_rival = rival.map_or(0.0, |(gone, _)| *gone);
        // One without a fault of its own may explain a little more, for it leaves out more: it is no rival of one that explains nearly all.
        let explains = |share: f64| *gone > share * self.all.misfit;
        let explains_most = explains(GONE) && first.misfit < LESS * left_by_rival;
        // What nobody explains may be errors that nobody states, or that are as stated.
        let is_first = *gone > most - ABOUT_AS_MUCH;
        let explains_more =
            self.is_long() && is_first && explains(LESS) && gone_by_rival < LESS * gone;
        let stands_out = *gone > RAISED
            && first.misfit < left_by_rival - RAISED
            && (explains_most || explains_more);
        stands_out.then_some(first.left_out).flatten()
    }

    /// The contender for whom that is left out.
    pub fn into_contender(self, left_out: LeftOut) -> Option<Contender> {
        let mut all = self.contenders.into_iter();
        all.find(|one| one.left_out == Some(left_out))
    }

    /// Whether it has been held for longer than a single fault takes.
    fn is_long(&self) -> bool {
        self.age_ns > LONG_NS
    }

    /// What evidence alone may name: sizes of tags than which no other explains much more, and whatever is loud where errors are not
    /// stated.
    pub fn admitted(&self, site: &Site) -> Admitted {
        Admitted {
            sizes: self.likely_tags(),
            loud: !site.states_errors(),
        }
    }

    /// What must be gone without one who explains about as much as the most.
    fn about(&self, most: f64) -> f64 {
        most - ABOUT_AS_MUCH.max(HARDLY_MORE * self.all.misfit)
    }

    fn likely_tags(&self) -> Vec<(usize, TagId)> {
        let is_old = self.age_ns > YOUNG_NS;
        let ranked = self.ranked().filter(|_| is_old).unwrap_or_default();
        let most = ranked.first().map_or(0.0, |(gone, _)| *gone);
        let enough = self.about(most);
        let ranked = ranked.into_iter().filter(move |(gone, _)| *gone >= enough);
        let tag_of = |(_, one): (f64, &Contender)| match one.left_out {
            Some(LeftOut::Tag(tag)) => Some((self.object, tag)),
            _ => None,
        };
        ranked.filter_map(tag_of).collect()
    }
}

impl Contender {
    fn new(left_out: Option<LeftOut>, track: Track, lasting: &Lasting) -> Self {
        Self {
            left_out,
            knows_clocks: track.knows_clocks(),
            track,
            lasting: lasting.clone(),
            done: 0,
            misfit: 0.0,
            accused: match left_out {
                Some(LeftOut::Tag(_)) => Accused::tag(),
                _ => Accused::camera(),
            },
            cells: BTreeMap::new(),
            angles: [0.0; 2],
        }
    }

    fn take(&mut self, instant: &Instant, known: &[LeftOut], site: &Site, options: &FusionOptions) {
        self.done += 1;
        let is_known = |camera, tag| known.iter().any(|one| one.covers(camera, tag));
        let is_own = |camera, tag| self.left_out.is_some_and(|one| one.covers(camera, tag));
        let images = instant.images.values();
        let part = |own: bool| {
            let of = move |camera, tag| !is_known(camera, tag) && is_own(camera, tag) == own;
            let parts = images.clone().map(|image| image.of(of));
            let parts = parts.filter(|image| !image.views.is_empty());
            parts.collect::<Vec<ObjectImage>>()
        };
        let (mut rest, own) = (part(false), part(true));
        if !self.knows_clocks {
            let out = |camera| {
                let camera = LeftOut::Camera(camera);
                self.left_out == Some(camera) || known.contains(&camera)
            };
            put_first_in_charge(&mut rest, site, out);
        }
        if !rest.is_empty() {
            let rest: Vec<&ObjectImage> = rest.iter().collect();
            self.track = self.track.advanced(instant.time_ns, &rest, site, options);
            let views = self
                .track
                .settled_views(&rest, site, options, |_| true, None);
            if views.is_empty() {
                // Where even the attitude is in doubt nothing is explained.
                self.misfit += options.refused_odds;
            }
            self.score(&views, options);
        }
        for image in own {
            let views = self.track.views_aside(&image, site, options);
            self.accuse(&views, options);
        }
    }

    /// What remains contradicts by so much; a single image by no more than one that takes no part.
    fn score(&mut self, views: &[SettledView], options: &FusionOptions) {
        for image in views.chunk_by(are_of_one_link) {
            let hit = image.iter().any(|view| view.hit);
            self.misfit += if hit { options.jolt_odds } else { 0.0 };
            if let Some(misfit) = Misfit::of(image, &mut self.lasting) {
                let most = options.refused_odds;
                self.misfit += misfit.shared.min(most) + misfit.apart.min(most);
                misfit.teach(self.track.time_ns, &mut self.lasting);
            }
        }
    }

    /// Hears what is left out.
    fn accuse(&mut self, views: &[SettledView], options: &FusionOptions) {
        if let Some(LeftOut::Camera(_)) = self.left_out {
            for image in views.chunk_by(are_of_one_link) {
                let misfit = Misfit::of(image, &mut self.lasting);
                let apart = misfit.map_or(0.0, |misfit| misfit.apart);
                self.misfit += apart.min(options.refused_odds);
            }
        }
        for view in views {
            let account = view.account.as_ref();
            if let Some(told) = account.and_then(|one| told(view, one, &mut self.lasting)) {
                self.hear((view.camera_index, view.tag), &told);
            }
        }
    }

    fn hear(&mut self, cell: (usize, TagId), told: &Testimony) {
        let square = (told.square, told.weight);
        let Accused { simple, whole, .. } = &mut self.accused;
        let gains = match self.left_out {
            Some(LeftOut::Tag(_)) => [
                simple.gain(&told.of_size(), square),
                whole.gain(&told.of_place(), square),
            ],
            _ => [
                simple.gain(&told.of_clock(), square),
                whole.gain(&told.of_camera(), square),
            ],
        };
        let now = told.angles(&whole.at());
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
        let strengths = self.accused.strengths();
        let sum = |cause: usize| self.cells.values().map(|cell| cell[cause]).sum::<f64>();
        [0, 1].map(|cause| sum(cause).min(strengths[cause]))
    }

    /// Whether what is left out has a fault that explains it.
    fn is_faulty(&self) -> bool {
        self.evidence() > RAISED && self.accused.explain().contains(&true)
    }

    fn evidence(&self) -> f64 {
        let [simple, whole] = self.evidences();
        simple.max(whole)
    }
}

/// Where the reference is left out of what is told of clocks, the first of the others is: else what contradicts would pass for the
/// offset that all of them have in common.
fn put_first_in_charge(images: &mut [ObjectImage], site: &Site, out: impl Fn(usize) -> bool) {
    let first = (0..site.cameras().len()).find(|camera| !out(*camera));
    let is_first = |image: &&mut ObjectImage| Some(image.camera_index) == first;
    let is_open = |image: &&mut ObjectImage| image.clock == StatedClock::Unknown;
    if out(site.reference()) {
        let first = images.iter_mut().filter(is_first).filter(is_open);
        first.for_each(|image| image.clock = StatedClock::Right);
    }
}

fn told(view: &SettledView, account: &Account, lasting: &mut Lasting) -> Option<Testimony> {
    let account = account.rescaled(lasting.noise(view.camera_index));
    let expected = lasting.expected(&account.displacing);
    account.apart_from(&expected)
}
