//! Whether a move foretells the moments better that had no part in it.

use super::adjusting::{Moved, Relaxed, bundle_of, options, weaken};
use super::moment::Moment;
use super::options::RefinementOptions;
use super::site::{Place, Site};
use crate::bundle::{Bundle, solve};

/// Moments that must have been asked for an answer.
const LEAST: usize = 10;

/// What the moments held back say of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldBack {
    /// How many show what was moved.
    pub moments: usize,
    /// Root mean square distance between seen and foretold corners before, pixels.
    pub before_px: f64,
    /// After.
    pub after_px: f64,
    /// The part by which their cost falls.
    pub gain: f64,
    /// Student's t of cost before less cost after.
    pub t: f64,
}

/// The cost of one moment and its share of the sum of squared distances.
#[derive(Clone, Copy, Default)]
struct Cost {
    cost: f64,
    squares_px: f64,
    corners: f64,
}

impl HeldBack {
    /// `None` where too few show what is moved.
    pub(super) fn ask<'a>(
        site: &Site,
        relaxed: &Relaxed,
        moved: &Moved,
        moments: impl Iterator<Item = &'a Moment>,
    ) -> Option<Self> {
        let costs = moments.filter(|m| m.shows(moved.place)).filter_map(|m| {
            let before = bundle_with(site, m, relaxed.scale);
            let mut after = bundle_with(site, m, relaxed.scale);
            match moved.place {
                Place::Camera(at) => after.cameras[at].world_from_camera = moved.pose,
                Place::Tag(at) => after.tags[at].object_from_tag = moved.pose,
            }
            Some([Cost::of(before)?, Cost::of(after)?])
        });
        let costs: Vec<[Cost; 2]> = costs.collect();
        (costs.len() >= LEAST).then(|| Self::of(&costs))
    }

    fn of(costs: &[[Cost; 2]]) -> Self {
        let n = costs.len() as f64;
        let total = |which: usize, value: &dyn Fn(&Cost) -> f64| {
            costs.iter().map(|pair| value(&pair[which])).sum::<f64>()
        };
        let differences = || costs.iter().map(|[before, after]| before.cost - after.cost);
        let mean = differences().sum::<f64>() / n;
        let variance = differences().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let rms_px = |which| {
            let squares = total(which, &|c| c.squares_px);
            (squares / total(which, &|c| c.corners).max(1.0)).sqrt()
        };
        Self {
            moments: costs.len(),
            before_px: rms_px(0),
            after_px: rms_px(1),
            gain: mean * n / total(0, &|c| c.cost).max(f64::MIN_POSITIVE),
            t: mean / (variance / n).sqrt().max(f64::MIN_POSITIVE),
        }
    }

    /// Whether the change is to be made.
    pub(super) fn is_better(&self, options: &RefinementOptions) -> bool {
        self.t >= options.significance
            && self.gain >= options.least_gain
            && self.after_px < self.before_px
    }
}

impl Cost {
    fn of(bundle: Bundle) -> Option<Self> {
        let solution = solve(bundle, &options()).ok()?;
        let images = solution.bundle.images.iter();
        let tags: usize = images.map(|image| image.tags.len()).sum();
        let corners = 4.0 * tags as f64;
        Some(Self {
            cost: solution.cost,
            squares_px: solution.rms_px.powi(2) * corners,
            corners,
        })
    }
}

fn bundle_with(site: &Site, moment: &Moment, scale: f64) -> Bundle {
    let mut bundle = bundle_of(site, [moment]);
    weaken(&mut bundle, scale);
    bundle
}
