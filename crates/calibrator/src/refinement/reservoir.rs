//! Which moments are kept: no two alike, and of those that there is no room for, the one goes that tells least.

use super::adjusting::{KERNEL, bundle_of};
use super::moment::Moment;
use super::options::RefinementOptions;
use super::site::{Place, Site};
use crate::bundle::{Freedom, Reduction};
use nalgebra::DMatrix;

/// Each of so many moments in a row is held back.
const HELD_BACK: u64 = 3;
/// What is known before, one deviation of the solver's steps (metres, radians): only the order of moments depends on it.
const PRIOR_SIGMA: f64 = 0.003;

/// What a moment is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Changes are made from it.
    Used,
    /// It judges them.
    HeldBack,
}

#[derive(Clone, Debug)]
struct Kept {
    moment: Moment,
    purpose: Use,
    /// Of the cameras and tags that it shows.
    information: Information,
}

/// What becomes of the newest moment where there is no room.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Newest {
    Stays,
    Goes,
}

/// Over some columns of the whole.
#[derive(Clone, Debug)]
struct Information {
    columns: Vec<usize>,
    matrix: DMatrix<f64>,
}

/// Bounded by [`RefinementOptions::most_used`] and [`RefinementOptions::most_held_back`].
#[derive(Clone, Debug)]
pub(super) struct Reservoir {
    kept: Vec<Kept>,
    most: [usize; 2],
    offered: u64,
    has_news: bool,
}

impl Reservoir {
    pub(super) fn new(options: &RefinementOptions) -> Self {
        Self {
            kept: Vec::new(),
            most: [options.most_used, options.most_held_back],
            offered: 0,
            has_news: false,
        }
    }

    pub(super) fn moments(&self, purpose: Use) -> impl Iterator<Item = &Moment> {
        let of_purpose = self.kept.iter().filter(move |k| k.purpose == purpose);
        of_purpose.map(|kept| &kept.moment)
    }

    pub(super) fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.has_news)
    }

    pub(super) fn offer(&mut self, site: &Site, moment: Moment, options: &RefinementOptions) {
        self.forget(moment.start_ns, options);
        if self.kept.iter().any(|kept| kept.moment.is_like(&moment)) {
            return;
        }
        let Some(information) = Information::of(site, &moment) else {
            return;
        };
        self.offered += 1;
        let purpose = if self.offered.is_multiple_of(HELD_BACK) {
            Use::HeldBack
        } else {
            Use::Used
        };
        self.kept.push(Kept {
            moment,
            purpose,
            information,
        });
        self.has_news |= self.make_room(purpose) == Newest::Stays;
    }

    fn forget(&mut self, now_ns: u64, options: &RefinementOptions) {
        let memory_ns = (options.memory_s * 1e9) as u64;
        let oldest = now_ns.saturating_sub(memory_ns);
        self.kept.retain(|kept| kept.moment.start_ns >= oldest);
    }

    fn make_room(&mut self, purpose: Use) -> Newest {
        let of_purpose = self.kept.iter().filter(|kept| kept.purpose == purpose);
        if of_purpose.count() <= self.most[usize::from(purpose == Use::HeldBack)] {
            return Newest::Stays;
        }
        let newest = self.kept.len() - 1;
        let least = self.least(purpose).unwrap_or(newest);
        self.kept.remove(least);
        if least == newest {
            Newest::Goes
        } else {
            Newest::Stays
        }
    }

    /// The moment whose information the others have most of: the least trace of (all of them)^-1 times its own.
    fn least(&self, purpose: Use) -> Option<usize> {
        let of_purpose = || {
            self.kept
                .iter()
                .enumerate()
                .filter(|(_, k)| k.purpose == purpose)
        };
        let n = of_purpose().flat_map(|(_, k)| &k.information.columns);
        let n = n.max().map_or(0, |last| last + 1);
        let mut all = DMatrix::identity(n, n) * PRIOR_SIGMA.powi(-2);
        for (_, kept) in of_purpose() {
            kept.information.add_to(&mut all);
        }
        let inverse = all.cholesky()?.inverse();
        let told = of_purpose().map(|(at, kept)| (at, kept.information.part_of(&inverse)));
        let least = told.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map(|(at, _)| at)
    }

    pub(super) fn weigh_anew(&mut self, site: &Site) {
        for kept in &mut self.kept {
            if let Some(information) = Information::of(site, &kept.moment) {
                kept.information = information;
            }
        }
    }
}

impl Information {
    fn of(site: &Site, moment: &Moment) -> Option<Self> {
        let mut bundle = bundle_of(site, [moment]);
        let mut columns = Vec::new();
        for place in site.places() {
            if !moment.shows(place) {
                continue;
            }
            let first = match place {
                Place::Camera(camera) => {
                    bundle.cameras[camera].pose = Freedom::Free;
                    6 * camera
                }
                Place::Tag(tag) => {
                    bundle.tags[tag].pose = Freedom::Free;
                    6 * (site.cameras.len() + tag)
                }
            };
            columns.extend(first..first + 6);
        }
        let reduction = Reduction::of(&bundle, &KERNEL).ok()?;
        let finite = reduction.information.iter().all(|x| x.is_finite());
        (finite && reduction.information.nrows() == columns.len()).then_some(Self {
            columns,
            matrix: reduction.information,
        })
    }

    fn add_to(&self, all: &mut DMatrix<f64>) {
        for (i, &row) in self.columns.iter().enumerate() {
            for (j, &column) in self.columns.iter().enumerate() {
                all[(row, column)] += self.matrix[(i, j)];
            }
        }
    }

    fn part_of(&self, inverse: &DMatrix<f64>) -> f64 {
        let mut trace = 0.0;
        for (i, &row) in self.columns.iter().enumerate() {
            for (j, &column) in self.columns.iter().enumerate() {
                trace += inverse[(row, column)] * self.matrix[(j, i)];
            }
        }
        trace
    }
}
