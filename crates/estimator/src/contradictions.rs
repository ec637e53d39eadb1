//! Contradictions that errors of a usual size do not explain, and the mistakes that do.
//!
//! The views of an object at one instant are compared with the models in force now and then, often while an object is
//! new or its track rejects views. Where instants go on to contradict, the contradiction is *open*: nothing is learned
//! from such images, a camera that contradicts others that are right is suspended, and poses without a
//! majority of cameras or tags are not published as tracked. `sextant_mistakes` looks for the mistake that explains the
//! instants since it opened; a mistake that is found is mended in the models, and reported as a fault until the files
//! change.

pub(crate) mod evidence;
pub(crate) mod search;
pub(crate) mod standing;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use sextant_geometry::se3;
use sextant_mistakes::{Instant, Mistake, NominalSite, Screened, screen, squares_px};
use sextant_site_model::PoseSigma;

use crate::FusionOptions;
use crate::contradictions::evidence::Evidence;
use crate::contradictions::search::{History, MistakeSearch, Scope};
use crate::contradictions::standing::Standings;
use crate::self_calibration::held_back::{HeldBack, SquaresPair};
use crate::site::indexed_site::{Exactness, IndexedSite};
use crate::site::{ModelledSite, ObjectImage};

/// Most instants kept.
const MOST_INSTANTS: usize = 48;
/// Time between two instants of an object that are compared, ns: while nothing contradicts, and while something may.
const CALM_NS: u64 = 250_000_000;
const ALERT_NS: u64 = 30_000_000;
/// Objects beyond which each is compared less often.
const MOST_OBJECTS: u64 = 16;
/// Instants of a new object that are compared one after the other.
const FIRST: usize = 12;
/// Newest instants that decide whether a contradiction is open, how many of them open it, and how many keep it open.
const NEWEST: usize = 6;
const OPENS: usize = 3;
const STAYS: usize = 2;
/// Instants since a contradiction opened from which on it is explained, and factor to the next time.
const LEAST_TO_EXPLAIN: usize = 8;
const MORE_TO_EXPLAIN: f64 = 1.5;
/// Instants after which nothing further is expected to explain it.
const MOST_TO_EXPLAIN: usize = 40;
/// Instants in which a tag agreed after which it has been right once.
const CONFIRMED: usize = 5;
/// Numbers of instants at which the files are compared, how exact they are taken to be then, and what is looked for.
const CHECKS: [(usize, Exactness, Scope); 5] = [
    (4, Exactness::ExactFiles, Scope::Names),
    (12, Exactness::ExactFiles, Scope::Files),
    (12, Exactness::UsualFiles, Scope::Prints),
    (MOST_INSTANTS, Exactness::ExactFiles, Scope::Files),
    (MOST_INSTANTS, Exactness::UsualFiles, Scope::Prints),
];
/// Factor on the usual cost of a view, and least cost, from which on it is unusual; weight of an instant in the usual
/// one.
const UNUSUAL: f64 = 2.5;
const LEAST_UNUSUAL: f64 = 0.4;
const REMEMBERED: f64 = 0.05;
/// Cameras of a site up to which small moves are looked for here: among more, diagnosis tells which one it is.
const FEW_CAMERAS: usize = 3;
/// Share of the views of an instant from which on not single views contradict.
const MOSTLY: f64 = 0.3;
/// Time for which an instant tells how an object is seen, ns.
const NEW_NS: u64 = 500_000_000;

/// An instant that was compared.
#[derive(Debug, Clone)]
struct ComparedInstant {
    time_ns: u64,
    instant: Instant,
    screened: Screened,
    /// How the models before mistakes were mended explain it, and how those since then do.
    squares: Option<SquaresPair>,
}

impl ComparedInstant {
    fn is_wrong(&self) -> bool {
        self.screened.is_any()
    }

    /// Whether so many views contradict that a camera or an object is wrong.
    fn is_mostly_wrong(&self) -> bool {
        let views = &self.screened.is_contradicting;
        let n_wrong = views.iter().filter(|is_wrong| **is_wrong).count();
        n_wrong as f64 >= MOSTLY * views.len() as f64
    }
}

/// Two cameras one of which is not where the rig says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub cameras: [usize; 2],
    /// How far either would have been moved.
    apart: PoseSigma,
}

/// What the track of an object has rejected lately.
#[derive(Debug, Clone, Default)]
pub(crate) struct TrackDoubts {
    /// Whether it has rejected any view.
    pub is_any: bool,
    /// The cameras of whose last image no view took part, if the track has been beyond doubt.
    pub cameras: Vec<usize>,
    /// By how much the clock of the image's camera is ahead as the track estimates it, s.
    pub ahead_s: f64,
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
    /// The site before mistakes were mended.
    unmended: Option<NominalSite>,
    /// Oldest first.
    compared: VecDeque<ComparedInstant>,
    /// By object index.
    paces: BTreeMap<usize, Pace>,
    standings: Standings,
    /// Instants in which all views of a tag agreed with others, by its index.
    agreed_tags: BTreeMap<usize, usize>,
    /// Since when instants have contradicted, ns; `None` while they do not.
    since_ns: Option<u64>,
    /// Instants since then when it was explained last.
    n_explained: usize,
    /// What a view of an instant that does not contradict costs on average.
    usual_cost: f64,
    /// Instants since what they cost has become unusual.
    n_unusual: usize,
    /// The search that is due.
    due: Option<Arc<MistakeSearch>>,
    /// Whether an instant has been compared since mistakes were last looked for.
    is_new: bool,
    /// How often the files have been compared as if they were exact.
    n_checked: usize,
    /// The two cameras one of which has been moved.
    pair: Option<Pair>,
}

impl Contradictions {
    /// Takes an image of an object in; `doubts` is what its track has rejected lately.
    pub fn take(
        &mut self,
        object: usize,
        image: &Arc<ObjectImage>,
        doubts: &TrackDoubts,
        models: &ModelledSite,
        options: &FusionOptions,
    ) {
        self.evidence.take(object, image, doubts.ahead_s);
        let time_ns = image.capture_ns;
        if !self.is_due(object, time_ns, doubts) {
            return;
        }
        let site = self.site.get_or_insert_with(|| IndexedSite::new(models));
        let instants = self.evidence.instants(object, image, site, options);
        let unmended = self.unmended.as_ref();
        let compared = instants.into_iter().map(|instant| ComparedInstant {
            time_ns,
            screened: screen(&site.site, &instant),
            squares: unmended.and_then(|unmended| {
                let [before, now] = [unmended, &site.site].map(|site| squares_px(site, &instant));
                SquaresPair::from_squares(&before, &now)
            }),
            instant,
        });
        let compared: Vec<ComparedInstant> = compared.collect();
        if compared.is_empty() {
            return;
        }
        let unusual_cost = self.unusual_cost();
        let is_alert =
            |one: &ComparedInstant| one.is_wrong() || one.screened.mean_cost > unusual_cost;
        let pace = self.paces.entry(object).or_default();
        pace.last_ns = time_ns;
        pace.n_compared = pace.n_compared.saturating_add(1);
        pace.is_alert = compared.iter().any(is_alert);
        for one in compared {
            self.record(one, doubts);
        }
        self.is_new = true;
        self.decide();
    }

    /// Whether an object is to be compared again.
    fn is_due(&mut self, object: usize, time_ns: u64, doubts: &TrackDoubts) -> bool {
        let crowd = (self.paces.len() as u64 / MOST_OBJECTS).max(1);
        let pace = self.paces.entry(object).or_default();
        let is_dense = doubts.is_any || pace.is_alert || pace.n_compared < FIRST;
        let spacing_ns = if is_dense { ALERT_NS } else { CALM_NS * crowd };
        time_ns.abs_diff(pace.last_ns) >= spacing_ns
    }

    fn record(&mut self, one: ComparedInstant, doubts: &TrackDoubts) {
        let mean_cost = one.screened.mean_cost;
        if mean_cost < self.unusual_cost() {
            self.usual_cost += REMEMBERED * (mean_cost - self.usual_cost);
        }
        let cameras = cameras(&one.instant, &one.screened);
        let blamed = self.blamed(cameras, doubts, one.time_ns);
        self.standings.record(one.time_ns, &blamed);
        if !one.is_wrong() {
            for view in &one.instant.views {
                *self.agreed_tags.entry(view.tag).or_default() += 1;
            }
        }
        self.compared.push_back(one);
    }

    /// Of cameras that contradict each other the one is wrong whose images alone have jumped, however the views divide.
    /// Of two without a jump it is the one that has been wrong before, or that the track rejects; without such a sign
    /// neither is.
    fn blamed(
        &self,
        cameras: Vec<(usize, bool)>,
        doubts: &TrackDoubts,
        time_ns: u64,
    ) -> Vec<(usize, bool)> {
        if cameras.len() < 2 || !cameras.iter().any(|(_, is_wrong)| *is_wrong) {
            return cameras;
        }
        let with_sign = |has_sign: &dyn Fn(usize) -> bool| -> Option<Vec<(usize, bool)>> {
            let signs = cameras
                .iter()
                .map(|(camera, _)| (*camera, has_sign(*camera)));
            let signs: Vec<(usize, bool)> = signs.collect();
            let n_signs = signs.iter().filter(|(_, has_sign)| *has_sign).count();
            (n_signs == 1).then_some(signs)
        };
        let jumped = || with_sign(&|camera| self.evidence.has_jumped(camera, time_ns));
        if cameras.len() > 2 {
            return jumped().unwrap_or(cameras);
        }
        with_sign(&|camera| self.standings.is_suspended(camera))
            .or_else(jumped)
            .or_else(|| with_sign(&|camera| doubts.cameras.contains(&camera)))
            .unwrap_or_default()
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
                self.since_ns = wrong.min_by_key(|one| one.time_ns).map(|one| one.time_ns);
                self.n_explained = 0;
            }
            Some(_) if n_wrong < STAYS => {
                self.since_ns = None;
                self.pair = None;
            }
            _ => {}
        }
    }

    /// Whether nothing is to be learned from images now: what contradicts may be a mistake. Single views that
    /// contradict are none.
    pub fn forbids_learning(&self) -> bool {
        let newest = self.compared.iter().rev().take(OPENS);
        let n_newest = newest.len();
        let n_wrong = newest.filter(|one| one.is_mostly_wrong()).count();
        2 * n_wrong > n_newest
    }

    /// Whether a camera contradicts others that are right: its views are to have no part in poses.
    pub fn is_suspended(&self, camera: usize) -> bool {
        self.standings.is_suspended(camera)
    }

    /// Prepares a search for mistakes if an instant is new that calls for one; there is one at a time.
    pub fn prepare(&mut self, models: &ModelledSite) {
        if !std::mem::take(&mut self.is_new) || self.due.is_some() {
            return;
        }
        let search = match self.since_ns {
            Some(since_ns) => self.search_open(since_ns),
            None => self.search_files(models).or_else(|| self.search_small()),
        };
        self.due = search.map(Arc::new);
    }

    /// The search that is due.
    pub fn due(&self) -> Option<&Arc<MistakeSearch>> {
        self.due.as_ref()
    }

    /// The mistakes to mend by the search that is due, and the site that they are of.
    pub fn take_found(&mut self) -> Option<(Vec<Mistake>, Arc<MistakeSearch>)> {
        let search = self.due.take()?;
        Some((self.mistakes_of(&search), search))
    }

    /// What explains an open contradiction, once there are enough instants.
    fn search_open(&mut self, since_ns: u64) -> Option<MistakeSearch> {
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
        let scope = Scope::Open(self.history(site));
        Some(MistakeSearch::new(site.clone(), instants, scope))
    }

    fn history(&self, site: &IndexedSite) -> History {
        let cameras = 0..site.site.cameras.len();
        let agreed = self.agreed_tags.iter();
        let confirmed = agreed.filter(|(_, n_agreed)| **n_agreed >= CONFIRMED);
        History {
            cameras: cameras
                .filter(|camera| self.standings.is_confirmed(*camera))
                .collect(),
            tags: confirmed.map(|(tag, _)| *tag).collect(),
            suspended: self.standings.suspended().collect(),
        }
    }

    /// What would pass for large errors of files that are nearly exact: two names exchanged where two cameras stand
    /// alike, a print at another scale.
    fn search_files(&mut self, models: &ModelledSite) -> Option<MistakeSearch> {
        let (n_instants, exactness, scope) = CHECKS.get(self.n_checked)?;
        if self.compared.len() < *n_instants {
            return None;
        }
        self.n_checked += 1;
        let instants: Vec<Instant> = self
            .compared
            .iter()
            .map(|one| one.instant.clone())
            .collect();
        let files = IndexedSite::with(models, *exactness);
        Some(MistakeSearch::new(files, instants, scope.clone()))
    }

    /// A camera that has been moved by so little that no single instant contradicts.
    fn search_small(&mut self) -> Option<MistakeSearch> {
        let newest = self.compared.iter().rev().take(LEAST_TO_EXPLAIN);
        let costs: Vec<f64> = newest.clone().map(|one| one.screened.mean_cost).collect();
        let mean = costs.iter().sum::<f64>() / costs.len().max(1) as f64;
        if costs.len() < LEAST_TO_EXPLAIN || mean < self.unusual_cost() {
            self.n_unusual = 0;
            self.pair = None;
            return None;
        }
        self.n_unusual += 1;
        if self.n_unusual % LEAST_TO_EXPLAIN != 1 {
            return None;
        }
        let instants: Vec<Instant> = newest.map(|one| one.instant.clone()).collect();
        let site = self.site.as_ref()?;
        let n_cameras = site.site.cameras.iter().flatten().count();
        (n_cameras <= FEW_CAMERAS).then(|| MistakeSearch::new(site.clone(), instants, Scope::Small))
    }

    /// What a view costs on average from which on more than errors of single views is the cause.
    fn unusual_cost(&self) -> f64 {
        (UNUSUAL * self.usual_cost).max(LEAST_UNUSUAL)
    }

    /// The mistakes to mend: of two cameras that explain the same, the one that is suspended.
    fn mistakes_of(&mut self, search: &MistakeSearch) -> Vec<Mistake> {
        let explanation = search.solution();
        let mut mistakes = Vec::new();
        self.pair = None;
        for found in &explanation.found {
            let Some(other) = found.or else {
                mistakes.push(found.mistake);
                continue;
            };
            let both = [found.mistake, other];
            match self.culprit(both.map(|one| one.cameras())) {
                Some(index) => mistakes.push(both[index]),
                None => self.pair = pair(both, &search.indexed().site),
            }
        }
        mistakes.retain(is_mended);
        // An object that contradicts its file for the most part is another one than that of the file.
        if explanation.is_open() {
            mistakes.retain(|one| !one.cameras().is_empty());
        }
        mistakes
    }

    /// The one of two mistakes whose cameras contradict others that are right, or see things jump.
    fn culprit(&self, cameras: [Vec<usize>; 2]) -> Option<usize> {
        let newest_ns = self.compared.back()?.time_ns;
        let any = |is_blamed: &dyn Fn(usize) -> bool| {
            let is_any = |own: &Vec<usize>| own.iter().any(|camera| is_blamed(*camera));
            [is_any(&cameras[0]), is_any(&cameras[1])]
        };
        let signs = [
            any(&|camera| self.standings.is_suspended(camera)),
            any(&|camera| self.evidence.has_jumped(camera, newest_ns)),
        ];
        let [first, second] = signs.into_iter().find(|[a, b]| a != b)?;
        Some(usize::from(second && !first))
    }

    /// The two cameras one of which is not where the rig says.
    pub fn pair(&self) -> Option<[usize; 2]> {
        self.pair.map(|pair| pair.cameras)
    }

    /// By how much what is known of an object's pose may be wrong, where no majority of cameras or tags agrees on it.
    pub fn doubt(&self, object: usize, time_ns: u64) -> Option<PoseSigma> {
        let site = self.site.as_ref()?;
        let own = |one: &&ComparedInstant| site.object(one.instant.body) == object;
        let newest = self.compared.iter().rev().find(own)?;
        let is_new = newest.time_ns.abs_diff(time_ns) <= NEW_NS;
        let views = || newest.instant.views.iter();
        if let Some(pair) = self.pair
            && views().all(|view| pair.cameras.contains(&view.camera))
        {
            return Some(pair.apart);
        }
        let is_open = self.since_ns.is_some() && self.n_explained < MOST_TO_EXPLAIN;
        (is_open && is_new && self.is_undecided(newest)).then_some(newest.screened.apart)
    }

    fn is_undecided(&self, one: &ComparedInstant) -> bool {
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

    /// Mistakes have been mended: what is compared from now on has no part in that, and judges it.
    pub fn models_mended(&mut self, unmended: &NominalSite) {
        let first = self.unmended.take();
        self.models_changed();
        self.unmended = Some(first.unwrap_or_else(|| unmended.clone()));
    }

    /// What instants since mistakes were mended say of that; `None` unless they are explained clearly better.
    pub fn judged_mended(&self) -> Option<HeldBack> {
        let pairs = self.compared.iter().filter_map(|one| one.squares);
        HeldBack::judged(&pairs.collect::<Vec<SquaresPair>>())
    }

    /// Whether nothing contradicts the models in force.
    pub fn is_closed(&self) -> bool {
        self.since_ns.is_none() && self.pair.is_none()
    }

    /// Errors of the models have been corrected by little.
    pub fn models_corrected(&mut self) {
        self.site = None;
    }

    /// Forgets the images as well: their times or their objects mean something else now.
    pub fn forget(&mut self) {
        self.evidence.clear();
        self.models_changed();
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

/// Whether a mistake is mended in the models. Clocks and loose tags are estimated and named by others, who need more
/// time.
fn is_mended(mistake: &Mistake) -> bool {
    !matches!(mistake, Mistake::ClockOff { .. } | Mistake::TagMoved { .. })
}

/// The cameras of two mistakes, either of which explains the same.
fn pair(mistakes: [Mistake; 2], site: &NominalSite) -> Option<Pair> {
    let [first, second] = mistakes.map(|one| one.cameras().first().copied());
    let cameras = [first?, second?];
    let mut apart = PoseSigma::NONE;
    for (mistake, camera) in mistakes.iter().zip(cameras) {
        let before = site.cameras[camera].as_ref()?.world_from_camera;
        let amended = mistake.amended(site);
        let moved = amended.cameras[camera].as_ref()?.world_from_camera;
        let step = se3::difference(&moved, &before);
        apart.position_m = apart.position_m.max(step.fixed_rows::<3>(0).norm());
        apart.orientation_rad = apart.orientation_rad.max(step.fixed_rows::<3>(3).norm());
    }
    Some(Pair { cameras, apart })
}
