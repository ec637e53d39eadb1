//! The search for the mistakes that explain some instants, as a task of its own: a copy of all that it needs.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use sextant_mistakes::{Explanation, Instant, Mistake, NominalSite, explain, recognise};

use crate::site::indexed_site::IndexedSite;

/// What is looked for.
#[derive(Debug, Clone)]
pub(crate) enum Scope {
    /// Whatever explains instants that contradict.
    Open(History),
    /// Exchanged and turned cameras that would pass for small errors of files.
    Names,
    /// The same, and exchanged and turned tags and prints at another scale: once objects have been seen from several
    /// sides.
    Files,
    /// Prints at another scale, whatever else in the files is off.
    Prints,
    /// A camera moved by so little that no single instant contradicts.
    Small,
}

/// What has been right at a site, and which cameras contradict now: what has been right is changed by what can happen
/// to a site in use alone, and cameras that contradict others are the likelier cause.
#[derive(Debug, Clone, Default)]
pub(crate) struct History {
    /// The cameras and tags that have agreed with others, by index.
    pub cameras: BTreeSet<usize>,
    pub tags: BTreeSet<usize>,
    /// The cameras that contradict others that are right.
    pub suspended: BTreeSet<usize>,
}

impl History {
    fn allows(&self, mistake: &Mistake, site: &NominalSite) -> bool {
        let (cameras, tags) = (mistake.cameras(), mistake.tags(site));
        let was_right = cameras.iter().all(|camera| self.cameras.contains(camera))
            && tags.iter().any(|tag| self.tags.contains(tag)) != tags.is_empty();
        let is_likely_cause = cameras.is_empty()
            || self.suspended.is_empty()
            || cameras.iter().any(|camera| self.suspended.contains(camera));
        (mistake.is_sudden() || !was_right) && is_likely_cause
    }
}

/// A search for mistakes that is due.
#[derive(Debug)]
pub struct MistakeSearch {
    indexed: IndexedSite,
    instants: Vec<Instant>,
    scope: Scope,
    solution: OnceLock<Explanation>,
}

impl MistakeSearch {
    pub(crate) fn new(indexed: IndexedSite, instants: Vec<Instant>, scope: Scope) -> Self {
        Self {
            indexed,
            instants,
            scope,
            solution: OnceLock::new(),
        }
    }

    /// The site that its mistakes are of.
    pub(crate) fn indexed(&self) -> &IndexedSite {
        &self.indexed
    }

    /// Whether it has been solved.
    pub fn is_solved(&self) -> bool {
        self.solution.get().is_some()
    }

    /// Looks for the mistakes, which takes up to some tenths of a second.
    pub fn solve(&self) {
        self.solution();
    }

    /// What explains the instants; the same search always has the same solution.
    pub(crate) fn solution(&self) -> &Explanation {
        self.solution.get_or_init(|| self.solved())
    }

    fn solved(&self) -> Explanation {
        let site = &self.indexed.site;
        let recognised = |is_possible: &dyn Fn(&Mistake) -> bool| Explanation {
            found: Vec::from_iter(recognise(site, &self.instants, is_possible)),
            ..Explanation::default()
        };
        match &self.scope {
            Scope::Open(history) => explain(site, &self.instants, |mistake| {
                history.allows(mistake, site)
            }),
            Scope::Names => {
                recognised(&|mistake| !mistake.cameras().is_empty() && mistake.n_parameters() == 0)
            }
            Scope::Files => {
                recognised(&|mistake| is_scaled(mistake) || mistake.n_parameters() == 0)
            }
            Scope::Prints => recognised(&is_scaled),
            Scope::Small => recognised(&|mistake| {
                matches!(
                    mistake,
                    Mistake::CameraMoved { .. } | Mistake::ClockOff { .. }
                )
            }),
        }
    }
}

fn is_scaled(mistake: &Mistake) -> bool {
    matches!(
        mistake,
        Mistake::BodyScaled { .. } | Mistake::SizesScaled { .. }
    )
}
