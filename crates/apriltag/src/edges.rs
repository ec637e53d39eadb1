//! Corners from straight lines through the border's edges, below the pixel.
//!
//! In: a quad within about a pixel. Out: the quad between four lines, each through the points of steepest grey along
//! its side, and what their scatter says of the corners' covariance.

mod profiles;

use crate::kernels::POINTS;
use crate::quad::{Line, Point, Quad, distance, intersect_sides};
use crate::view::View;
use profiles::{MAX_GROUPS, Profiles};

/// Standard deviation that a line's place has beyond what its crossings' scatter shows, in pixels: along an edge that runs
/// with the rows or columns all profiles meet the pixels' grid alike and err alike.
const SHARED_ERROR_PX: f32 = 0.015;

/// Covariance of corners that only the outline tells: half a pixel either way.
const OUTLINE_COVARIANCE: [f32; 3] = [0.25, 0.0, 0.25];

/// How far a corner may come to lie from where it was, in reaches: where sides meet at a sharp angle, farther than they
/// move themselves.
const FARTHEST_REACHES: f32 = 5.0;

/// Corners and their covariance (xx, xy, yy).
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFit {
    pub(crate) quad: Quad,
    pub(crate) covariance: [[f32; 3]; 4],
}

/// From the quad around an outline to within a fraction of a pixel, as well as lines through a few places on the border's edges
/// tell; where they tell nothing, the quad as it is.
pub(crate) fn fit_coarsely(view: &View<'_>, quad: &Quad) -> EdgeFit {
    let outline = EdgeFit {
        quad: *quad,
        covariance: [OUTLINE_COVARIANCE; 4],
    };
    fit(view, quad, &Profiles::coarse(quad)).unwrap_or(outline)
}

/// From within a fraction of a pixel as well as lines can tell.
pub(crate) fn fit_finely(view: &View<'_>, quad: &Quad) -> Option<EdgeFit> {
    fit(view, quad, &Profiles::fine(quad))
}

/// Fits a line to each side.
fn fit(view: &View<'_>, quad: &Quad, profiles: &Profiles) -> Option<EdgeFit> {
    let mut sides = [Side::default(); 4];
    for (i, side) in sides.iter_mut().enumerate() {
        *side = Side::fit(view, (quad[i], quad[(i + 1) % 4]), profiles)?;
    }
    let corners = intersect_sides(&sides.map(|side| side.line))?;
    let limit = FARTHEST_REACHES * profiles.reach_px;
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

/// Where an edge crosses a profile: place along the side, in pixels from its middle, distance beyond it, steepness.
#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    along: f32,
    beyond: f32,
    weight: f32,
}

impl Side {
    fn fit(view: &View<'_>, (a, b): (Point, Point), profiles: &Profiles) -> Option<Self> {
        let line = Line::through(a, b)?;
        let mut crossings = [Crossing::default(); MAX_GROUPS * POINTS];
        let n = profiles.find_crossings(view, (a, b), &line, &mut crossings);
        let crossings = &mut crossings[..n];
        let fit = fit_robustly(crossings)?;
        let [nx, ny] = line.normal;
        let middle = [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        let point = |along: f32| {
            let beyond = fit.offset + fit.slope * (along - fit.middle);
            [
                middle[0] - ny * along + nx * beyond,
                middle[1] + nx * along + ny * beyond,
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

/// A line through crossings and the variances of its offset at the middle and of its slope.
struct LineFit {
    middle: f32,
    offset: f32,
    slope: f32,
    /// Root of the mean square of what crossings are beside the line.
    scatter: f32,
    offset_variance: f32,
    slope_variance: f32,
}

/// Weighted least squares, up to three times, each time without those that stray.
fn fit_robustly(crossings: &mut [Crossing]) -> Option<LineFit> {
    /// Scatter of crossings that no noise need explain, in pixels.
    const USUAL_PX: f32 = 0.05;
    const STRAY_IN_SIGMA: f32 = 2.5;
    let mut fit = fit_line(crossings)?;
    for _ in 0..2 {
        let limit = STRAY_IN_SIGMA * fit.scatter.max(USUAL_PX);
        let mut n_strays = 0;
        for crossing in crossings
            .iter_mut()
            .filter(|crossing| crossing.weight > 0.0)
        {
            let residual = crossing.beyond - fit.offset - fit.slope * (crossing.along - fit.middle);
            if residual.abs() > limit {
                crossing.weight = 0.0;
                n_strays += 1;
            }
        }
        if n_strays == 0 {
            break;
        }
        fit = fit_line(crossings)?;
    }
    Some(fit)
}

fn fit_line(crossings: &[Crossing]) -> Option<LineFit> {
    let (mut n, mut sums) = (0, [0.0; 6]);
    for &Crossing {
        along: x,
        beyond: y,
        weight,
    } in crossings
    {
        n += u32::from(weight > 0.0);
        let terms = [1.0, x, y, x * x, x * y, y * y];
        sums = std::array::from_fn(|i| sums[i] + weight * terms[i]);
    }
    let [w, x, y, xx, xy, yy] = sums;
    let (middle, offset) = (x / w, y / w);
    let (xx, xy, yy) = (
        xx / w - middle * middle,
        xy / w - middle * offset,
        yy / w - offset * offset,
    );
    let slope = xy / xx;
    let scatter = (yy - slope * xy).max(1e-4).sqrt();
    let offset_variance = scatter * scatter / (n as f32 - 2.0);
    (n >= 4 && slope.is_finite()).then(|| LineFit {
        middle,
        offset,
        slope,
        scatter,
        offset_variance,
        slope_variance: offset_variance / xx,
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
