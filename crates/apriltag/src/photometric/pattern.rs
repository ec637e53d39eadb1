//! Share of white of a blurred tag at a position, and its derivatives.
//!
//! The square -1..1 consists of `border_width` modules; the ring around it belongs to the pattern. Beyond the ring is
//! white plus the grey of the background. Where edges ([`Profile`]) cross, the two shares are multiplied, plus the
//! blur's covariance times both densities: the first term of the bivariate normal distribution's tetrachoric series
//! (Pearson, Phil. Trans. R. Soc. A 195, 1900).

use super::SHIFT;
use super::edge::{Edge, Profile};
use crate::Family;
use crate::kernels::ROWS;
use crate::quad::Point;
use sextant_tag_families::white_modules;

/// Adjacent pixels that are processed together.
pub(super) const GROUP: usize = ROWS;

/// Modules around the printed tag that are part of the padded pattern.
const PADDING: usize = 2;

/// Largest number of modules of the padded pattern along either axis.
const SIZE: usize = 16;

/// Number of lines: for each axis, edges from dark to bright and from bright to dark.
pub(super) const LINES: usize = 4 * SIZE;

/// Most edges of either axis that blur combines at a position.
pub(super) const MOST_EDGES: usize = 3;

pub(super) struct Pattern {
    /// For each row of the padded pattern and the one below it, a bit per module, the lowest leftmost, set where white;
    /// the row below is in the upper half.
    pairs: [u32; SIZE],
    /// The same for printed modules, along either axis.
    inside: u32,
    /// Modules from the centre of the square to its edge.
    half_border: f32,
    /// Distance from the centre of the square to the ring's outer edge, in half edges of the square.
    pub(super) ring: f32,
    /// Column of the padded pattern that contains the square's centre.
    middle: f32,
}

/// Positions on the square, and pixels per unit along either axis.
pub(super) struct Places {
    pub(super) on_square: [[f32; GROUP]; 2],
    pub(super) unit_px: [[f32; GROUP]; 2],
}

/// Effect of the blur: across the edges of either axis, and the covariance between the two in square pixels.
pub(super) struct Optics {
    pub(super) profiles: [Profile; 2],
    pub(super) covariance: f32,
    /// What a halo adds to the product of two profiles, and its derivative, as [`super::edge::beside_product`] returns
    /// them.
    pub(super) beside_product: [f32; 2],
    /// Apparent displacement of the edges of either axis towards the darker side, in pixels.
    pub(super) shift_px: [f32; 2],
    /// Brightness beyond the ring minus white.
    pub(super) ground: f32,
}

impl Pattern {
    pub(super) fn new(family: Family, id: u32) -> Self {
        let data = family.data();
        let total = usize::from(data.total_width);
        let inside = ((1 << total) - 1) << PADDING;
        let mut rows = [u32::MAX >> SIZE; SIZE];
        rows[PADDING..PADDING + total].fill(u32::MAX >> SIZE & !inside);
        for (x, y) in white_modules(family, id) {
            rows[y + PADDING] |= 1 << (x + PADDING);
        }
        Self {
            pairs: std::array::from_fn(|i| rows[i] | rows[(i + 1) % SIZE] << SIZE),
            inside,
            half_border: f32::from(data.border_width) / 2.0,
            ring: total as f32 / f32::from(data.border_width),
            middle: total as f32 / 2.0 + PADDING as f32,
        }
    }

    /// Width of a module for this size of the square.
    pub(super) fn module_px(&self, size_px: f32) -> f32 {
        size_px / (2.0 * self.half_border)
    }

    /// Length of all edges between black and white, which are about half of those between modules.
    pub(super) fn edges_px(&self, size_px: f32) -> f32 {
        (2.0 * self.half_border * self.ring).powi(2) * self.module_px(size_px)
    }

    /// Number of the line between modules at a position, from the derivatives of its grey across those of either axis.
    #[inline(always)]
    pub(super) fn line(&self, [u, v]: Point, across: Point) -> f32 {
        let across_u = across[0].abs() > across[1].abs();
        let place = if across_u { u } else { v };
        let change = if across_u { across[0] } else { across[1] };
        let line = place * self.half_border + self.middle + SHIFT - SHIFT;
        let axis = if across_u { 0.0 } else { 2.0 };
        let grows = if change > 0.0 { 1.0 } else { 0.0 };
        4.0 * line + axis + grows
    }
}

/// The nearest edges along either axis, the modules on both sides, and which of these are printed.
pub(super) struct Crossings<const EDGES: usize> {
    edges: [[[[f32; GROUP]; 4]; EDGES]; 2],
    /// Each row of modules with the next one, as in the pattern.
    pairs: [[u32; GROUP]; MOST_EDGES / 2 + 1],
    inside: [[u32; GROUP]; 2],
}

impl<const EDGES: usize> Default for Crossings<EDGES> {
    fn default() -> Self {
        Self {
            edges: [[[[0.0; GROUP]; 4]; EDGES]; 2],
            pairs: [[0; GROUP]; MOST_EDGES / 2 + 1],
            inside: [[0; GROUP]; 2],
        }
    }
}

impl<const EDGES: usize> Crossings<EDGES> {
    /// Finds the modules around the positions, with the nearest `EDGES` edges along either axis.
    #[inline(always)]
    pub(super) fn find<const SHARP: bool>(
        &mut self,
        pattern: &Pattern,
        places: &Places,
        optics: &Optics,
    ) {
        let beside = (EDGES - 1) as f32 / 2.0;
        let mut first_modules = [[0; GROUP]; 2];
        for (axis, edges) in self.edges.iter_mut().enumerate() {
            for i in 0..GROUP {
                let place = places.on_square[axis][i] * pattern.half_border + pattern.middle;
                let first_edge = (place - beside).clamp(1.0, (SIZE - EDGES) as f32) + SHIFT;
                first_modules[axis][i] = first_edge.to_bits().wrapping_sub(1) % SIZE as u32;
                self.inside[axis][i] = pattern.inside >> first_modules[axis][i];
                let away = place - (first_edge - SHIFT);
                let module_px = places.unit_px[axis][i] / pattern.half_border;
                for (k, edge) in edges.iter_mut().enumerate() {
                    let distance = (away - k as f32) * module_px + optics.shift_px[axis];
                    let looks = optics.profiles[axis].at::<SHARP>(distance);
                    for q in 0..4 {
                        edge[q][i] = looks[q];
                    }
                }
            }
        }
        let [columns, rows] = first_modules;
        for i in 0..GROUP {
            for (k, pair) in self.pairs[..=EDGES / 2].iter_mut().enumerate() {
                pair[i] = pattern.pairs[(rows[i] as usize + 2 * k) % SIZE] >> columns[i];
            }
        }
    }

    /// Share of white at one of the positions.
    #[inline(always)]
    pub(super) fn coverage(&self, at: usize, optics: &Optics) -> Coverage {
        let edge = |axis: usize, k: usize| {
            let looks = &self.edges[axis][k];
            [looks[0][at], looks[1][at], looks[2][at], looks[3][at]]
        };
        // Visible share of a row of set modules, and its derivatives.
        let across = |axis: usize, modules: u32| {
            let module = |i: usize| (modules >> i & 1) as i32 as f32;
            let mut set = [module(0), 0.0, 0.0, 0.0];
            for i in 0..EDGES {
                let change = module(i + 1) - module(i);
                let edge = edge(axis, i);
                for q in 0..4 {
                    set[q] += change * edge[q];
                }
            }
            set
        };
        let row = |k: usize| self.pairs[k / 2][at] >> (k % 2 * SIZE);
        let mut above = across(0, row(0));
        let mut coverage = Coverage {
            value: above[0],
            across: [above[1], 0.0],
            with_blur: [above[2], 0.0, 0.0],
            with_halo: above[3],
            halos: 0.0,
            with_ground: 0.0,
        };
        for j in 0..EDGES {
            let below = across(0, row(j + 1));
            let change: Edge = std::array::from_fn(|q| below[q] - above[q]);
            coverage.add(&change, &edge(1, j));
            above = below;
        }
        if EDGES > 1 {
            let [u, v] = [across(0, self.inside[0][at]), across(1, self.inside[1][at])];
            coverage.value += optics.ground;
            coverage.with_ground = 1.0 - u[0] * v[0];
            coverage.add(&u.map(|inside| -optics.ground * inside), &v);
        }
        coverage.value += optics.covariance * coverage.with_blur[2];
        let [value, slope] = optics.beside_product;
        coverage.value += value * coverage.halos;
        coverage.with_halo += slope * coverage.halos;
        coverage
    }
}

/// Share of white at a position; its derivatives across the edges of either axis (per pixel), with respect to the
/// variances of the blur across either and their covariance, to the halo, and to the background.
pub(super) struct Coverage {
    pub(super) value: f32,
    pub(super) across: [f32; 2],
    pub(super) with_blur: [f32; 3],
    pub(super) with_halo: f32,
    /// Product of the derivatives of both profiles with respect to the halo.
    halos: f32,
    pub(super) with_ground: f32,
}

impl Coverage {
    /// Adds the product of a profile along u and one along v.
    #[inline(always)]
    fn add(&mut self, u: &Edge, v: &Edge) {
        self.value += u[0] * v[0];
        self.across[0] += u[1] * v[0];
        self.across[1] += u[0] * v[1];
        self.with_blur[0] += u[2] * v[0];
        self.with_blur[1] += u[0] * v[2];
        self.with_blur[2] += u[1] * v[1];
        self.with_halo += u[3] * v[0] + u[0] * v[3];
        self.halos += u[3] * v[3];
    }
}
