//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Blur is Gaussian, followed by the pixel's own square: across an edge the square is a trapezoid,
//! here a box as wide as the trapezoid's middle and a Gaussian with the rest of its variance (1/12 px^2 in all). Where
//! edges cross, the two shares are multiplied and corrected for their covariance c by c f_uv + c^2/2 f_uuvv, the first
//! terms of the bivariate normal distribution's tetrachoric series (Pearson, Phil. Trans. R. Soc. A 195, 1900).
//! What an edge looks like is the same all over a tag but for scale, so it is tabulated ([`EdgeTable`]).

use super::lanes::{LANES, Lanes, map, nearest};
use super::state::{Places, State};
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
    /// Whether each is white; row after row, padded.
    modules: [[bool; SIZE]; SIZE],
    /// The same as bits, the least significant leftmost.
    rows: [u32; SIZE],
    /// Modules from the square's middle to its edge.
    half_border: f32,
    /// Column of the padded pattern in which the square's middle lies.
    middle: f32,
}

/// White's share at a place and its derivatives along u, v and with the blur's covariance (xx, xy, yy).
pub(super) struct Coverage {
    pub(super) value: Lanes,
    pub(super) along_u: Lanes,
    pub(super) along_v: Lanes,
    pub(super) with_blur: [Lanes; 3],
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
        let middle = inverse.places(
            &[state.homography.origin[0]; LANES],
            &[state.homography.origin[1]; LANES],
        );
        let [[ux, uy], [vx, vy]] = middle.first_normals();
        let [xx, xy, yy] = state.blur;
        let (u, v) = (
            EdgeTable::new([ux, uy], &state.blur),
            EdgeTable::new([vx, vy], &state.blur),
        );
        let module_px = middle.u_px[0].min(middle.v_px[0]) / pattern.half_border;
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
fn continue_outwards(modules: &mut [[bool; SIZE]; SIZE], total: usize) {
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

impl BlurredPattern {
    pub(super) fn new(family: Family, id: u32) -> Self {
        let data = family.data();
        let total = usize::from(data.total_width);
        let mut modules = [[false; SIZE]; SIZE];
        for (x, y) in white_modules(family, id) {
            modules[y + PADDING][x + PADDING] = true;
        }
        continue_outwards(&mut modules, total);
        let bits = |row: [bool; SIZE]| {
            (0..SIZE).fold(0, |bits, column| bits | u32::from(row[column]) << column)
        };
        Self {
            modules,
            rows: modules.map(bits),
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

    /// White's share at places.
    #[inline(always)]
    pub(super) fn at(&self, places: &Places, optics: &Optics) -> Coverage {
        if optics.crowded {
            self.among::<MAX_EDGES, { MAX_EDGES + 1 }>(places, optics)
        } else {
            self.among::<2, 3>(places, optics)
        }
    }

    /// With the nearest `EDGES` edges along either axis and the `MODULES` beside them.
    #[inline(always)]
    fn among<const EDGES: usize, const MODULES: usize>(
        &self,
        places: &Places,
        optics: &Optics,
    ) -> Coverage {
        let (mut columns, mut rows) = (Crossings::<EDGES>::NONE, Crossings::<EDGES>::NONE);
        self.cross(&places.u, &places.u_px, &optics.u, &mut columns);
        self.cross(&places.v, &places.v_px, &optics.v, &mut rows);
        let modules: [u32; LANES] =
            std::array::from_fn(|i| self.window::<MODULES>(columns.first[i], rows.first[i]));
        let covariance = optics.covariance;
        let [[ux, uy], [vx, vy]] = optics.normals;
        let blurred = map(|i| {
            let across = |row: usize| {
                let module = |k: usize| (modules[i] >> (row * MODULES + k) & 1) as i32 as f32;
                let mut sum = Edge {
                    share: module(0),
                    ..Edge::default()
                };
                for (k, edge) in columns.edges.iter().enumerate() {
                    let change = module(k + 1) - module(k);
                    sum.share += change * edge.share[i];
                    sum.density += change * edge.density[i];
                    sum.spread += change * edge.spread[i];
                }
                sum
            };
            let mut above = across(0);
            let (mut value, mut with_covariance) = (above.share, 0.0);
            let (mut density, mut spread) = ([above.density, 0.0], [above.spread, 0.0]);
            for (k, row) in rows.edges.iter().enumerate() {
                let below = across(k + 1);
                let change = below.minus(&above);
                let mixed = change.density * row.density[i];
                let mixed_twice = 4.0 * change.spread * row.spread[i];
                value += change.share * row.share[i]
                    + covariance * (mixed + covariance / 2.0 * mixed_twice);
                with_covariance += mixed + covariance * mixed_twice;
                density[0] += change.density * row.share[i];
                density[1] += change.share * row.density[i];
                spread[0] += change.spread * row.share[i];
                spread[1] += change.share * row.spread[i];
                above = below;
            }
            [
                value,
                density[0] * places.u_px[i],
                density[1] * places.v_px[i],
                spread[0] * ux * ux + spread[1] * vx * vx + with_covariance * ux * vx,
                2.0 * (spread[0] * ux * uy + spread[1] * vx * vy)
                    + with_covariance * (ux * vy + uy * vx),
                spread[0] * uy * uy + spread[1] * vy * vy + with_covariance * uy * vy,
            ]
        });
        let [value, along_u, along_v, xx, xy, yy] = blurred;
        Coverage {
            value,
            along_u,
            along_v,
            with_blur: [xx, xy, yy],
        }
    }

    /// The modules from a row and a column on, one bit each, row after row.
    #[inline(always)]
    fn window<const MODULES: usize>(&self, column: u32, row: u32) -> u32 {
        let within = (1 << MODULES) - 1;
        (0..MODULES).fold(0, |bits, k| {
            let row = self.rows[(row as usize + k) % SIZE];
            bits | (row >> (column % SIZE as u32) & within) << (k * MODULES)
        })
    }

    /// The edges nearest to places along one axis.
    #[inline(always)]
    fn cross<const EDGES: usize>(
        &self,
        along: &Lanes,
        unit_px: &Lanes,
        table: &EdgeTable,
        crossings: &mut Crossings<EDGES>,
    ) {
        // The edges at either side of the place, or two at either side: for two the nearest one and the next.
        let before = (EDGES / 2) as f32 - 0.5;
        let half = self.half_border;
        let (mut distances, mut knots) = ([[0.0; LANES]; EDGES], [[0; LANES]; EDGES]);
        for i in 0..LANES {
            let place = along[i] * half + self.middle;
            let first_edge = nearest((place - before).clamp(1.0, (SIZE - EDGES) as f32));
            crossings.first[i] = first_edge.wrapping_sub(1);
            let away = place - first_edge as i32 as f32;
            for k in 0..EDGES {
                let px = (away - k as f32) * unit_px[i] / half;
                let at = px.clamp(-table.reach_px, table.reach_px) * table.knots_per_px;
                let knot = nearest(at + KNOTS as f32);
                knots[k][i] = knot;
                distances[k][i] = (at + KNOTS as f32 - knot as i32 as f32) / table.knots_per_px;
            }
        }
        for (k, edge) in crossings.edges.iter_mut().enumerate() {
            table.look_up(&knots[k], &distances[k], edge);
        }
    }
}

/// The nearest edges along one axis: how far each has been crossed and how steeply.
struct Crossings<const EDGES: usize> {
    /// Module before the first edge.
    first: [u32; LANES],
    edges: [Edge<Lanes>; EDGES],
}

impl<const EDGES: usize> Crossings<EDGES> {
    const NONE: Self = Self {
        first: [0; LANES],
        edges: [Edge {
            share: [0.0; LANES],
            density: [0.0; LANES],
            spread: [0.0; LANES],
        }; EDGES],
    };
}

/// Share of the blur that lies beyond an edge, and the first and half the second derivative of that with the distance, per
/// pixel. Half the second derivative is also the derivative with the variance, as blur obeys the heat equation.
#[derive(Clone, Copy, Debug, Default)]
struct Edge<Value = f32> {
    share: Value,
    density: Value,
    spread: Value,
}

impl Edge {
    #[inline(always)]
    fn minus(&self, other: &Self) -> Self {
        Self {
            share: self.share - other.share,
            density: self.density - other.density,
            spread: self.spread - other.spread,
        }
    }
}

/// Knots of the table on one side of an edge.
const KNOTS: usize = 31;

/// Length of the table: a power of two, so that a masked index is within it.
const ENTRIES: usize = 2 * (KNOTS + 1);

/// How an edge looks at distances up to `reach_px` on either side.
struct EdgeTable {
    knots: [Edge; ENTRIES],
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
        let mut knots = [Edge::default(); ENTRIES];
        for i in 0..=KNOTS {
            let edge = edge_at(i as f32 / knots_per_px, sigma, width);
            knots[KNOTS + i] = edge;
            knots[KNOTS - i] = Edge {
                share: 1.0 - edge.share,
                density: edge.density,
                spread: -edge.spread,
            };
        }
        Self {
            knots,
            reach_px,
            knots_per_px,
        }
    }

    /// At knots and pixels beyond each: by the first terms of Taylor's series.
    #[inline(always)]
    fn look_up(&self, knots: &[u32; LANES], beyond: &Lanes, edge: &mut Edge<Lanes>) {
        for i in 0..LANES {
            let knot = &self.knots[knots[i] as usize % ENTRIES];
            edge.share[i] = knot.share;
            edge.density[i] = knot.density;
            edge.spread[i] = knot.spread;
        }
        for i in 0..LANES {
            let (t, spread) = (beyond[i], edge.spread[i]);
            edge.share[i] += t * (edge.density[i] + t * spread);
            edge.density[i] += 2.0 * t * spread;
        }
    }
}

/// A Gaussian and a box as wide as `width`, from so far.
fn edge_at(distance: f32, sigma: f32, width: f32) -> Edge {
    let (far, near) = (distance + width / 2.0, distance - width / 2.0);
    let ((far_share, far_density), (near_share, near_density)) =
        (normal(far / sigma), normal(near / sigma));
    let integral = far * far_share - near * near_share + sigma * (far_density - near_density);
    Edge {
        share: integral / width,
        density: (far_share - near_share) / width,
        spread: (far_density - near_density) / (2.0 * sigma * width),
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
