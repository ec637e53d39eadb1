//! Who is wrong is asked while something may be ([`crate::diagnosis::exclusion_test`]): evidence by the track that is published can't tell who spoils it.
//! Without a verdict it names but sizes of tags, and in the long run what is loud.

use crate::FusionOptions;
use crate::diagnosis::exclusion_test::{Contest, MOST_OF_CAMERAS};
use crate::diagnosis::fading_counter::Count;
use crate::diagnosis::fault_bank::{Admitted, SUSPECTED};
use crate::diagnosis::replay_buffer::{Instant, Recall};
use crate::diagnosis::{Health, OFTEN};
use crate::site::Site;
use crate::tracker::timeline::Settled;
use crate::tracker::track::Track;

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
        for (object, track) in tracks.iter().enumerate() {
            let then = self.recalls.get(&object).and_then(Recall::restlessness);
            self.restless
                .note(object, now_ns, track.restlessness(), then);
        }
        let is_unknown = self.is_something_unknown(now_ns);
        let is_held = self.contest.is_some() && is_unknown;
        let is_allowed = self.weariness.allows(now_ns, is_held);
        let suspected = is_unknown.then(|| self.suspects.most_suspected());
        if let Some(object) = suspected {
            self.contest.take_if(|held| !held.keeps_to(object));
        }
        let object = suspected.or_else(|| self.restless_among_few(now_ns));
        match object.filter(|_| is_allowed) {
            None => self.contest = None,
            Some(_) if self.recalls.values().any(Recall::is_full) => self.forget_past(),
            Some(object) => {
                if now_ns >= self.rests_until_ns {
                    self.hold_contest((object, is_unknown), now_ns, site, options);
                }
                return;
            }
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

    /// An object that has become restless, seen by so few cameras that any of them can contend: one among many makes no object so.
    fn restless_among_few(&self, now_ns: u64) -> Option<usize> {
        let are_few = |object: &usize| {
            let recall = self.recalls.get(object);
            recall.is_some_and(|recall| 2 * recall.cameras().len() <= MOST_OF_CAMERAS)
        };
        self.restless.objects(now_ns).find(are_few)
    }

    /// About an object, that is suspected or but restless, unless one is held.
    fn hold_contest(
        &mut self,
        (object, is_suspected): (usize, bool),
        now_ns: u64,
        site: &Site,
        options: &FusionOptions,
    ) {
        let held = self.contest.as_ref();
        let object = held.map_or(object, |contest| contest.object);
        let Some(recall) = self.recalls.get(&object) else {
            return;
        };
        let begin = || Contest::new(object, now_ns, recall);
        let mut contest = self.contest.take().unwrap_or_else(begin);
        contest.note(is_suspected, self.restless.is(object, now_ns));
        let mut cameras: Vec<usize> = recall.cameras().into_iter().collect();
        let agreed = |camera: &usize| {
            self.cameras
                .get(camera)
                .map_or(1.0, |own| 1.0 - own.share())
        };
        cameras.sort_by(|a, b| agreed(a).total_cmp(&agreed(b)));
        let (known, tags) = (
            self.suspects.known(object),
            self.suspects.suspected_tags(object),
        );
        contest.call(known, &cameras, &tags, recall, site.reference());
        contest.advance(now_ns, recall, site, options);
        self.suspects.admit(contest.admitted());
        match contest.verdict() {
            Some(one) => {
                self.rests_until_ns = now_ns.saturating_add(PAUSE_NS);
                self.suspects.convict(object, contest.into_contender(one));
            }
            None => self.contest = Some(contest),
        }
    }
}
