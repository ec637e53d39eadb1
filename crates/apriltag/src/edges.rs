//! Corners from straight lines through the border's edges, below the pixel.
//!
//! In: a quad within about a pixel. Out: the quad between four lines, each through the points of steepest grey along
//! its side, and what their scatter says of the corners' covariance.

use crate::Image;
use crate::quad::{Line, Point, Quad, distance, intersect_sides};
use sextant_tag_families::BorderColour;

/// Step of the profiles across an edge, in pixels.
const STEP_PX: f32 = 0.5;

/// Most steps to either side of an edge.
const MAX_STEPS: usize = 8;

/// Steps around the steepest place over which its position is averaged: what a blur of 0.7 px spreads over.
const STEEP_STEPS: usize = 3;

/// Standard deviation that a line's place has beyond what its crossings' scatter shows, in pixels: along an edge that runs
/// with the rows or columns all profiles meet the pixels' grid alike and err alike.
const SHARED_ERROR_PX: f32 = 0.015;

/// Most profiles along a side: beyond that the line is no better than the lens is straight.
const MAX_PROFILES: usize = 24;

/// How far to look from a side and how closely.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    /// Distance to either side, in pixels.
    pub(crate) reach_px: f32,
    /// Profiles along a side.
    pub(crate) profiles: usize,
}

impl Search {
    /// From the quad around an outline to within a fraction of a pixel.
    pub(crate) fn coarse(module_px: f32) -> Self {
        Self {
            reach_px: (0.75 * module_px).clamp(1.5, 4.0),
            profiles: 8,
        }
    }

    /// From there as well as lines can tell.
    pub(crate) fn fine() -> Self {
        Self {
            reach_px: 2.0,
            profiles: MAX_PROFILES,
        }
    }
}

/// How far a corner may come to lie from where it was, in reaches: where sides meet at a sharp angle, farther than they
/// move themselves.
const FARTHEST_REACHES: f32 = 5.0;

/// Corners and their covariance (xx, xy, yy).
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFit {
    pub(crate) quad: Quad,
    pub(crate) covariance: [[f32; 3]; 4],
}

/// Fits a line to each side.
pub(crate) fn fit(
    image: &Image<'_>,
    quad: &Quad,
    border: BorderColour,
    search: Search,
) -> Option<EdgeFit> {
    let sign = if border == BorderColour::Black {
        1.0
    } else {
        -1.0
    };
    let mut sides = [Side::default(); 4];
    for (i, side) in sides.iter_mut().enumerate() {
        *side = Side::fit(image, (quad[i], quad[(i + 1) % 4]), sign, search)?;
    }
    let corners = intersect_sides(&sides.map(|side| side.line))?;
    let limit = FARTHEST_REACHES * search.reach_px;
    if corners
        .iter()
        .zip(quad)
        .any(|(&found, &start)| distance(found, start) > limit)
    {
        return None;
    }
    let covariance: [[f32; 3]; 4] =
        std::array::from_fn(|i| corner_covariance(&sides[(i + 3) % 4], &sides[i], corners[i]));
    let finite = covariance.iter().flatten().all(|value| value.is_finite());
    finite.then_some(EdgeFit {
        quad: corners,
        covariance,
    })
}

/// A fitted side: its line, and the variance of its distance as a function of the place along it.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    line: Line,
    middle: Point,
    offset_variance: f32,
    slope_variance: f32,
}

/// Where an edge crosses a profile: place along the side, distance beyond it, steepness.
#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    along: f32,
    beyond: f32,
    weight: f32,
}

impl Side {
    fn fit(image: &Image<'_>, (a, b): (Point, Point), sign: f32, search: Search) -> Option<Self> {
        let line = Line::through(a, b)?;
        let mut crossings = [Crossing::default(); MAX_PROFILES];
        let n = find_crossings(image, &line, (a, b), sign, search, &mut crossings);
        let crossings = &mut crossings[..n];
        let fit = fit_robustly(crossings)?;
        let direction = [-line.normal[1], line.normal[0]];
        let point = |along: f32| {
            let beyond = fit.offset + fit.slope * (along - fit.middle);
            let [nx, ny] = line.normal;
            let origin = [nx * line.offset, ny * line.offset];
            [
                origin[0] + direction[0] * along + nx * beyond,
                origin[1] + direction[1] * along + ny * beyond,
            ]
        };
        Some(Self {
            line: Line::through(point(fit.middle - 1.0), point(fit.middle + 1.0))?,
            middle: point(fit.middle),
            offset_variance: fit.offset_variance,
            slope_variance: fit.slope_variance,
        })
    }

    /// Variance of the line's distance from a point near it.
    fn variance_at(&self, point: Point) -> f32 {
        let away = [point[0] - self.middle[0], point[1] - self.middle[1]];
        SHARED_ERROR_PX.powi(2)
            + self.offset_variance
            + self.slope_variance * (away[0] * away[0] + away[1] * away[1])
    }
}

/// Profiles across the side, away from its ends where the other sides blur in.
fn find_crossings(
    image: &Image<'_>,
    line: &Line,
    (a, b): (Point, Point),
    sign: f32,
    search: Search,
    out: &mut [Crossing],
) -> usize {
    const END: f32 = 1.0 / 12.0;
    let (way, direction) = (
        [b[0] - a[0], b[1] - a[1]],
        [-line.normal[1], line.normal[0]],
    );
    let length = way[0].hypot(way[1]);
    let n_profiles = (length as usize).clamp(8, search.profiles);
    let n_steps = ((search.reach_px / STEP_PX) as usize).clamp(STEEP_STEPS, MAX_STEPS);
    let mut n = 0;
    for i in 0..n_profiles {
        let t = END + (1.0 - 2.0 * END) * (i as f32 + 0.5) / n_profiles as f32;
        let foot = [a[0] + t * way[0], a[1] + t * way[1]];
        if let Some((beyond, weight)) = steepest(image, foot, line.normal, sign, n_steps) {
            out[n] = Crossing {
                along: foot[0] * direction[0] + foot[1] * direction[1],
                beyond,
                weight,
            };
            n += 1;
        }
    }
    n
}

/// Distance along the normal of the steepest rise, and its height.
fn steepest(
    image: &Image<'_>,
    foot: Point,
    normal: Point,
    sign: f32,
    n_steps: usize,
) -> Option<(f32, f32)> {
    let mut profile = [0.0; 2 * MAX_STEPS + 1];
    let profile = &mut profile[..=2 * n_steps];
    let at = |k: usize| {
        let away = (k as f32 - n_steps as f32) * STEP_PX;
        [foot[0] + away * normal[0], foot[1] + away * normal[1]]
    };
    if !image.contains(at(0)) || !image.contains(at(2 * n_steps)) {
        return None;
    }
    for (k, grey) in profile.iter_mut().enumerate() {
        *grey = image.sample_within(at(k)) * sign;
    }
    let rise = |k: usize| profile[k + 1] - profile[k - 1];
    let mut peak = n_steps;
    for k in 1..2 * n_steps {
        if rise(k) > rise(peak) {
            peak = k;
        }
    }
    let around =
        peak.saturating_sub(STEEP_STEPS).max(1)..=(peak + STEEP_STEPS).min(2 * n_steps - 1);
    let (mut sum, mut moment) = (0.0, 0.0);
    for k in around {
        let rise = rise(k).max(0.0);
        sum += rise;
        moment += rise * (k as f32 - n_steps as f32);
    }
    (sum > 0.0).then(|| (moment / sum * STEP_PX, sum))
}

/// A line through crossings and the variances of its offset at the middle and of its slope.
struct LineFit {
    middle: f32,
    offset: f32,
    slope: f32,
    offset_variance: f32,
    slope_variance: f32,
}

/// Weighted least squares, three times, each time without those that stray.
fn fit_robustly(crossings: &mut [Crossing]) -> Option<LineFit> {
    /// Scatter of crossings that no noise need explain, in pixels.
    const USUAL_PX: f32 = 0.05;
    const STRAY_IN_SIGMA: f32 = 2.5;
    let mut fit = fit_line(crossings)?;
    for _ in 0..2 {
        let residual = |crossing: &Crossing| {
            crossing.beyond - fit.offset - fit.slope * (crossing.along - fit.middle)
        };
        let (sum, weight) = crossings
            .iter()
            .fold((0.0, 0.0), |(sum, weight), crossing| {
                (
                    sum + crossing.weight * residual(crossing).powi(2),
                    weight + crossing.weight,
                )
            });
        let limit = STRAY_IN_SIGMA * (sum / weight).sqrt().max(USUAL_PX);
        for crossing in crossings.iter_mut() {
            if residual(crossing).abs() > limit {
                crossing.weight = 0.0;
            }
        }
        fit = fit_line(crossings)?;
    }
    Some(fit)
}

fn fit_line(crossings: &[Crossing]) -> Option<LineFit> {
    let used = || crossings.iter().filter(|crossing| crossing.weight > 0.0);
    let n = used().count();
    if n < 4 {
        return None;
    }
    let sums = used().fold([0.0; 3], |[w, x, y], c| {
        [
            w + c.weight,
            x + c.weight * c.along,
            y + c.weight * c.beyond,
        ]
    });
    let (middle, offset) = (sums[1] / sums[0], sums[2] / sums[0]);
    let [xx, xy, yy] = used().fold([0.0; 3], |[xx, xy, yy], c| {
        let (x, y) = (c.along - middle, c.beyond - offset);
        [
            xx + c.weight * x * x,
            xy + c.weight * x * y,
            yy + c.weight * y * y,
        ]
    });
    let slope = xy / xx;
    let variance = ((yy - slope * xy) / sums[0]).max(1e-4) / (n - 2) as f32;
    slope.is_finite().then(|| LineFit {
        middle,
        offset,
        slope,
        offset_variance: variance,
        slope_variance: variance * sums[0] / xx,
    })
}

/// A corner c solves n1.c = d1, n2.c = d2, so its covariance is N^-1 diag(v1, v2) N^-T.
fn corner_covariance(before: &Side, after: &Side, corner: Point) -> [f32; 3] {
    let ([a, b], [c, d]) = (before.line.normal, after.line.normal);
    let (v1, v2) = (before.variance_at(corner), after.variance_at(corner));
    let square = (a * d - b * c).powi(2);
    [
        (d * d * v1 + b * b * v2) / square,
        -(c * d * v1 + a * b * v2) / square,
        (c * c * v1 + a * a * v2) / square,
    ]
}
