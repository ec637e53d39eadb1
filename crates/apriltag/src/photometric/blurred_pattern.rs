//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Where edges ([`Profile`]) cross, the two shares are multiplied and corrected for their covariance c by c f_uv + c^2/2 f_uuvv, the first
//! terms of the bivariate normal distribution's tetrachoric series (Pearson, Phil. Trans. R. Soc. A 195, 1900).
//! The blur is the same all over a tag, and so is what an edge looks like but for its distance.

use super::edge::{Edge, PIXEL, Profile};
use super::lanes::{LANES, Lanes, map, nearest};
use super::state::{Inverse, Places, State};
use crate::Family;
use crate::quad::Point;
use sextant_tag_families::white_modules;

const MAX_MODULES: usize = 12;

/// Modules that are added around the printed tag, continuing its outermost ring.
const PADDING: usize = 2;

const SIZE: usize = MAX_MODULES + 2 * PADDING;

/// Most edges between modules along one axis that blur carries to a place.
const MAX_EDGES: usize = 4;

pub(super) struct BlurredPattern {
    /// Whether each is white; row after row, padded.
    modules: [[bool; SIZE]; SIZE],
    /// The `WINDOW` by `WINDOW` modules from each one on, one bit each, row after row; row after row.
    windows: [u32; SIZE * SIZE],
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
    u: Profile,
    v: Profile,
    normals: [Point; 2],
    /// Covariance of the blur across the one and across the other, in square pixels.
    covariance: f32,
    /// Edges along an axis that blur carries to a place, at most.
    n_edges: usize,
}

impl Optics {
    #[inline(always)]
    pub(super) fn of(state: &State, inverse: &Inverse, pattern: &BlurredPattern) -> Self {
        let middle = inverse.places(
            &[state.homography.origin[0]; LANES],
            &[state.homography.origin[1]; LANES],
        );
        let [[ux, uy], [vx, vy]] = middle.first_normals();
        let [xx, xy, yy] = state.blur;
        let (u, v) = (
            Profile::new([ux, uy], &state.blur),
            Profile::new([vx, vy], &state.blur),
        );
        let module_px = middle.u_px[0].min(middle.v_px[0]) / pattern.half_border;
        Self {
            covariance: (xx + PIXEL) * ux * vx + xy * (ux * vy + uy * vx) + (yy + PIXEL) * uy * vy,
            normals: [[ux, uy], [vx, vy]],
            n_edges: (2.0 * u.reach_px.max(v.reach_px) / module_px) as usize + 1,
            u,
            v,
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

/// Modules in each of the windows: what is at either side of the most edges.
const WINDOW: usize = MAX_EDGES + 1;

fn windows(modules: &[[bool; SIZE]; SIZE]) -> [u32; SIZE * SIZE] {
    const WITHIN: u32 = (1 << WINDOW) - 1;
    let rows: [u32; SIZE] = modules
        .map(|row| (0..SIZE).fold(0, |bits, column| bits | u32::from(row[column]) << column));
    let mut windows = [0; SIZE * SIZE];
    for (row, windows) in windows.chunks_exact_mut(SIZE).enumerate() {
        for (column, window) in windows.iter_mut().enumerate() {
            for k in 0..WINDOW {
                *window |= (rows[(row + k) % SIZE] >> column & WITHIN) << (k * WINDOW);
            }
        }
    }
    windows
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
        Self {
            modules,
            windows: windows(&modules),
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
        match optics.n_edges {
            1 => self.among::<1>(places, optics),
            2 => self.among::<2>(places, optics),
            _ => self.among::<MAX_EDGES>(places, optics),
        }
    }

    /// With the nearest `EDGES` edges along either axis.
    #[inline(always)]
    fn among<const EDGES: usize>(&self, places: &Places, optics: &Optics) -> Coverage {
        let (mut columns, mut rows) = (Crossings::<EDGES>::NONE, Crossings::<EDGES>::NONE);
        self.cross(&places.u, &places.u_px, &optics.u, &mut columns);
        self.cross(&places.v, &places.v_px, &optics.v, &mut rows);
        let modules: [u32; LANES] = std::array::from_fn(|i| {
            let first = rows.first[i] * SIZE as u32 + columns.first[i];
            self.windows[first as usize % (SIZE * SIZE)]
        });
        let covariance = optics.covariance;
        let [[ux, uy], [vx, vy]] = optics.normals;
        let blurred = map(|i| {
            let across = |row: usize| {
                let module = |k: usize| (modules[i] >> (row * WINDOW + k) & 1) as i32 as f32;
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

    /// The edges nearest to places along one axis.
    #[inline(always)]
    fn cross<const EDGES: usize>(
        &self,
        along: &Lanes,
        unit_px: &Lanes,
        profile: &Profile,
        crossings: &mut Crossings<EDGES>,
    ) {
        // The nearest edge, or as many at either side of the place.
        let before = (EDGES - 1) as f32 / 2.0;
        let half = self.half_border;
        let mut distances = [[0.0; LANES]; EDGES];
        for i in 0..LANES {
            let place = along[i] * half + self.middle;
            let first_edge = nearest((place - before).clamp(1.0, (SIZE - EDGES) as f32));
            crossings.first[i] = first_edge.wrapping_sub(1);
            let (away, module_px) = (place - first_edge as i32 as f32, unit_px[i] / half);
            for k in 0..EDGES {
                distances[k][i] = (away - k as f32) * module_px;
            }
        }
        for (distances, edge) in distances.iter().zip(&mut crossings.edges) {
            profile.at(distances, edge);
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
