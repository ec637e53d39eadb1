//! Which mistakes explain what contradicts: the best one first, then what is left.

use std::collections::BTreeSet;

use crate::explained::{Branches, Explained};
use crate::mistake::Mistake;
use crate::site::{Instant, NominalSite, View};
use crate::starts::{Starts, Tried};

/// Most mistakes at a time.
const MOST_MISTAKES: usize = 4;
/// Share of the views that contradict which two mistakes may differ by in what they leave, to explain the same; and
/// such a number of views.
const SAME_SHARE: f64 = 0.03;
const SAME_VIEWS: usize = 2;
/// Times the average cost of an agreeing view by which the views of a mistake's own cameras and tags may cost more on
/// average than with the mistake that explains them best: errors of the files move all views alike. Usual errors of
/// files cost an agreeing view [`USUAL_COST`] at most.
const SAME_COST: f64 = 3.0;
const USUAL_COST: f64 = 1.0;
/// Least cost of a view on average that is worth an explanation, and share of it that the mistake may leave. Views of a
/// site without errors cost .15.
const LEAST_MEAN_COST: f64 = 0.4;
const MOST_COST_LEFT: f64 = 0.35;
/// Factors by which another mistake may cost more to explain the same: one with other parameters, one with as many.
const SAME_TOTAL: f64 = 2.0;
const RIVAL_COST: f64 = 3.0;
/// Least share of the views that contradict which a mistake must explain.
const LEAST_EXPLAINED: f64 = 0.25;
/// Share of the views of a mistake's own cameras and tags that may go on to contradict, beyond that of all views.
const MOST_LEFT: f64 = 0.15;
/// Fewest views that contradict before anything is looked for, and least share of all views.
const FEWEST_VIEWS: usize = 4;
const LEAST_SHARE: f64 = 0.02;

/// What explains the views.
#[derive(Debug, Clone, Default)]
pub struct Explanation {
    /// The mistakes found, the one that explains most first.
    pub found: Vec<Found>,
    /// Views that contradict the site as it is.
    pub n_contradicting: usize,
    /// Views that contradict even after the mistakes are mended.
    pub n_left: usize,
    /// All views.
    pub n_views: usize,
}

/// A mistake that explains views better than all others but one at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The mistake.
    pub mistake: Mistake,
    /// Another that explains the views as well; which of the two was made is open.
    pub or: Option<Mistake>,
}

impl Explanation {
    /// Whether enough views contradict the site that more than errors of single views must be the cause.
    pub fn is_contradicting(&self) -> bool {
        is_contradicting(self.n_contradicting, self.n_views)
    }

    /// Whether that is still so with the mistakes mended, or which mistake was made is open.
    pub fn is_open(&self) -> bool {
        is_contradicting(self.n_left, self.n_views) || self.found.iter().any(|one| one.or.is_some())
    }
}

fn is_contradicting(n: usize, of: usize) -> bool {
    n >= FEWEST_VIEWS && n as f64 >= LEAST_SHARE * of as f64
}

/// A mistake under test.
struct Candidate {
    mistake: Mistake,
    site: NominalSite,
    branches: Branches,
    explained: Explained,
    n_left: usize,
}

/// Explains views that contradict a site by the mistakes that are possible. Instants with less than two views say
/// nothing.
#[must_use]
pub fn explain(
    site: &NominalSite,
    instants: &[Instant],
    is_possible: impl Fn(&Mistake) -> bool,
) -> Explanation {
    let branches = Branches::new(site, instants);
    let explained = Explained::new(site, instants, &branches);
    let n_contradicting = explained.contradicting(instants).count();
    let mut explanation = Explanation {
        found: Vec::new(),
        n_contradicting,
        n_left: n_contradicting,
        n_views: instants.iter().map(|instant| instant.views.len()).sum(),
    };
    let mut at = (site.clone(), branches, explained);
    for _ in 0..MOST_MISTAKES {
        if !is_contradicting(explanation.n_left, explanation.n_views) {
            break;
        }
        let (site, branches, explained) = &at;
        let starts = Starts {
            site,
            instants,
            branches,
            explained,
        };
        let Some((best, or)) = best(candidates(&starts, &is_possible), &starts) else {
            break;
        };
        let is_open = or.is_some();
        explanation.found.push(Found {
            mistake: best.mistake,
            or,
        });
        explanation.n_left = best.n_left;
        at = (best.site, best.branches, best.explained);
        if is_open {
            break;
        }
    }
    explanation
}

/// The mistake that explains views which contradict a site by little each but all in one way; `None` unless it leaves
/// hardly anything of what they cost.
#[must_use]
pub fn recognise(
    site: &NominalSite,
    instants: &[Instant],
    is_possible: impl Fn(&Mistake) -> bool,
) -> Option<Found> {
    let branches = Branches::new(site, instants);
    let explained = Explained::new(site, instants, &branches);
    let n_views = instants
        .iter()
        .map(|instant| instant.views.len())
        .sum::<usize>();
    let before = explained.total();
    if before < LEAST_MEAN_COST * n_views as f64 {
        return None;
    }
    let starts = Starts {
        site,
        instants,
        branches: &branches,
        explained: &explained,
    };
    let mut candidates = candidates(&starts, is_possible);
    let costs = candidates.iter().map(|one| one.explained.total());
    let least = costs.fold(f64::INFINITY, f64::min);
    let most = (MOST_COST_LEFT * before).min(SAME_TOTAL * least);
    let n_parameters = |one: &Candidate| one.mistake.n_parameters();
    candidates.sort_by(|a, b| {
        let by_cost = a.explained.total().total_cmp(&b.explained.total());
        n_parameters(a).cmp(&n_parameters(b)).then(by_cost)
    });
    let explains = |one: &Candidate| one.explained.total() <= most;
    let best = candidates.remove(candidates.iter().position(explains)?);
    let is_same = |one: &Candidate| is_same_of_two(&one.mistake, &best.mistake, instants);
    let most = RIVAL_COST * best.explained.total();
    let is_rival = |one: &Candidate| {
        n_parameters(one) == n_parameters(&best) && one.explained.total() <= most && !is_same(one)
    };
    if candidates.iter().any(is_rival) {
        return None;
    }
    let or = candidates.iter().find(|one| is_same(one));
    let or = or.map(|one| one.mistake);
    Some(Found {
        mistake: best.mistake,
        or,
    })
}

fn candidates(starts: &Starts<'_>, is_possible: impl Fn(&Mistake) -> bool) -> Vec<Candidate> {
    let candidate = |mistake: Mistake| {
        let Tried {
            site,
            branches,
            explained,
        } = starts.tried(&mistake);
        Candidate {
            n_left: explained.contradicting(starts.instants).count(),
            mistake,
            site,
            branches,
            explained,
        }
    };
    let all = starts.all(&starts.suspects()).into_iter();
    all.filter(is_possible).map(candidate).collect()
}

/// The simplest of the candidates that leave the least, with another that is as simple and leaves as little.
fn best(
    mut candidates: Vec<Candidate>,
    starts: &Starts<'_>,
) -> Option<(Candidate, Option<Mistake>)> {
    let n_before = starts.explained.contradicting(starts.instants).count();
    candidates.retain(|one| one.explains_its_own(starts.instants));
    let least = candidates.iter().map(|one| one.n_left).min()?;
    if least as f64 > (1.0 - LEAST_EXPLAINED) * n_before as f64 {
        return None;
    }
    let moved: Vec<Mistake> = candidates.iter().map(|one| one.mistake).collect();
    let same = SAME_VIEWS.max((SAME_SHARE * n_before as f64) as usize);
    candidates.retain(|one| one.n_left <= least + same);
    let costs = candidates.iter().map(|one| one.mean_cost(starts.instants));
    let least = costs.fold(f64::INFINITY, f64::min);
    let agreeing = candidates.iter().map(|one| one.explained.agreeing_cost());
    let most = least + SAME_COST * agreeing.fold(USUAL_COST, f64::min);
    candidates.retain(|one| one.mean_cost(starts.instants) <= most);
    let order = |one: &Candidate| (one.mistake.n_parameters(), one.n_left);
    candidates.sort_by_key(order);
    let mut all = candidates.into_iter();
    let best = all.next()?;
    let n_parameters = best.mistake.n_parameters();
    let is_same = |other: &Mistake| is_same_of_two(other, &best.mistake, starts.instants);
    let mut rivals = all.take_while(|one| one.mistake.n_parameters() == n_parameters);
    // Several explain the same: which one it is stays open.
    if rivals.any(|one| !is_same(&one.mistake)) {
        return None;
    }
    let or = moved.into_iter().find(is_same);
    Some((best, or))
}

/// Whether two mistakes are one to two cameras, which know nothing but where they are to one another.
fn is_same_of_two(one: &Mistake, other: &Mistake, instants: &[Instant]) -> bool {
    let (Mistake::CameraMoved { camera, .. }, Mistake::CameraMoved { camera: second, .. }) =
        (one, other)
    else {
        return false;
    };
    let views = || instants.iter().flat_map(|instant| &instant.views);
    let cameras: BTreeSet<usize> = views().map(|view| view.camera).collect();
    cameras.len() == 2 && camera != second
}

impl Candidate {
    /// What the views of its cameras and tags cost on average.
    fn mean_cost(&self, instants: &[Instant]) -> f64 {
        let costs = instants.iter().zip(&self.explained.costs);
        let costs = costs.flat_map(|(instant, costs)| instant.views.iter().zip(costs));
        let own = costs.filter(|(view, _)| self.mistake.concerns(&self.site, view));
        let (sum, n_views) = own.fold((0.0, 0.0), |(sum, n), (_, cost)| (sum + cost, n + 1.0));
        sum / f64::max(n_views, 1.0)
    }

    /// Whether the views of its cameras and tags agree with it as well as others do.
    fn explains_its_own(&self, instants: &[Instant]) -> bool {
        let is_own = |view: &View| self.mistake.concerns(&self.site, view);
        let views = || instants.iter().flat_map(|instant| &instant.views);
        let n_own = views().filter(|view| is_own(view)).count() as f64;
        let left = self.explained.contradicting(instants);
        let own_left = left.filter(|(_, view)| is_own(view)).count() as f64;
        let left_share = self.n_left as f64 / views().count().max(1) as f64;
        own_left <= (MOST_LEFT + left_share) * n_own
    }
}
