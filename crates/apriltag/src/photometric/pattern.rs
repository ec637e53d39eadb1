//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Where edges ([`Profile`]) cross, the two shares are multiplied, plus the blur's covariance times
//! both densities: the first term of the bivariate normal distribution's tetrachoric series (Pearson, Phil. Trans. R. Soc. A
//! 195, 1900).

use super::edge::{Edge, Profile};
use super::equations::GROUP;
use crate::Family;
use sextant_tag_families::white_modules;

/// Modules that are added around the printed tag, continuing its outermost ring.
const PADDING: usize = 2;

/// Modules of the padded pattern along either axis, at most.
const SIZE: usize = 16;

/// Modules along either axis that blur mixes at a place, at most: one more than edges.
const WINDOW: usize = 6;

pub(super) struct Pattern {
    /// Of the padded pattern, a bit for each module, the lowest leftmost, set where white.
    rows: [u32; SIZE],
    /// Modules from the square's middle to its edge.
    pub(super) half_border: f32,
    /// Half edges of the square from its middle to the ring's outer edge.
    pub(super) ring: f32,
    /// Column of the padded pattern in which the square's middle lies.
    middle: f32,
}

/// White's share at a place, its derivatives per pixel across the edges of either axis, those with the blur's variance
/// across the ones and the others and with their covariance, and that with the halo.
pub(super) struct Coverage {
    pub(super) value: f32,
    pub(super) across: [f32; 2],
    pub(super) with_blur: [f32; 3],
    pub(super) with_halo: f32,
    /// The derivative with how much of the ground is mixed in.
    pub(super) with_ground: f32,
}

/// How blur shows: across the edges of either axis, and the covariance between both in square pixels.
pub(super) struct Optics {
    pub(super) profiles: [Profile; 2],
    pub(super) covariance: f32,
}

impl Pattern {
    pub(super) fn new(family: Family, id: u32) -> Self {
        let data = family.data();
        let total = usize::from(data.total_width);
        let mut rows = [0_u32; SIZE];
        for (x, y) in white_modules(family, id) {
            rows[y + PADDING] |= 1 << (x + PADDING);
        }
        continue_outwards(&mut rows, total);
        Self {
            rows,
            half_border: f32::from(data.border_width) / 2.0,
            ring: total as f32 / f32::from(data.border_width),
            middle: total as f32 / 2.0 + PADDING as f32,
        }
    }

    /// Width of a module when the square's is this.
    pub(super) fn module_px(&self, size_px: f32) -> f32 {
        size_px / (2.0 * self.half_border)
    }

    /// Length of all edges between black and white, which are about half of those between modules.
    pub(super) fn edges_px(&self, size_px: f32) -> f32 {
        (2.0 * self.half_border * self.ring).powi(2) * self.module_px(size_px)
    }

    /// What crosses the neighbourhood of places, with the nearest `EDGES` edges along either axis.
    #[inline(always)]
    pub(super) fn cross<const EDGES: usize, const SHARP: bool>(
        &self,
        places: &Places,
        optics: &Optics,
    ) -> Crossings<EDGES> {
        let mut crossings = Crossings {
            edges: [[[[0.0; GROUP]; 4]; EDGES]; 2],
            rows: [[0; GROUP]; WINDOW],
        };
        let beside = (EDGES / 2) as f32;
        let mut first_modules = [[0; GROUP]; 2];
        for (axis, edges) in crossings.edges.iter_mut().enumerate() {
            for i in 0..GROUP {
                let place = places.on_square[axis][i] * self.half_border + self.middle;
                let first_edge = (place - beside).clamp(1.0, (SIZE - EDGES) as f32) + SHIFT;
                first_modules[axis][i] = first_edge.to_bits().wrapping_sub(1) % SIZE as u32;
                let away = place - (first_edge - SHIFT);
                let module_px = places.unit_px[axis][i] / self.half_border;
                for (k, edge) in edges.iter_mut().enumerate() {
                    let looks = optics.profiles[axis].at::<SHARP>((away - k as f32) * module_px);
                    for q in 0..4 {
                        edge[q][i] = looks[q];
                    }
                }
            }
        }
        let [columns, rows] = first_modules;
        for i in 0..GROUP {
            for (k, to) in crossings.rows[..=EDGES].iter_mut().enumerate() {
                to[i] = self.rows[(rows[i] as usize + k) % SIZE] >> columns[i];
            }
        }
        crossings
    }

    #[inline(always)]
    pub(super) fn rim<const SHARP: bool>(&self, places: &Places, optics: &Optics) -> Rim {
        let mut edges = [[[0.0; 4]; GROUP]; 2];
        for axis in 0..2 {
            for i in 0..GROUP {
                let inside = self.ring - places.on_square[axis][i].abs();
                edges[axis][i] =
                    optics.profiles[axis].at::<SHARP>(inside * places.unit_px[axis][i]);
            }
        }
        Rim { edges }
    }
}

/// Places on the square, and how many pixels a unit is there along either axis.
pub(super) struct Places {
    pub(super) on_square: [[f32; GROUP]; 2],
    pub(super) unit_px: [[f32; GROUP]; 2],
}

/// The nearest edges along either axis, and the modules on both sides of them.
pub(super) struct Crossings<const EDGES: usize> {
    edges: [[[[f32; GROUP]; 4]; EDGES]; 2],
    rows: [[u32; GROUP]; WINDOW],
}

impl<const EDGES: usize> Crossings<EDGES> {
    /// At one of the places, for this covariance of the blur.
    #[inline(always)]
    pub(super) fn coverage(&self, at: usize, covariance: f32) -> Coverage {
        let edge = |axis: usize, k: usize| {
            let looks = &self.edges[axis][k];
            [looks[0][at], looks[1][at], looks[2][at], looks[3][at]]
        };
        let row = |j: usize| {
            let module = |i: usize| (self.rows[j][at] >> i & 1) as i32 as f32;
            let mut white = [module(0), 0.0, 0.0, 0.0];
            for i in 0..EDGES {
                let change = module(i + 1) - module(i);
                let edge = edge(0, i);
                for q in 0..4 {
                    white[q] += change * edge[q];
                }
            }
            white
        };
        let mut above = row(0);
        let mut coverage = Coverage {
            value: above[0],
            across: [above[1], 0.0],
            with_blur: [above[2], 0.0, 0.0],
            with_halo: above[3],
            with_ground: 0.0,
        };
        for j in 0..EDGES {
            let [share, density, spread, halo] = edge(1, j);
            let below = row(j + 1);
            let change: [f32; 4] = std::array::from_fn(|q| below[q] - above[q]);
            coverage.value += share * change[0];
            coverage.across[0] += share * change[1];
            coverage.across[1] += density * change[0];
            coverage.with_blur[0] += share * change[2];
            coverage.with_blur[1] += spread * change[0];
            coverage.with_blur[2] += density * change[1];
            coverage.with_halo += share * change[3] + halo * change[0];
            above = below;
        }
        coverage.value += covariance * coverage.with_blur[2];
        coverage
    }
}

/// How the ring's outer edges look from places, the nearest one of either axis.
pub(super) struct Rim {
    edges: [[Edge; GROUP]; 2],
}

impl Rim {
    /// Mixes in what lies beyond the ring: so much of the ground, of which all is so many parts of the contrast more than the
    /// ring.
    #[inline(always)]
    pub(super) fn mix(
        &self,
        at: usize,
        outwards: [f32; 2],
        all: f32,
        much: f32,
        coverage: &mut Coverage,
    ) {
        let [u, v] = [self.edges[0][at], self.edges[1][at]];
        let more = all * much;
        let share = 1.0 - u[0] * v[0];
        coverage.value += more * share;
        coverage.with_ground = all * share;
        for (axis, [own, other]) in [[u, v], [v, u]].into_iter().enumerate() {
            let more = more * other[0];
            coverage.across[axis] += more * own[1].copysign(outwards[axis]);
            coverage.with_blur[axis] -= more * own[2];
            coverage.with_halo -= more * own[3];
        }
    }
}

/// Adding it leaves the nearest whole number in the lowest bits.
const SHIFT: f32 = 12_582_912.0;

/// Fills the padding around the printed tag with the colour of its rim.
fn continue_outwards(rows: &mut [u32; SIZE], total: usize) {
    let (first, last) = (PADDING, PADDING + total - 1);
    for row in &mut rows[first..=last] {
        for k in 0..PADDING {
            *row |= (*row >> first & 1) << k | (*row >> last & 1) << (last + 1 + k);
        }
    }
    let (top, bottom) = (rows[first], rows[last]);
    rows[..first].fill(top);
    rows[last + 1..].fill(bottom);
}
