//! Who is wrong where views contradict one another: the one without whom all others agree.
//!
//! After a fault a track follows what is wrong in part, and innocent ones contradict it as loudly. So from before the suspicion on the
//! object is tracked anew without the images of each camera, without the views of each tag, and with each camera's clock estimated,
//! that may be to blame, and what remains is scored: by how far each image is from what is expected of it ([`crate::diagnosis::predictive_cost`]), and, for
//! a motion that is restless enough explains anything, by how vague that is. What is left out is held against that track, which it
//! can't spoil, and must be explained by a fault of its own.
//!
//! Bounded: each image takes each of the tracks a few instants further, those of one object and of few contenders.

pub(crate) mod subset_filter;

use crate::diagnosis::exclusion_test::subset_filter::Cost;
pub(crate) use crate::diagnosis::exclusion_test::subset_filter::{Excluded, SubsetFilter};
use crate::diagnosis::fault_bank::{CLOCK_SHARE, NamingPolicy, RAISED, SUSPECTED};
use crate::diagnosis::replay_buffer::ReplayBuffer;
use crate::site::Site;
use crate::{FusionOptions, TagId};

/// Contenders at most: cameras and their clocks, tags.
pub(crate) const MOST_OF_CAMERAS: usize = 16;
const MOST_OF_TAGS: usize = 8;
/// Instants that a track is taken on at most with each that comes.
const STEPS: usize = 6;
/// Share of the cost that must be gone without the one that is named, and the most that may be left of what is left without another.
const GONE: f64 = 0.7;
const LESS: f64 = 0.5;
/// Share of the cost by which another may explain more than one that other evidence speaks against, and as a logarithm of odds.
const HARDLY_MORE: f64 = 0.2;
const ABOUT_AS_MUCH: f64 = 10.0;
/// Nanoseconds of a contest before which it says nothing of tags.
const YOUNG_NS: u64 = 200_000_000;
/// The same after which it is enough to explain half, and more than others do.
const LONG_NS: u64 = 1_000_000_000;
/// Images of a camera from which on it is told whether its clock is off, and up to which more are waited for; what each may cost more than
/// if it were left out.
const FEWEST: usize = 5;
const ENOUGH: usize = 15;
const MORE: f64 = 1.0;

/// The contest about one object.
#[derive(Debug)]
pub(crate) struct ExclusionTest {
    pub object: usize,
    since_ns: u64,
    /// How long it has been held, ns.
    age_ns: u64,
    /// What is known to be wrong, and left out of all tracks.
    known: Vec<Excluded>,
    /// Cameras that it is among.
    cameras: usize,
    /// The track of all that remain, and those without one of them.
    all: SubsetFilter,
    subset_filters: Vec<SubsetFilter>,
    /// Instants that there are, and that there were when it began.
    instants: usize,
    before: usize,
    /// Whether the object has become restless, and whether errors are stated.
    manoeuvring: bool,
    stated: bool,
    /// Whether something speaks against what is seen of the object.
    suspected: bool,
}

impl ExclusionTest {
    pub fn new(object: usize, now_ns: u64, replay_buffer: &ReplayBuffer) -> Self {
        Self {
            object,
            since_ns: now_ns,
            age_ns: 0,
            known: Vec::new(),
            cameras: 0,
            all: SubsetFilter::new(None, replay_buffer.start(), 0),
            subset_filters: Vec::new(),
            instants: replay_buffer.len(),
            before: replay_buffer.len(),
            manoeuvring: false,
            stated: false,
            suspected: false,
        }
    }

    /// Something speaks against what is seen of the object, or it has become far more restless than it was.
    pub fn note(&mut self, suspected: bool, manoeuvring: bool) {
        self.suspected |= suspected;
        self.manoeuvring |= manoeuvring;
    }

    /// Whether it goes on where something speaks against what is seen of that object.
    pub fn keeps_to(&self, object: usize) -> bool {
        self.object == object || self.suspected
    }

    /// Who may be wrong: those who are new join in. `known` is wrong for certain.
    pub fn call(
        &mut self,
        known: Vec<Excluded>,
        cameras: &[usize],
        tags: &[TagId],
        replay_buffer: &ReplayBuffer,
        reference: usize,
    ) {
        if known != self.known {
            self.known = known;
            self.all = SubsetFilter::new(None, replay_buffer.start(), 0);
            self.subset_filters.clear();
        }
        let is_open = |camera: &usize| !self.known.contains(&Excluded::Camera(*camera));
        let cameras: Vec<usize> = cameras.iter().copied().filter(is_open).collect();
        self.cameras = cameras.len();
        // One camera alone contradicts nobody.
        let several = cameras.len() > 1;
        let cameras = cameras.into_iter().filter(|_| several);
        // Where nobody vouches for another the reference is right by definition.
        let is_told = replay_buffer.has_right_clock_beside(reference);
        let of_camera = |camera: usize| {
            let clock = Some(Excluded::Clock(camera)).filter(|_| camera != reference || is_told);
            std::iter::once(Excluded::Camera(camera)).chain(clock)
        };
        self.join(cameras.flat_map(of_camera), MOST_OF_CAMERAS, replay_buffer);
        self.join(
            tags.iter().copied().map(Excluded::Tag),
            MOST_OF_TAGS,
            replay_buffer,
        );
    }

    /// Those of a kind who are new join in, up to so many.
    fn join(
        &mut self,
        ones: impl Iterator<Item = Excluded>,
        most: usize,
        replay_buffer: &ReplayBuffer,
    ) {
        for one in ones {
            let is_alike = |other: &Excluded| other.camera().is_some() == one.camera().is_some();
            let joined = self
                .subset_filters
                .iter()
                .filter_map(|other| other.left_out);
            let mut alike = joined.filter(is_alike);
            let has_room = alike.clone().count() < most;
            if has_room && alike.all(|other| other != one) && !self.known.contains(&one) {
                let start = replay_buffer.start();
                let subset_filter = SubsetFilter::new(Some(one), start, self.before);
                self.subset_filters.push(subset_filter);
            }
        }
    }

    /// Takes the tracks further on.
    pub fn advance(
        &mut self,
        now_ns: u64,
        replay_buffer: &ReplayBuffer,
        site: &Site,
        options: &FusionOptions,
    ) {
        self.age_ns = now_ns.saturating_sub(self.since_ns);
        self.stated = site.has_given_errors();
        let come = replay_buffer.len().saturating_sub(self.instants).max(1);
        self.instants = replay_buffer.len();
        let known = &self.known;
        for one in std::iter::once(&mut self.all).chain(&mut self.subset_filters) {
            for _ in 0..STEPS * come {
                let Some(instant) = replay_buffer.instant(one.done) else {
                    break;
                };
                one.take(instant, known, site, options);
            }
        }
    }

    /// The contenders that have caught up.
    fn level(&self) -> impl Iterator<Item = &SubsetFilter> {
        let subset_filters = self.subset_filters.iter();
        subset_filters.filter(|one| one.done == self.instants)
    }

    /// What a track costs more than any must. Of the misfit that is what noise alone explains, where nothing else is to be expected;
    /// vagueness counts where it has grown, and not what a track is vaguer than that of all for what is left out of it.
    fn cost(&self, one: &SubsetFilter) -> f64 {
        let least = |of: fn(&Cost) -> f64| {
            let level = self.level().map(|one| of(&one.cost));
            level.fold(of(&self.all.cost), f64::min)
        };
        let usual = if self.stated {
            0.0
        } else {
            self.all.cost.usual
        };
        let misfit = one.cost.misfit - usual.min(least(|of| of.misfit));
        if self.manoeuvring {
            misfit + one.cost.vague.min(self.all.cost.vague) - least(|of| of.vague)
        } else {
            misfit
        }
    }

    /// The contenders by how much is gone without them, the most first, but those who have not caught up, and clocks that are not off;
    /// `None` while the track of all has not caught up.
    fn ranked(&self) -> Option<Vec<(f64, &SubsetFilter)>> {
        if self.all.done != self.instants {
            return None;
        }
        let all = self.cost(&self.all);
        let possible = self
            .level()
            .filter(|one| one.images_tried().is_none() || one.is_faulty());
        let mut ranked: Vec<_> = possible.map(|one| (all - self.cost(one), one)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        Some(ranked)
    }

    /// The one that is wrong, if that is clear. Of two cameras nobody can tell which it is: either stands for both.
    pub fn verdict(&self) -> Option<Excluded> {
        let ranked = self.ranked()?;
        let (most, _) = ranked.first()?;
        let mut faulty = ranked.iter().filter(|(_, one)| one.is_faulty());
        let (gone, first) = faulty.next()?;
        // Of one camera, and of two, either stands for both.
        let is_rival = |one: &SubsetFilter| match (first.camera(), one.camera()) {
            (Some(own), Some(other)) => own != other && self.cameras != 2,
            _ => true,
        };
        let alternative = faulty.find(|(_, one)| is_rival(one));
        let (all, left) = (self.cost(&self.all), self.cost(first));
        let left_by_rival = alternative.map_or(all, |(_, one)| self.cost(one));
        let gone_by_rival = alternative.map_or(0.0, |(gone, _)| *gone);
        // One without a fault of its own may explain a little more, for it leaves out more: it is no rival of one that explains nearly all.
        let explains_most = *gone > GONE * all && left < LESS * left_by_rival;
        // What nobody explains may be errors that nobody states, or that are as stated.
        let is_first = *gone > most - ABOUT_AS_MUCH;
        let explains_more =
            self.is_long() && is_first && *gone > LESS * all && gone_by_rival < LESS * gone;
        let stands_out =
            *gone > RAISED && left < left_by_rival - RAISED && (explains_most || explains_more);
        let left_out = first.left_out.filter(|_| stands_out)?;
        match first.camera() {
            Some(camera) => self.place_or_clock(camera, left_out),
            None => Some(left_out),
        }
    }

    /// Whether a camera is not where it should be, or its clock is off; `None` where that can't be told yet. Either may explain what it
    /// shows for a while: then evidence decides.
    fn place_or_clock(&self, camera: usize, first: Excluded) -> Option<Excluded> {
        let of = |left_out| {
            let mut subset_filters = self.subset_filters.iter();
            subset_filters.find(|one| one.left_out == Some(left_out))
        };
        let (Some(moved), Some(clock)) =
            (of(Excluded::Camera(camera)), of(Excluded::Clock(camera)))
        else {
            return Some(first);
        };
        let images = clock.images_tried()?;
        let may_wait = |for_images: usize| images < for_images && !self.is_long();
        if may_wait(FEWEST) {
            return None;
        }
        let more = self.cost(clock) - self.cost(moved);
        let as_much = moved.is_faulty() && more > -ABOUT_AS_MUCH;
        let is_moved = moved.left_out.filter(|own| as_much || *own == first);
        let [by_clock, by_move] = moved.estimate.explain();
        let [of_clock, of_move] = moved.evidences();
        let fits = clock.is_faulty() && more < ABOUT_AS_MUCH.max(MORE * images as f64);
        if !fits || of_clock.max(of_move) < SUSPECTED || (by_move && !by_clock) {
            return is_moved;
        }
        if !by_move || of_clock > CLOCK_SHARE * of_move {
            return clock.left_out;
        }
        is_moved.filter(|_| !may_wait(ENOUGH))
    }

    /// The contender for whom that is left out.
    pub fn into_contender(self, left_out: Excluded) -> Option<SubsetFilter> {
        let mut all = self.subset_filters.into_iter();
        all.find(|one| one.left_out == Some(left_out))
    }

    /// Whether it has been held for longer than a single fault takes.
    fn is_long(&self) -> bool {
        self.age_ns > LONG_NS
    }

    /// What must be gone without one who explains about as much as the most.
    fn about(&self, most: f64) -> f64 {
        most - ABOUT_AS_MUCH.max(HARDLY_MORE * self.cost(&self.all))
    }

    /// What evidence alone may name: sizes of tags than which no other explains much more, and, since it may be several, whatever is
    /// loud where errors are not stated and there has been no verdict for long.
    pub fn admitted(&self) -> NamingPolicy {
        NamingPolicy {
            sizes: self.likely_tags(),
            loud: self.is_long() && !self.stated,
        }
    }

    fn likely_tags(&self) -> Vec<(usize, TagId)> {
        let is_old = self.age_ns > YOUNG_NS;
        let ranked = self.ranked().filter(|_| is_old).unwrap_or_default();
        let most = ranked.first().map_or(0.0, |(gone, _)| *gone);
        let enough = self.about(most);
        let ranked = ranked.into_iter().filter(move |(gone, _)| *gone >= enough);
        let tag_of = |(_, one): (f64, &SubsetFilter)| match one.left_out {
            Some(Excluded::Tag(tag)) => Some((self.object, tag)),
            _ => None,
        };
        ranked.filter_map(tag_of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_a_body_that_is_but_restless_it_ends_where_another_is_suspected() {
        let mut exclusion_test = ExclusionTest::new(0, 0, &ReplayBuffer::default());
        exclusion_test.note(false, true);
        assert!(exclusion_test.keeps_to(0) && !exclusion_test.keeps_to(1));
        exclusion_test.note(true, true);
        assert!(exclusion_test.keeps_to(1));
    }

    #[test]
    fn those_who_contend_are_few_and_the_reference_is_right_where_nobody_vouches_for_another() {
        let replay_buffer = ReplayBuffer::default();
        let mut exclusion_test = ExclusionTest::new(0, 0, &replay_buffer);
        exclusion_test.call(Vec::new(), &[0], &[], &replay_buffer, 0);
        assert_eq!(
            exclusion_test.subset_filters.len(),
            0,
            "one camera contradicts nobody"
        );
        exclusion_test.call(Vec::new(), &[1, 0], &[], &replay_buffer, 0);
        let left_out = exclusion_test
            .subset_filters
            .iter()
            .filter_map(|one| one.left_out);
        let all: Vec<Excluded> = left_out.collect();
        let [moved, other] = [Excluded::Camera(1), Excluded::Camera(0)];
        assert_eq!(all, [moved, Excluded::Clock(1), other]);
        let many: Vec<usize> = (0..50).collect();
        exclusion_test.call(Vec::new(), &many, &[], &replay_buffer, 0);
        exclusion_test.call(Vec::new(), &many, &[], &replay_buffer, 0);
        assert_eq!(exclusion_test.subset_filters.len(), MOST_OF_CAMERAS);
    }
}
