//! Contradictions that errors of a usual size do not explain, and the mistakes that do.
//!
//! The views of an object at one instant are compared with the models in force now and then, often while an object is
//! new or its track rejects views. Where instants go on to contradict, the contradiction is *open*: nothing is learned
//! from such images, a camera that contradicts others that are right is suspended, and poses on which nobody agrees are
//! not published as tracked. `sextant_mistakes` looks for the mistake that explains the instants since it opened; a
//! mistake that is found is mended in the models, and reported as a fault until the files change.

pub(crate) mod evidence;
pub(crate) mod indexed_site;
pub(crate) mod standing;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use sextant_mistakes::{Explanation, Instant, Mistake, Screened, explain, screen};
use sextant_site_model::PoseSigma;

use crate::FusionOptions;
use crate::contradictions::evidence::Evidence;
use crate::contradictions::indexed_site::IndexedSite;
use crate::contradictions::standing::Standings;
use crate::site::{ModelledSite, ObjectImage};

/// Most instants kept.
const MOST_INSTANTS: usize = 48;
/// Time between two instants of an object that are compared, ns: while nothing contradicts, and while something may.
const CALM_NS: u64 = 250_000_000;
const ALERT_NS: u64 = 30_000_000;
/// Objects beyond which each is compared less often.
const MOST_OBJECTS: u64 = 16;
/// Instants of a new object that are compared one after the other.
const FIRST: usize = 8;
/// Newest instants that decide whether a contradiction is open, how many of them open it, and how many keep it open.
const NEWEST: usize = 6;
const OPENS: usize = 3;
const STAYS: usize = 2;
/// Instants since a contradiction opened from which on it is explained, and factor to the next time.
const LEAST_TO_EXPLAIN: usize = 8;
const MORE_TO_EXPLAIN: f64 = 1.5;
/// Instants after which nothing further is expected to explain it: it is learned as errors of the files again.
const MOST_TO_EXPLAIN: usize = 40;
/// Time for which an instant tells how an object is seen, ns.
const NEW_NS: u64 = 500_000_000;

/// An instant that was compared.
#[derive(Debug, Clone)]
struct Compared {
    time_ns: u64,
    instant: Instant,
    screened: Screened,
}

impl Compared {
    fn is_wrong(&self) -> bool {
        self.screened.is_any()
    }
}

/// When an object is compared.
#[derive(Debug, Clone, Copy, Default)]
struct Pace {
    last_ns: u64,
    n_compared: usize,
    is_alert: bool,
}

/// What contradicts the models of a site.
#[derive(Debug, Default)]
pub(crate) struct Contradictions {
    evidence: Evidence,
    site: Option<IndexedSite>,
    /// Oldest first.
    compared: VecDeque<Compared>,
    /// By object index.
    paces: BTreeMap<usize, Pace>,
    standings: Standings,
    /// Since when instants have contradicted, ns; `None` while they do not.
    since_ns: Option<u64>,
    /// Instants since then when it was explained last.
    n_explained: usize,
    /// The two mistakes that explain the instants equally, by camera.
    pair: Option<[usize; 2]>,
}

impl Contradictions {
    /// Takes an image of an object in; `is_doubted` tells whether its track rejects views.
    pub fn take(
        &mut self,
        object: usize,
        image: &Arc<ObjectImage>,
        is_doubted: bool,
        models: &ModelledSite,
        options: &FusionOptions,
    ) {
        self.evidence.take(object, image);
        let crowd = (self.paces.len() as u64 / MOST_OBJECTS).max(1);
        let pace = self.paces.entry(object).or_default();
        let is_dense = is_doubted || pace.is_alert || pace.n_compared < FIRST;
        let spacing_ns = if is_dense { ALERT_NS } else { CALM_NS * crowd };
        if image.capture_ns.abs_diff(pace.last_ns) < spacing_ns {
            return;
        }
        let site = self.site.get_or_insert_with(|| IndexedSite::new(models));
        let instants = self
            .evidence
            .instants(object, image.capture_ns, site, options);
        if instants.is_empty() {
            return;
        }
        pace.last_ns = image.capture_ns;
        pace.n_compared = pace.n_compared.saturating_add(1);
        pace.is_alert = false;
        for instant in instants {
            let screened = screen(&site.site, &instant);
            pace.is_alert |= screened.is_any();
            let cameras = cameras(&instant, &screened);
            self.standings.record(image.capture_ns, &cameras);
            self.compared.push_back(Compared {
                time_ns: image.capture_ns,
                instant,
                screened,
            });
        }
        self.decide();
    }

    /// Whether a contradiction is open, and since when.
    fn decide(&mut self) {
        while self.compared.len() > MOST_INSTANTS {
            self.compared.pop_front();
        }
        let newest = self.compared.iter().rev().take(NEWEST);
        let n_wrong = newest.filter(|one| one.is_wrong()).count();
        match self.since_ns {
            None if n_wrong >= OPENS => {
                let newest = self.compared.iter().rev().take(NEWEST);
                let wrong = newest.filter(|one| one.is_wrong());
                self.since_ns = wrong.last().map(|one| one.time_ns);
                self.n_explained = 0;
            }
            Some(_) if n_wrong < STAYS => {
                self.since_ns = None;
                self.pair = None;
            }
            _ => {}
        }
    }

    /// Whether nothing is to be learned from images now: what contradicts may be a mistake.
    pub fn forbids_learning(&self) -> bool {
        let is_exhausted = self.n_explained >= MOST_TO_EXPLAIN && self.standings.suspended().next().is_none();
        let newest = self.compared.iter().rev().take(OPENS);
        let is_wrong = newest.filter(|one| one.is_wrong()).count() > 0;
        (self.since_ns.is_some() || is_wrong) && !is_exhausted
    }

    /// Whether a camera contradicts others that are right: its views are to have no part in poses.
    pub fn is_suspended(&self, camera: usize) -> bool {
        self.standings.is_suspended(camera)
    }

    /// The mistakes that explain an open contradiction, once there are enough instants.
    pub fn explain(&mut self) -> Option<Explanation> {
        let since_ns = self.since_ns?;
        let site = self.site.as_ref()?;
        let since = self.compared.iter().filter(|one| one.time_ns >= since_ns);
        let instants: Vec<Instant> = since.map(|one| one.instant.clone()).collect();
        let least = (self.n_explained as f64 * MORE_TO_EXPLAIN) as usize;
        if instants.len() < LEAST_TO_EXPLAIN.max(least).min(MOST_TO_EXPLAIN)
            || self.n_explained >= MOST_TO_EXPLAIN
        {
            return None;
        }
        self.n_explained = instants.len();
        Some(explain(&site.site, &instants))
    }

    /// The mistakes to mend: of two cameras that explain the same, the one that is suspended.
    pub fn to_mend(&mut self, explanation: &Explanation) -> Vec<Mistake> {
        let mut mistakes = Vec::new();
        self.pair = None;
        for found in &explanation.found {
            let Some(other) = found.or else {
                mistakes.push(found.mistake);
                continue;
            };
            let both = [found.mistake, other];
            let is_suspended = |one: &&Mistake| {
                let mut cameras = one.cameras().into_iter();
                cameras.any(|camera| self.standings.is_suspended(camera))
            };
            let mut suspended = both.iter().filter(is_suspended);
            match (suspended.next(), suspended.next()) {
                (Some(one), None) => mistakes.push(*one),
                _ => {
                    let cameras = both.map(|one| one.cameras().first().copied());
                    if let [Some(a), Some(b)] = cameras {
                        self.pair = Some([a, b]);
                    }
                }
            }
        }
        mistakes
    }

    /// The two cameras one of which is not where the rig says.
    pub fn pair(&self) -> Option<[usize; 2]> {
        self.pair
    }

    /// By how much what is known of an object's pose may be wrong, where no majority of cameras or tags agrees on it.
    pub fn doubt(&self, object: usize, time_ns: u64) -> Option<PoseSigma> {
        let site = self.site.as_ref()?;
        let own = |one: &&Compared| site.object(one.instant.body) == object;
        let newest = self.compared.iter().rev().find(own)?;
        let is_new = newest.time_ns.abs_diff(time_ns) <= NEW_NS;
        (is_new && self.is_undecided(newest)).then_some(newest.screened.apart)
    }

    fn is_undecided(&self, one: &Compared) -> bool {
        let cameras = cameras(&one.instant, &one.screened);
        let active = || {
            let active = cameras.iter();
            active.filter(|(camera, _)| !self.standings.is_suspended(*camera))
        };
        let n_wrong = active().filter(|(_, is_wrong)| *is_wrong).count();
        let n_right = active().count() - n_wrong;
        if cameras.len() > 1 {
            return n_wrong > 0 && n_right < 2.max(n_wrong + 1);
        }
        let views = &one.screened.is_contradicting;
        let n_wrong = views.iter().filter(|is_wrong| **is_wrong).count();
        2 * n_wrong >= views.len()
    }

    /// The models have changed: what was compared with others means nothing now.
    pub fn models_changed(&mut self) {
        *self = Self {
            evidence: std::mem::take(&mut self.evidence),
            ..Self::default()
        };
    }

    /// Errors of the models have been corrected by little.
    pub fn models_corrected(&mut self) {
        self.site = None;
    }

    /// Times before and after mean something else.
    pub fn forget_times(&mut self) {
        self.evidence.clear();
        self.models_changed();
    }

    /// The tag of an index.
    pub fn indexed(&self) -> Option<&IndexedSite> {
        self.site.as_ref()
    }
}

/// The cameras of an instant, each with whether most of its views contradict.
fn cameras(instant: &Instant, screened: &Screened) -> Vec<(usize, bool)> {
    let mut cameras: Vec<usize> = instant.views.iter().map(|view| view.camera).collect();
    cameras.sort_unstable();
    cameras.dedup();
    let contradicts = |camera: usize| Some((camera, screened.of_camera(instant, camera)?));
    cameras.into_iter().filter_map(contradicts).collect()
}
