//! Sub-pixel corners from straight lines through the edges of the border.
//!
//! Input: a quad accurate to about a pixel. Output: the quad between four lines, each fitted to the points of steepest
//! grey along its side, with the covariance of the corners from their scatter.

mod profiles;

use crate::homography::POINTS;
use crate::quad::{Line, Point, Quad, distance, intersect_sides};
use crate::view::ImageView;
use profiles::{MAX_GROUPS, Profiles};

/// Standard deviation of the position of a line in addition to the scatter of its crossings, in pixels: along an edge
/// parallel to rows or columns all profiles have the same phase in the pixel grid and the same error.
const SHARED_ERROR_PX: f32 = 0.015;

/// Covariance of corners that are known from the outline only: half a pixel.
const OUTLINE_COVARIANCE: [f32; 3] = [0.25, 0.0, 0.25];

/// Corners, their covariance (xx, xy, yy) and that between them, as a [`crate::Detection`] has them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    pub(crate) quad: Quad,
    pub(crate) covariance: [[f32; 3]; 4],
    /// Zero for corners from lines, since the common error of the profiles of an edge is poorly known.
    pub(crate) cross_covariance: [[f32; 4]; 6],
}

impl Corners {
    /// Variance of all corners along each axis.
    pub(crate) fn mean_variance(&self) -> f32 {
        let traces = self.covariance.iter().map(|[xx, _, yy]| xx + yy);
        traces.sum::<f32>() / 8.0
    }

    /// Adds an independent error of a corner with this standard deviation along each axis, in pixels.
    pub(crate) fn widen(&mut self, corner: usize, sigma_px: f32) {
        let [xx, _, yy] = &mut self.covariance[corner];
        *xx += sigma_px * sigma_px;
        *yy += sigma_px * sigma_px;
    }
}

/// Refines the quad of an outline to a fraction of a pixel, with lines through a few points on each edge; without such
/// points the quad is returned unchanged.
pub(crate) fn fit_coarsely(view: &ImageView<'_>, quad: &Quad) -> Corners {
    let outline = Corners {
        quad: *quad,
        covariance: [OUTLINE_COVARIANCE; 4],
        cross_covariance: Default::default(),
    };
    fit(view, quad, &Profiles::coarse(quad)).unwrap_or(outline)
}

/// Refines a quad that is accurate to a fraction of a pixel, as well as lines allow.
pub(crate) fn fit_finely(view: &ImageView<'_>, quad: &Quad) -> Option<Corners> {
    fit(view, quad, &Profiles::fine(quad))
}

/// What the border shows of the two sides at a corner, between it and their middles.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CornerSupport {
    /// Share of the places at which there is no edge of the border's contrast.
    pub(crate) hidden: f32,
    /// How far the edge is from the side elsewhere, root mean square, in pixels.
    pub(crate) away_px: f32,
}

/// How well the edges of a border support each of its corners; `contrast` is its step in grey levels.
pub(crate) fn corner_support(
    view: &ImageView<'_>,
    quad: &Quad,
    contrast: f32,
) -> [CornerSupport; 4] {
    /// Least rise of an edge as a share of the contrast.
    const LEAST_RISE: f32 = 0.3;
    const HALF: usize = POINTS / 2;
    let profiles = Profiles::coarse(quad);
    let mut sums = [[0.0; 2]; 4];
    for i in 0..4 {
        let (a, b) = (quad[i], quad[(i + 1) % 4]);
        let Some(Line { normal, .. }) = Line::through(a, b) else {
            continue;
        };
        let mut crossings = [[Crossing::default(); POINTS]; MAX_GROUPS];
        let crossings = profiles.find_crossings(view, a, b, normal, &mut crossings);
        for (at, crossing) in crossings.iter().enumerate() {
            let [n, squares] = &mut sums[(i + at / HALF) % 4];
            // The rise is a sum of differences over two steps.
            if crossing.weight >= 2.0 * LEAST_RISE * contrast {
                *n += 1.0;
                *squares += crossing.beyond * crossing.beyond;
            }
        }
    }
    sums.map(|[n, squares]| CornerSupport {
        hidden: 1.0 - n / POINTS as f32,
        away_px: (squares / f32::max(n, 1.0)).sqrt(),
    })
}

/// Fits a line to each side.
fn fit(view: &ImageView<'_>, quad: &Quad, profiles: &Profiles) -> Option<Corners> {
    let mut sides = [Side::default(); 4];
    for (i, side) in sides.iter_mut().enumerate() {
        *side = Side::fit(view, quad[i], quad[(i + 1) % 4], profiles)?;
    }
    let quad = intersect_sides(&sides.map(|side| side.line))?;
    let covariance: [[f32; 3]; 4] =
        std::array::from_fn(|i| corner_covariance(&sides[(i + 3) % 4], &sides[i]));
    let finite = covariance.iter().flatten().all(|value| value.is_finite());
    finite.then_some(Corners {
        quad,
        covariance,
        cross_covariance: Default::default(),
    })
}

/// A fitted side: its line, and the variances of its offset at both ends.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    line: Line,
    variances: [f32; 2],
}

impl Side {
    /// Fits the side from a to b by weighted least squares, then again without outliers.
    fn fit(view: &ImageView<'_>, a: Point, b: Point, profiles: &Profiles) -> Option<Self> {
        /// Scatter of crossings up to which none is an outlier, in pixels.
        const USUAL_PX: f32 = 0.05;
        const STRAY_IN_SIGMA: f32 = 2.5;
        let [nx, ny] = Line::through(a, b)?.normal;
        let mut crossings = [[Crossing::default(); POINTS]; MAX_GROUPS];
        let crossings = profiles.find_crossings(view, a, b, [nx, ny], &mut crossings);
        let fit = LineFit::through(crossings)?;
        let limit = STRAY_IN_SIGMA * fit.scatter.max(USUAL_PX);
        for crossing in &mut *crossings {
            if (crossing.beyond - fit.at(crossing.along)).abs() > limit {
                crossing.weight = 0.0;
            }
        }
        let fit = LineFit::through(crossings)?;
        let half = distance(a, b) / 2.0;
        let moved = |[x, y]: Point, beyond: f32| [x + nx * beyond, y + ny * beyond];
        Some(Self {
            line: Line::through(moved(a, fit.at(-half)), moved(b, fit.at(half)))?,
            variances: [-half, half].map(|along| fit.variance_at(along)),
        })
    }
}

/// Crossing of an edge and a profile: position along the side from its centre and distance beyond it, in pixels, and
/// steepness.
#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    along: f32,
    beyond: f32,
    weight: f32,
}

/// A line through crossings, with the variances of its offset at their centre and of its slope.
struct LineFit {
    middle: f32,
    offset: f32,
    slope: f32,
    /// RMS distance of the crossings from the line.
    scatter: f32,
    offset_variance: f32,
    slope_variance: f32,
}

impl LineFit {
    fn through(crossings: &[Crossing]) -> Option<Self> {
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
        (n >= 4 && slope.is_finite()).then(|| Self {
            middle,
            offset,
            slope,
            scatter,
            offset_variance,
            slope_variance: offset_variance / xx,
        })
    }

    fn at(&self, along: f32) -> f32 {
        self.offset + self.slope * (along - self.middle)
    }

    fn variance_at(&self, along: f32) -> f32 {
        let away = along - self.middle;
        SHARED_ERROR_PX.powi(2) + self.offset_variance + self.slope_variance * away * away
    }
}

/// A corner c solves n1.c = d1, n2.c = d2, so its covariance is N^-1 diag(v1, v2) N^-T.
fn corner_covariance(before: &Side, after: &Side) -> [f32; 3] {
    let ([a, b], [c, d]) = (before.line.normal, after.line.normal);
    let (v1, v2) = (before.variances[1], after.variances[0]);
    let square = (a * d - b * c).powi(2);
    [
        (d * d * v1 + b * b * v2) / square,
        -(c * d * v1 + a * b * v2) / square,
        (c * c * v1 + a * a * v2) / square,
    ]
}
