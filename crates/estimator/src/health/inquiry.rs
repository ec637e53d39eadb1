//! Who is wrong is asked while something may be ([`super::contest`]): evidence by the track that is published can't tell who spoils it.
//! Without a verdict it names but sizes of tags, and what is loud.

use super::contest::Contest;
use super::count::Count;
use super::recall::{Instant, Recall};
use super::suspects::{Admitted, SUSPECTED};
use super::{Health, OFTEN};
use crate::FusionOptions;
use crate::site::Site;
use crate::timeline::Settled;
use crate::track::Track;

/// Nanoseconds between a contest that has found one and the next.
const PAUSE_NS: u64 = 500_000_000;

impl Health {
    /// Remembers an object's images at a settled instant.
    pub fn remember(&mut self, object: usize, instant: Settled) {
        let recall = self.recalls.entry(object).or_default();
        recall.add(Instant {
            time_ns: instant.time_ns,
            images: instant.images,
        });
    }

    /// The settled track of an object, had these cameras been blind since before anything seemed to be wrong.
    pub fn without(
        &self,
        object: usize,
        cameras: &[usize],
        site: &Site,
        options: &FusionOptions,
    ) -> Option<Track> {
        self.recalls.get(&object)?.without(cameras, site, options)
    }

    /// What is remembered is worth nothing any more.
    pub fn forget_past(&mut self) {
        self.contest = None;
        self.recalls.clear();
    }

    /// Looks whether something may be wrong that is not known, and who it is. The tracks are the objects', by index, at their last
    /// settled instants.
    pub fn look_for_the_wrong(
        &mut self,
        now_ns: u64,
        tracks: &[&Track],
        site: &Site,
        options: &FusionOptions,
    ) {
        let is_held = self.contest.is_some();
        if !self.weariness.allows(now_ns, is_held) || !self.is_something_unknown(now_ns) {
            self.contest = None;
        } else if self.recalls.values().any(Recall::is_full) {
            self.forget_past();
        } else {
            if now_ns >= self.rests_until_ns {
                self.hold_contest(now_ns, site, options);
            }
            return;
        }
        self.suspects.admit(Admitted::default());
        for (object, track) in tracks.iter().enumerate() {
            self.recalls.entry(object).or_default().mark(track);
        }
    }

    fn is_something_unknown(&self, now_ns: u64) -> bool {
        if self.is_alert() && self.suspects.most_unknown() > SUSPECTED {
            return true;
        }
        if self.suspects.found().next().is_some() {
            return false;
        }
        let often = |count: &Count| count.faded(now_ns).refused > OFTEN;
        let is_hit = self.hits.values().any(often);
        is_hit || self.contradicted_cameras().next().is_some()
    }

    fn hold_contest(&mut self, now_ns: u64, site: &Site, options: &FusionOptions) {
        let object = match &self.contest {
            Some(contest) => contest.object,
            None => self.suspects.most_suspected(),
        };
        let Some(recall) = self.recalls.get(&object) else {
            return;
        };
        let begin = || Contest::new(object, now_ns, &self.lasting, recall);
        let mut contest = self.contest.take().unwrap_or_else(begin);
        let cameras: Vec<usize> = self.cameras.keys().copied().collect();
        let tags = self.suspects.suspected_tags(object);
        contest.call(self.suspects.known(object), &cameras, &tags, recall);
        contest.advance(now_ns, recall, site, options);
        self.suspects.admit(contest.admitted(site));
        match contest.verdict() {
            Some(one) => {
                self.rests_until_ns = now_ns.saturating_add(PAUSE_NS);
                self.suspects.convict(object, contest.into_contender(one));
            }
            None => self.contest = Some(contest),
        }
    }
}
