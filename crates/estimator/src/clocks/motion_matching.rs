//! Offset between two cameras' clocks, from the motion that each of them sees alone.
//!
//! With poses a(t) and b(t) of the same body by the timestamps of either camera, the offset o of b's clock against a's
//! minimises sum |b(t) - a(t - o)|² in the metric of both covariances. It holds for any offset, not only for small
//! ones. A camera that is not where the rig says differs at every offset.

use std::collections::VecDeque;

use nalgebra::{Matrix6, Vector3, Vector6};
use sextant_geometry::{Pose, se3, so3};

use crate::clocks::single_camera_track::Sample;
use crate::time::seconds;
use sextant_site_report::ClockOffset;

/// Range of the search about the offset that arrivals imply, s, and its step.
const REACH_S: f64 = 5.0;
const STEP_S: f64 = 0.02;
/// Samples of b compared on the grid, and in the end.
const COARSE: usize = 16;
const FINE: usize = 60;
/// Fewest of them that must meet a pose of a, as a share and as a count.
const FEWEST: usize = 10;
/// Seconds between neighbouring poses of a at most.
const GAP_S: f64 = 0.12;
/// Squared distance (six degrees of freedom) as which a pose counts at most: mirrored attitudes occur.
const MOST: f64 = 200.0;
/// Mean squared distance up to which poses agree.
const FITS: f64 = 24.0;
/// Neighbouring poses that count as one, since their errors are correlated.
const SHARED: f64 = 3.0;
/// One of this many poses may show a motion that happened once.
const FASTEST: usize = 10;
/// Difference of chi-square that decides.
const DECIDES: f64 = 40.0;
/// Local minima of the grid that are looked at more closely.
const MOST_MINIMA: usize = 6;
/// Seconds (one sigma) to which an offset must be known.
const KNOWN_S: f64 = 0.005;
/// Standard deviations from which on an offset is one.
const SIGNIFICANT: f64 = 3.0;
/// Seconds over which motions must be known before no offset is said to explain their difference.
const LONG_S: f64 = 0.7;
/// Metres and radians, one sigma, by which rigs are off anyway.
const RIG: (f64, f64) = (0.002, 0.004);

/// Result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum MotionMatch {
    /// Too little motion or overlap.
    Open,
    /// The same motion at the same stamps.
    Agree,
    /// Offset of the second camera against the first.
    Off(ClockOffset),
    /// No offset explains the difference.
    Differ,
}

/// A body's poses by the stamps of both cameras.
pub(crate) struct MotionPair<'a> {
    pub a: &'a VecDeque<Sample>,
    pub b: &'a VecDeque<Sample>,
}

/// Compares the motions; `implied_ns` is the offset that arrivals imply.
pub(crate) fn compare(pairs: &[MotionPair<'_>], implied_ns: i64) -> MotionMatch {
    let seen = |samples: fn(&MotionPair<'_>) -> usize| pairs.iter().map(samples).sum::<usize>();
    if seen(|pair| pair.a.len()).min(seen(|pair| pair.b.len())) < 2 * FEWEST {
        return MotionMatch::Open;
    }
    let comparison = Comparison { pairs };
    let offset = |off_s: f64| implied_ns as f64 * 1e-9 + off_s;
    let steps = (REACH_S / STEP_S) as i64;
    // Arrivals tell little where a network is slow: a second about no offset at all is searched, too.
    let near = if offset(0.0).abs() > REACH_S {
        steps / 5
    } else {
        -1
    };
    let grid: Vec<f64> = (-steps..=steps)
        .map(|step| offset(step as f64 * STEP_S))
        .chain((-near..=near).map(|step| step as f64 * STEP_S))
        .collect();
    let costs: Vec<Option<f64>> = grid
        .iter()
        .map(|offset_s| Some(comparison.cost(*offset_s, COARSE)?.mean))
        .collect();
    let mut minima = local_minima(&grid, &costs);
    minima.truncate(MOST_MINIMA);
    let refined = minima.into_iter().map(|at| comparison.refined(at));
    let refined: Vec<(f64, Cost)> = refined.flatten().collect();
    let at_zero = comparison.cost(0.0, FINE);
    verdict(&comparison, &refined, at_zero, implied_ns as f64 * 1e-9)
}

fn verdict(
    comparison: &Comparison<'_>,
    refined: &[(f64, Cost)],
    at_zero: Option<Cost>,
    implied_s: f64,
) -> MotionMatch {
    let best = refined.iter().map(|(_, cost)| cost.mean);
    let best = best.fold(f64::INFINITY, f64::min);
    if at_zero.is_some_and(|zero| zero.mean < FITS && zero.chi2_above(best) < DECIDES) {
        return comparison.agreement(refined);
    }
    if best > FITS {
        // Nothing fits: unless hardly anything could be compared, it is no matter of time.
        return if at_zero.is_some() && comparison.span_s() > LONG_S {
            MotionMatch::Differ
        } else {
            MotionMatch::Open
        };
    }
    // What repeats itself fits at several offsets: of those that nearest to what arrivals tell.
    let as_good = refined
        .iter()
        .filter(|(_, cost)| cost.mean < FITS && cost.chi2_above(best) < DECIDES);
    let off = |at: &f64| (at - implied_s).abs();
    let Some((offset_s, cost)) = as_good.min_by(|a, b| off(&a.0).total_cmp(&off(&b.0))) else {
        return MotionMatch::Open;
    };
    let moved = comparison.cost_if_moved();
    if moved.is_some_and(|moved| moved.chi2_above(cost.mean) < DECIDES) {
        return if moved.is_some_and(|moved| moved.mean < cost.mean) {
            MotionMatch::Differ
        } else {
            MotionMatch::Open
        };
    }
    match comparison.sigma_s(*offset_s) {
        Some(sigma_s) if sigma_s < KNOWN_S.min(offset_s.abs() / SIGNIFICANT) => {
            MotionMatch::Off(ClockOffset {
                offset_s: *offset_s,
                sigma_s,
            })
        }
        _ => MotionMatch::Open,
    }
}

/// Places of the grid cheaper than their neighbours, cheapest first.
fn local_minima(grid: &[f64], costs: &[Option<f64>]) -> Vec<f64> {
    let cost = |index: usize| costs.get(index).copied().flatten();
    let is_least = |index: &usize| {
        let Some(own) = cost(*index) else {
            return false;
        };
        let neighbours = [index.checked_sub(1), Some(index + 1)];
        neighbours
            .into_iter()
            .flatten()
            .filter_map(cost)
            .all(|other| own <= other)
    };
    let mut minima: Vec<(f64, f64)> = (0..grid.len())
        .filter(is_least)
        .filter_map(|index| Some((cost(index)?, grid[index])))
        .collect();
    minima.sort_by(|a, b| a.0.total_cmp(&b.0));
    minima.into_iter().map(|(_, at)| at).collect()
}

/// The mean squared distance at an offset.
#[derive(Debug, Clone, Copy)]
struct Cost {
    mean: f64,
    compared: usize,
}

impl Cost {
    /// By how much chi-square exceeds another mean's.
    fn chi2_above(&self, other: f64) -> f64 {
        (self.mean - other) * self.compared as f64 / SHARED
    }
}

struct Comparison<'a> {
    pairs: &'a [MotionPair<'a>],
}

/// Two poses of a body that should be one.
struct Difference {
    /// The second minus the first.
    off: Vector6<f64>,
    information: Matrix6<f64>,
    place: Vector3<f64>,
}

impl Comparison<'_> {
    /// Each of about `most` poses of b with a's about the same moment, if b's clock is off by that.
    fn meetings(&self, offset_s: f64, most: usize) -> impl Iterator<Item = PosePair<'_>> {
        let all: usize = self.pairs.iter().map(|pair| pair.b.len()).sum();
        let every = all.div_ceil(most).max(1);
        let samples = self
            .pairs
            .iter()
            .flat_map(|pair| pair.b.iter().map(move |b| (pair, b)));
        samples
            .step_by(every)
            .filter_map(move |(pair, b)| PosePair::at_offset(pair.a, b, offset_s))
    }

    fn cost(&self, offset_s: f64, most: usize) -> Option<Cost> {
        let squares = self.meetings(offset_s, most).filter_map(|one| one.square());
        let (sum, compared) = squares.fold((0.0, 0), |(sum, n), square| (sum + square, n + 1));
        (compared >= FEWEST).then(|| Cost {
            mean: sum / compared as f64,
            compared,
        })
    }

    /// The minimum near a place of the grid.
    fn refined(&self, start_s: f64) -> Option<(f64, Cost)> {
        let mut best = (start_s, self.cost(start_s, FINE)?);
        let mut step_s = STEP_S / 2.0;
        while step_s > 0.0005 {
            let sides = [best.0 - step_s, best.0 + step_s];
            let better = sides
                .into_iter()
                .filter_map(|at| Some((at, self.cost(at, FINE)?)))
                .min_by(|a, b| a.1.mean.total_cmp(&b.1.mean));
            match better.filter(|(_, cost)| cost.mean < best.1.mean) {
                Some(better) => best = better,
                None => step_s /= 2.0,
            }
        }
        Some(best)
    }

    /// Standard deviation of the offset by the motion of the compared poses, s; `None` where there is none. Leaves the
    /// fastest poses out: the step of a body at rest, or of its track, happens at one moment only.
    fn sigma_s(&self, offset_s: f64) -> Option<f64> {
        let each = self.meetings(offset_s, FINE);
        let mut each: Vec<f64> = each.filter_map(|one| one.information()).collect();
        each.sort_by(f64::total_cmp);
        each.truncate(each.len() - each.len().div_ceil(FASTEST));
        let information = each.iter().sum::<f64>() / SHARED;
        (information > 0.0).then(|| information.sqrt().recip())
    }

    /// Seconds over which b is known.
    fn span_s(&self) -> f64 {
        let ends = self
            .pairs
            .iter()
            .map(|pair| pair.b.front().zip(pair.b.back()));
        let spans = ends
            .flatten()
            .map(|(first, last)| seconds(first.stamp_ns, last.stamp_ns));
        spans.fold(0.0, f64::max)
    }

    /// Whether the clocks agree or their offset is still open.
    fn agreement(&self, refined: &[(f64, Cost)]) -> MotionMatch {
        let nearest = refined.iter().map(|(at, _)| *at);
        let nearest = nearest.min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let known = nearest.and_then(|at| Some((at, self.sigma_s(at)?)));
        match known {
            Some((at, sigma_s)) if sigma_s < KNOWN_S && at.abs() < SIGNIFICANT * sigma_s => {
                MotionMatch::Agree
            }
            _ => MotionMatch::Open,
        }
    }

    /// The cost at the same stamps once b has been moved as a whole: least squares over (dt, dr) of the world about its
    /// origin.
    fn cost_if_moved(&self) -> Option<Cost> {
        let meetings = self.meetings(0.0, FINE);
        let all: Vec<Difference> = meetings.filter_map(|one| one.difference()).collect();
        if all.len() < FEWEST {
            return None;
        }
        let mut normal = Matrix6::zeros();
        let mut right = Vector6::zeros();
        for one in &all {
            let weighted = one.by_move().transpose() * one.information;
            normal += weighted * one.by_move();
            right += weighted * one.off;
        }
        let moved = normal.cholesky()?.solve(&right);
        let squares = all
            .iter()
            .map(|one| one.square(&(one.off - one.by_move() * moved)).min(MOST));
        Some(Cost {
            mean: squares.sum::<f64>() / all.len() as f64,
            compared: all.len(),
        })
    }
}

impl Difference {
    fn square(&self, off: &Vector6<f64>) -> f64 {
        off.dot(&(self.information * off))
    }

    /// How it goes with a small motion (dt, dr) of the world about its origin: [I, -[p]x; 0, I].
    fn by_move(&self) -> Matrix6<f64> {
        let mut by_move = Matrix6::identity();
        by_move
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&-so3::hat(&self.place));
        by_move
    }
}

/// A pose of b, and those of a before and after the same moment.
struct PosePair<'a> {
    before: &'a Sample,
    after: &'a Sample,
    b: &'a Sample,
    /// How far the moment is on the way from one to the other.
    share: f64,
}

impl<'a> PosePair<'a> {
    fn at_offset(a: &'a VecDeque<Sample>, b: &'a Sample, offset_s: f64) -> Option<Self> {
        let at_s = |sample: &Sample| seconds(sample.stamp_ns, b.stamp_ns) - offset_s;
        // Seconds from a's sample to the moment; falls along a.
        let next = a.partition_point(|sample| at_s(sample) > 0.0);
        let (before, after) = (a.get(next.checked_sub(1)?)?, a.get(next)?);
        let gap_s = seconds(before.stamp_ns, after.stamp_ns);
        (gap_s <= GAP_S).then(|| Self {
            before,
            after,
            b,
            share: at_s(before) / gap_s,
        })
    }

    /// Sum of three variances along the diagonal, from place `first` on, with those of the rig.
    fn spread(&self, first: usize, rig: f64) -> f64 {
        let both = [&self.before.covariance, &self.b.covariance];
        let axes = both.map(|matrix| (first..first + 3).map(move |axis| matrix[(axis, axis)]));
        axes.into_iter().flatten().sum::<f64>() + 3.0 * rig * rig
    }

    fn covariance(&self) -> Matrix6<f64> {
        let [metres, radians] = [RIG.0, RIG.1].map(|sigma| sigma * sigma);
        let rig = Vector6::new(metres, metres, metres, radians, radians, radians);
        self.before.covariance + self.b.covariance + Matrix6::from_diagonal(&rig)
    }

    fn pose(&self) -> Option<Pose> {
        let (from, to) = (&self.before.world_from_body, &self.after.world_from_body);
        from.try_lerp_slerp(to, self.share, 1e-9)
    }

    /// Information about the offset, 1/s².
    fn information(&self) -> Option<f64> {
        let (from, to) = (self.before, self.after);
        let moved = se3::difference(&to.world_from_body, &from.world_from_body);
        let rate = moved / seconds(from.stamp_ns, to.stamp_ns);
        Some(rate.dot(&self.covariance().cholesky()?.solve(&rate)))
    }

    fn difference(&self) -> Option<Difference> {
        let at = self.pose()?;
        Some(Difference {
            off: se3::difference(&self.b.world_from_body, &at),
            information: self.covariance().cholesky()?.inverse(),
            place: at.translation.vector,
        })
    }

    /// The squared distance, at most [`MOST`]. The place alone, or the attitude alone, with its variances as if along
    /// one axis, bounds it from below: nearly everywhere on the grid that is enough.
    fn square(&self) -> Option<f64> {
        let place = |sample: &Sample| sample.world_from_body.translation.vector;
        let at = place(self.before).lerp(&place(self.after), self.share);
        let moved = (place(self.b) - at).norm_squared();
        if moved >= MOST * self.spread(0, RIG.0) {
            return Some(MOST);
        }
        let off = se3::difference(&self.b.world_from_body, &self.pose()?);
        if off.fixed_rows::<3>(3).norm_squared() >= MOST * self.spread(3, RIG.1) {
            return Some(MOST);
        }
        let root = self.covariance().cholesky()?.unpack();
        Some(root.solve_lower_triangular(&off)?.norm_squared().min(MOST))
    }
}

#[cfg(test)]
mod tests;
