//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Blur is Gaussian, followed by the pixel's own square: across an edge the square is a trapezoid,
//! here a box as wide as the trapezoid's middle and a Gaussian with the rest of its variance (1/12 px^2 in all). Where
//! edges cross, the two shares are multiplied and corrected for their covariance c by c f_uv + c^2/2 f_uuvv, the first
//! terms of the bivariate normal distribution's tetrachoric series (Pearson, Phil. Trans. R. Soc. A 195, 1900).
//! What an edge looks like is the same all over a tag but for scale, so it is tabulated ([`EdgeTable`]).

use super::state::{Place, State};
use crate::Family;
use crate::quad::Point;
use sextant_tag_families::white_modules;

const MAX_MODULES: usize = 12;

/// Modules that are added around the printed tag, continuing its outermost ring.
const PADDING: usize = 2;

const SIZE: usize = MAX_MODULES + 2 * PADDING;

/// Crossings of module edges, at most.
pub(super) const CROSSINGS: usize = SIZE * SIZE;

/// Most edges between modules along one axis that blur carries to a place.
const MAX_EDGES: usize = 4;

/// Variance of a pixel's square along either axis, in square pixels.
const PIXEL: f32 = 1.0 / 12.0;

pub(super) struct BlurredPattern {
    /// 1 is white; row after row, padded.
    modules: [[f32; SIZE]; SIZE],
    /// Modules from the square's middle to its edge.
    half_border: f32,
    /// Column of the padded pattern in which the square's middle lies.
    middle: f32,
}

/// White's share at a place and its derivatives along u, v and with the blur's covariance (xx, xy, yy).
pub(super) struct Coverage {
    pub(super) value: f32,
    pub(super) along_u: f32,
    pub(super) along_v: f32,
    pub(super) with_blur: [f32; 3],
}

/// How edges along either axis of the pattern look in the image, as of the tag's middle.
pub(super) struct Optics {
    u: EdgeTable,
    v: EdgeTable,
    normals: [Point; 2],
    /// Covariance of the blur across the one and across the other, in square pixels.
    covariance: f32,
    /// Whether more than the two nearest edges along an axis matter.
    crowded: bool,
}

impl Optics {
    pub(super) fn of(state: &State, pattern: &BlurredPattern) -> Self {
        let Some(inverse) = state.inverse() else {
            return Self::unknown();
        };
        let middle = inverse.place(state.homography.origin);
        let [[ux, uy], [vx, vy]] = middle.normals();
        let [xx, xy, yy] = state.blur;
        let (u, v) = (
            EdgeTable::new([ux, uy], &state.blur),
            EdgeTable::new([vx, vy], &state.blur),
        );
        let module_px = middle.u_px.min(middle.v_px) / pattern.half_border;
        Self {
            covariance: (xx + PIXEL) * ux * vx + xy * (ux * vy + uy * vx) + (yy + PIXEL) * uy * vy,
            normals: [[ux, uy], [vx, vy]],
            crowded: u.reach_px.max(v.reach_px) > module_px,
            u,
            v,
        }
    }

    fn unknown() -> Self {
        let table = || EdgeTable::new([1.0, 0.0], &[1.0, 0.0, 1.0]);
        Self {
            u: table(),
            v: table(),
            normals: [[1.0, 0.0], [0.0, 1.0]],
            covariance: 0.0,
            crowded: true,
        }
    }
}

/// Fills the padding around the printed tag with the colour of its rim.
fn continue_outwards(modules: &mut [[f32; SIZE]; SIZE], total: usize) {
    let (first, last) = (PADDING, PADDING + total - 1);
    for row in &mut modules[first..=last] {
        let (left, right) = (row[first], row[last]);
        row[..first].fill(left);
        row[last + 1..].fill(right);
    }
    let (top, bottom) = (modules[first], modules[last]);
    modules[..first].fill(top);
    modules[last + 1..].fill(bottom);
}

/// The nearest edges along one axis: how far each has been crossed and how steeply.
struct Crossings<const EDGES: usize> {
    /// Module before the first edge.
    first: usize,
    edges: [Edge; EDGES],
}

impl BlurredPattern {
    pub(super) fn new(family: Family, id: u32) -> Self {
        let data = family.data();
        let total = usize::from(data.total_width);
        let mut modules = [[0.0; SIZE]; SIZE];
        for (x, y) in white_modules(family, id) {
            modules[y + PADDING][x + PADDING] = 1.0;
        }
        continue_outwards(&mut modules, total);
        Self {
            modules,
            half_border: f32::from(data.border_width) / 2.0,
            middle: total as f32 / 2.0 + PADDING as f32,
        }
    }

    /// How far from the middle pixels are still the pattern's own: what lies beyond the ring around the square blurs
    /// into its outer part. In half edges of the square.
    pub(super) fn reach(&self, state: &State) -> f32 {
        const BLURS: f32 = 2.2;
        let [a, b, _, d, e, ..] = state.homography.m;
        let edge_px = (a.hypot(d) + b.hypot(e)).max(f32::MIN_POSITIVE);
        let module_px = edge_px / (2.0 * self.half_border);
        let blur_px = (state.blur_px().powi(2) + PIXEL).sqrt();
        1.0 + (1.0 - BLURS * blur_px / module_px).clamp(-0.5, 0.8) / self.half_border
    }

    /// The edges between black and white modules from the border inwards: both ends, on the square.
    pub(super) fn edges(&self) -> impl Iterator<Item = [Point; 2]> {
        let first = (self.middle - self.half_border) as usize;
        let last = (self.middle + self.half_border) as usize;
        let on_square = move |i: usize| (i as f32 - self.middle) / self.half_border;
        let lines =
            (first..=last).flat_map(move |line| (first..last).map(move |along| (line, along)));
        lines.flat_map(move |(line, along)| {
            let (t0, t1, at) = (on_square(along), on_square(along + 1), on_square(line));
            let across = self.modules[along][line - 1] != self.modules[along][line];
            let down = self.modules[line - 1][along] != self.modules[line][along];
            let upright = across.then_some([[at, t0], [at, t1]]);
            let level = down.then_some([[t0, at], [t1, at]]);
            upright.into_iter().chain(level)
        })
    }

    /// Number of the crossing of module edges nearest to a place, below [`CROSSINGS`].
    #[inline]
    pub(super) fn nearest_crossing(&self, place: &Place) -> usize {
        let nearest =
            |along: f32| ((along * self.half_border + self.middle + 0.5) as usize).min(SIZE - 1);
        nearest(place.v) * SIZE + nearest(place.u)
    }

    #[inline]
    pub(super) fn at(&self, place: &Place, optics: &Optics) -> Coverage {
        if optics.crowded {
            self.among::<MAX_EDGES>(place, optics)
        } else {
            self.among::<2>(place, optics)
        }
    }

    #[inline]
    fn among<const EDGES: usize>(&self, place: &Place, optics: &Optics) -> Coverage {
        let half = self.half_border;
        let (u_px, v_px) = (place.u_px / half, place.v_px / half);
        let columns = Crossings::<EDGES>::of(place.u * half + self.middle, u_px, &optics.u);
        let rows = Crossings::<EDGES>::of(place.v * half + self.middle, v_px, &optics.v);
        let covariance = optics.covariance;

        let mut above = columns.sum(&self.modules[rows.first]);
        let (mut value, mut with_covariance) = (above.share, 0.0);
        let (mut density, mut spread) = ([above.density, 0.0], [above.spread, 0.0]);
        for (k, row) in rows.edges.iter().enumerate() {
            let below = columns.sum(&self.modules[rows.first + k + 1]);
            let change = below.minus(&above);
            let mixed = change.density * row.density;
            let mixed_twice = 4.0 * change.spread * row.spread;
            value +=
                change.share * row.share + covariance * (mixed + covariance / 2.0 * mixed_twice);
            with_covariance += mixed + covariance * mixed_twice;
            density[0] += change.density * row.share;
            density[1] += change.share * row.density;
            spread[0] += change.spread * row.share;
            spread[1] += change.share * row.spread;
            above = below;
        }
        let [[ux, uy], [vx, vy]] = optics.normals;
        Coverage {
            value,
            along_u: density[0] * place.u_px,
            along_v: density[1] * place.v_px,
            with_blur: [
                spread[0] * ux * ux + spread[1] * vx * vx + with_covariance * ux * vx,
                2.0 * (spread[0] * ux * uy + spread[1] * vx * vy)
                    + with_covariance * (ux * vy + uy * vx),
                spread[0] * uy * uy + spread[1] * vy * vy + with_covariance * uy * vy,
            ],
        }
    }
}

impl<const EDGES: usize> Crossings<EDGES> {
    /// `place` in modules from the first one.
    #[inline]
    fn of(place: f32, module_px: f32, table: &EdgeTable) -> Self {
        // The edges at either side of the place, or two at either side: for two the nearest one and the next.
        let before = EDGES / 2 - 1;
        let first_edge = (place.max(0.0) as usize)
            .saturating_sub(before)
            .clamp(1, SIZE - EDGES);
        let edges =
            std::array::from_fn(|k| table.at((place - (first_edge + k) as f32) * module_px));
        Self {
            first: first_edge - 1,
            edges,
        }
    }

    /// A row of modules, blurred along it.
    #[inline]
    fn sum(&self, modules: &[f32; SIZE]) -> Edge {
        let mut sum = Edge {
            share: modules[self.first],
            density: 0.0,
            spread: 0.0,
        };
        for (k, edge) in self.edges.iter().enumerate() {
            let change = modules[self.first + k + 1] - modules[self.first + k];
            sum.share += change * edge.share;
            sum.density += change * edge.density;
            sum.spread += change * edge.spread;
        }
        sum
    }
}

/// Share of the blur that lies beyond an edge, and the first and half the second derivative of that with the distance, per
/// pixel. Half the second derivative is also the derivative with the variance, as blur obeys the heat equation.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    share: f32,
    density: f32,
    spread: f32,
}

impl Edge {
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        Self {
            share: self.share - other.share,
            density: self.density - other.density,
            spread: self.spread - other.spread,
        }
    }
}

/// Knots of the table on one side of an edge.
const KNOTS: usize = 40;

/// How an edge looks at distances from 0 to `reach_px`; on the other side it is the same turned around.
struct EdgeTable {
    knots: [Edge; KNOTS + 1],
    reach_px: f32,
    knots_per_px: f32,
}

impl EdgeTable {
    fn new([nx, ny]: Point, blur: &[f32; 3]) -> Self {
        const LEAST_VARIANCE: f32 = 0.01;
        const SIGMAS: f32 = 3.2;
        let width = nx.abs().max(ny.abs());
        let gaussian = blur[0] * nx * nx + 2.0 * blur[1] * nx * ny + blur[2] * ny * ny;
        let sigma = (gaussian + (1.0 - width * width) * PIXEL)
            .max(LEAST_VARIANCE)
            .sqrt();
        let reach_px = SIGMAS * sigma + width / 2.0;
        let knots_per_px = KNOTS as f32 / reach_px;
        let knot = |i: usize| {
            let distance = i as f32 / knots_per_px;
            let (far, near) = (distance + width / 2.0, distance - width / 2.0);
            let ((far_share, far_density), (near_share, near_density)) =
                (normal(far / sigma), normal(near / sigma));
            let integral =
                far * far_share - near * near_share + sigma * (far_density - near_density);
            Edge {
                share: integral / width,
                density: (far_share - near_share) / width,
                spread: (far_density - near_density) / (2.0 * sigma * width),
            }
        };
        Self {
            knots: std::array::from_fn(knot),
            reach_px,
            knots_per_px,
        }
    }

    #[inline]
    fn at(&self, distance: f32) -> Edge {
        let t = (distance.abs() * self.knots_per_px).min(KNOTS as f32 - 0.001);
        let i = t as u32 as usize;
        let f = t - i as f32;
        let (a, b) = (&self.knots[i], &self.knots[i + 1]);
        let mix = |a: f32, b: f32| a + f * (b - a);
        let (share, spread) = (mix(a.share, b.share), mix(a.spread, b.spread));
        let density = mix(a.density, b.density);
        if distance < 0.0 {
            Edge {
                share: 1.0 - share,
                density,
                spread: -spread,
            }
        } else {
            Edge {
                share,
                density,
                spread,
            }
        }
    }
}

/// The normal distribution function and its density (Abramowitz & Stegun, Handbook of Mathematical Functions, 26.2.17,
/// |error| < 1e-7).
fn normal(z: f32) -> (f32, f32) {
    let x = z.abs().min(6.0);
    let density = 0.398_942_3 * (-0.5 * x * x).exp();
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let poly = t
        * (0.319_381_53
            + t * (-0.356_563_78 + t * (1.781_477_9 + t * (-1.821_256 + t * 1.330_274_4))));
    let tail = density * poly;
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
}
