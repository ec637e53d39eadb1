//! Who is wrong is asked while something may be ([`crate::diagnosis::exclusion_test`]): evidence by the track that is published can't tell who spoils it.
//! Without a verdict it names but sizes of tags, and in the long run what is loud.

use crate::FusionOptions;
use crate::diagnosis::exclusion_test::{ExclusionTest, MOST_OF_CAMERAS};
use crate::diagnosis::fading_counter::FadingCounter;
use crate::diagnosis::fault_bank::{NamingPolicy, SUSPECTED};
use crate::diagnosis::replay_buffer::{Instant, ReplayBuffer};
use crate::diagnosis::{Diagnosis, OFTEN};
use crate::site::Site;
use crate::tracker::timeline::FinalisedInstant;
use crate::tracker::track::Track;

/// Nanoseconds between a contest that has found one and the next.
const PAUSE_NS: u64 = 500_000_000;

impl Diagnosis {
    /// Remembers an object's images at a settled instant.
    pub fn remember(&mut self, object: usize, instant: FinalisedInstant) {
        let replay_buffer = self.replay_buffers.entry(object).or_default();
        replay_buffer.add(Instant {
            time_ns: instant.time_ns,
            images: instant.images,
        });
    }

    /// What is remembered is worth nothing any more.
    pub fn forget_past(&mut self) {
        self.exclusion_test = None;
        self.replay_buffers.clear();
    }

    /// Looks whether something may be wrong that is not known, and who it is. The tracks are the objects', by index, at their last
    /// settled instants.
    pub fn isolate(
        &mut self,
        now_ns: u64,
        tracks: &[&Track],
        site: &Site,
        options: &FusionOptions,
    ) {
        for (object, track) in tracks.iter().enumerate() {
            let then = self
                .replay_buffers
                .get(&object)
                .and_then(ReplayBuffer::process_noise_psd);
            self.manoeuvring
                .note(object, now_ns, track.process_noise_psd(), then);
        }
        let is_unknown = self.is_something_unknown(now_ns);
        let is_held = self.exclusion_test.is_some() && is_unknown;
        let is_allowed = self.duty_cycle.allows(now_ns, is_held);
        let suspected = is_unknown.then(|| self.fault_bank.most_suspected());
        if let Some(object) = suspected {
            self.exclusion_test.take_if(|held| !held.keeps_to(object));
        }
        let object = suspected.or_else(|| self.restless_among_few(now_ns));
        match object.filter(|_| is_allowed) {
            None => self.exclusion_test = None,
            Some(_) if self.replay_buffers.values().any(ReplayBuffer::is_full) => {
                self.forget_past()
            }
            Some(object) => {
                if now_ns >= self.rests_until_ns {
                    self.run_exclusion_test((object, is_unknown), now_ns, site, options);
                }
                return;
            }
        }
        self.fault_bank.admit(NamingPolicy::default());
        for (object, track) in tracks.iter().enumerate() {
            self.replay_buffers
                .entry(object)
                .or_default()
                .checkpoint(track);
        }
    }

    fn is_something_unknown(&self, now_ns: u64) -> bool {
        if self.is_alert() && self.fault_bank.most_unknown() > SUSPECTED {
            return true;
        }
        if self.fault_bank.found().next().is_some() {
            return false;
        }
        let often = |count: &FadingCounter| count.faded(now_ns).refused > OFTEN;
        let is_hit = self.hits.values().any(often);
        is_hit || self.contradicted_cameras().next().is_some()
    }

    /// An object that has become restless, seen by so few cameras that any of them can contend: one among many makes no object so.
    fn restless_among_few(&self, now_ns: u64) -> Option<usize> {
        let are_few = |object: &usize| {
            let replay_buffer = self.replay_buffers.get(object);
            replay_buffer
                .is_some_and(|replay_buffer| 2 * replay_buffer.cameras().len() <= MOST_OF_CAMERAS)
        };
        self.manoeuvring.objects(now_ns).find(are_few)
    }

    /// About an object, that is suspected or but restless, unless one is held.
    fn run_exclusion_test(
        &mut self,
        (object, is_suspected): (usize, bool),
        now_ns: u64,
        site: &Site,
        options: &FusionOptions,
    ) {
        let held = self.exclusion_test.as_ref();
        let object = held.map_or(object, |exclusion_test| exclusion_test.object);
        let Some(replay_buffer) = self.replay_buffers.get(&object) else {
            return;
        };
        let begin = || ExclusionTest::new(object, now_ns, replay_buffer);
        let mut exclusion_test = self.exclusion_test.take().unwrap_or_else(begin);
        exclusion_test.note(is_suspected, self.manoeuvring.is(object, now_ns));
        let mut cameras: Vec<usize> = replay_buffer.cameras().into_iter().collect();
        let agreed = |camera: &usize| {
            self.cameras
                .get(camera)
                .map_or(1.0, |own| 1.0 - own.share())
        };
        cameras.sort_by(|a, b| agreed(a).total_cmp(&agreed(b)));
        let (known, tags) = (
            self.fault_bank.known(object),
            self.fault_bank.suspected_tags(object),
        );
        exclusion_test.call(known, &cameras, &tags, replay_buffer, site.reference());
        exclusion_test.advance(now_ns, replay_buffer, site, options);
        self.fault_bank.admit(exclusion_test.admitted());
        match exclusion_test.verdict() {
            Some(one) => {
                self.rests_until_ns = now_ns.saturating_add(PAUSE_NS);
                self.fault_bank
                    .confirm(object, exclusion_test.into_contender(one));
            }
            None => self.exclusion_test = Some(exclusion_test),
        }
    }
}
