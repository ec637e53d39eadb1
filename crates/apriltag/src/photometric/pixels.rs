//! Which of a tag's pixels are looked at: those beside edges of its pattern, where all the knowledge of its place is.
//!
//! Pixels come in groups of neighbours. Of a small tag every pixel is taken; of a large one, a group at each edge between
//! two modules, so that it costs no more.

use super::blurred_pattern::BlurredPattern;
use super::lanes::{LANES, Lanes, map, nearest};
use super::state::{Inverse, State};
use super::straightened::Straightened;
use crate::Image;
use crate::quad::{Point, Quad, twice_area};

/// Most pixels in a group.
pub(super) const GROUP: usize = 16;

/// Most groups of a tag.
const MAX_GROUPS: usize = 128;

/// Groups that are worked on together.
pub(super) const MAX_BLOCKS: usize = MAX_GROUPS / LANES;

/// Area of a tag in pixels up to which all are taken; with the groups at its rim that are not full there is room for them.
const SMALL_AREA: f32 = 1600.0;

/// Blur at which pixels a pixel apart across an edge see all of it that matters.
const BLUR_PER_SPACING: f32 = 0.8;

/// Residuals beyond this many scales count nothing at all (Tukey's biweight).
const TUKEY: f32 = 4.7;

/// What pixels count when `expected` is the model's grey: less the more they stray, and nothing when they are clipped and
/// the model rightly goes beyond.
#[inline(always)]
pub(super) fn weights(greys: &Lanes, expected: &Lanes, scale: f32) -> Lanes {
    let limit = 1.0 / (TUKEY * scale);
    let [weights] = map(|i| {
        let (grey, expected) = (greys[i], expected[i]);
        let clipped = (grey >= 254.0) & (expected > grey) | (grey <= 1.0) & (expected < grey);
        let strays = (grey - expected) * limit;
        let near = (1.0 - strays * strays).max(0.0);
        [if clipped { 0.0 } else { near * near }]
    });
    weights
}

/// Groups that are worked on together: where their pixels are and how bright, a row for the first pixel of each group, one
/// for the second, and so on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) x: [Lanes; GROUP],
    pub(super) y: [Lanes; GROUP],
    pub(super) grey: [Lanes; GROUP],
    /// 1 where there is a pixel, else 0.
    pub(super) present: [Lanes; GROUP],
}

impl Block {
    #[inline(always)]
    fn set(&mut self, row: usize, lane: usize, [x, y]: Point, grey: u8) {
        self.x[row][lane] = x;
        self.y[row][lane] = y;
        self.grey[row][lane] = f32::from(grey);
        self.present[row][lane] = 1.0;
    }

    /// A whole group: the pixels at these places, as far as they are present and in the image.
    #[inline(always)]
    fn take(
        &mut self,
        lane: usize,
        image: &Image<'_>,
        (xs, ys): (&[f32; GROUP], &[f32; GROUP]),
        present: &[f32; GROUP],
    ) {
        let (width, height) = (image.width() as f32, image.height() as f32);
        let (mut columns, mut rows, mut present) = ([0; GROUP], [0; GROUP], *present);
        for i in 0..GROUP {
            let inside = (xs[i] >= 0.0) & (xs[i] < width) & (ys[i] >= 0.0) & (ys[i] < height);
            columns[i] = nearest(if inside { xs[i].floor() } else { 0.0 });
            rows[i] = nearest(if inside { ys[i].floor() } else { 0.0 });
            present[i] = if inside { present[i] } else { 0.0 };
        }
        let (bytes, stride) = image.bytes();
        for i in 0..GROUP {
            let (x, y) = (columns[i], rows[i]);
            self.x[i][lane] = x as i32 as f32;
            self.y[i][lane] = y as i32 as f32;
            self.grey[i][lane] = f32::from(bytes[y as usize * stride + x as usize]);
            self.present[i][lane] = present[i];
        }
    }
}

const EMPTY: Block = Block {
    x: [[0.0; LANES]; GROUP],
    y: [[0.0; LANES]; GROUP],
    grey: [[0.0; LANES]; GROUP],
    present: [[0.0; LANES]; GROUP],
};

#[derive(Debug)]
pub(super) struct Pixels {
    blocks: Vec<Block>,
    /// Groups begun.
    n_groups: usize,
    /// Pixels in each, at most.
    group_size: usize,
    /// Where pixels are taken beside an edge of one step, of two, and so on.
    places: [Places; MAX_PLACES],
    /// How far from the square's middle pixels show the pattern alone.
    pub(super) reach: f32,
}

impl Default for Pixels {
    fn default() -> Self {
        Self {
            blocks: vec![EMPTY; MAX_BLOCKS],
            n_groups: 0,
            group_size: GROUP,
            places: std::array::from_fn(|i| Places::evenly(i + 1)),
            reach: 1.0,
        }
    }
}

/// Where pixels come from, and how far from the square's middle they show the pattern alone.
struct View<'a> {
    image: &'a Image<'a>,
    straightened: Option<&'a Straightened>,
    inverse: Inverse,
    reach: f32,
}

impl View<'_> {
    /// Where the image shows a straightened place.
    fn pixel(&self, place: Point) -> Point {
        let seen = |straightened: &Straightened| straightened.pixel(place);
        self.straightened.and_then(seen).unwrap_or(place)
    }

    /// Of all that shows the pattern, in the image.
    fn outline(&self, state: &State) -> Quad {
        let reach = self.reach;
        [
            [-reach, -reach],
            [reach, -reach],
            [reach, reach],
            [-reach, reach],
        ]
        .map(|[u, v]| state.homography.apply(u, v))
    }
}

impl Pixels {
    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks[..self.n_groups.div_ceil(LANES)]
    }

    /// Pixels in each group.
    pub(super) fn all_rows(&self) -> usize {
        self.group_size
    }

    /// How many pixels of each group suffice for a first step.
    pub(super) fn first_rows(&self) -> usize {
        const ENOUGH_PIXELS: usize = 256;
        ENOUGH_PIXELS
            .div_ceil(self.n_groups.max(1))
            .clamp(self.group_size / 4, self.group_size)
    }

    /// Gathers the pixels to look at.
    #[inline(always)]
    pub(super) fn choose(
        &mut self,
        image: &Image<'_>,
        pattern: &BlurredPattern,
        state: &State,
        straightened: Option<&Straightened>,
    ) {
        self.n_groups = 0;
        let Some(inverse) = state.inverse() else {
            return;
        };
        let view = View {
            image,
            straightened,
            inverse,
            reach: pattern.reach(state),
        };
        self.reach = view.reach;
        let quad = view.outline(state);
        let area = twice_area(&quad) / 2.0;
        if area < SMALL_AREA {
            // As small as there is room for: within a group all pixels count as at its middle.
            self.group_size = match area / SMALL_AREA {
                0.0..0.2 => GROUP / 4,
                0.2..0.45 => GROUP / 2,
                _ => GROUP,
            };
            self.take_all(&view, &quad);
        } else {
            self.group_size = GROUP;
            self.take_edges(&view, pattern, state);
        }
        if let Some(straightened) = straightened {
            self.straighten(straightened);
        }
    }

    fn straighten(&mut self, straightened: &Straightened) {
        let n_blocks = self.n_groups.div_ceil(LANES);
        for block in &mut self.blocks[..n_blocks] {
            for (x, y) in block.x.iter_mut().zip(&mut block.y) {
                [*x, *y] = straightened.places(x, y);
            }
        }
    }

    /// Begins a group; false when there is room for no more.
    fn begin_group(&mut self) -> bool {
        if self.n_groups == MAX_GROUPS {
            return false;
        }
        if self.n_groups.is_multiple_of(LANES) {
            self.blocks[self.n_groups / LANES].present = EMPTY.present;
        }
        self.n_groups += 1;
        true
    }

    /// Every pixel on the quad, in narrow strips.
    #[inline(always)]
    fn take_all(&mut self, view: &View<'_>, quad: &Quad) {
        let bounds = |axis: usize, size: usize| {
            let low = quad
                .iter()
                .map(|corner| corner[axis])
                .fold(f32::INFINITY, f32::min)
                .max(0.0);
            let high = quad.iter().map(|corner| corner[axis]).fold(0.0, f32::max);
            low as usize..(high as usize).saturating_add(1).min(size)
        };
        let (columns, rows) = (
            bounds(0, view.image.width()),
            bounds(1, view.image.height()),
        );
        let size = self.group_size;
        // Groups are about square.
        let strip = if size == GROUP { 4 } else { 2 };
        for first in columns.clone().step_by(strip) {
            let mut n_in_group = size;
            for y in rows.clone() {
                for x in first..(first + strip).min(columns.end) {
                    if !view.inverse.is_within([x as f32, y as f32], view.reach) {
                        continue;
                    }
                    if n_in_group == size {
                        if !self.begin_group() {
                            return;
                        }
                        n_in_group = 0;
                    }
                    let group = self.n_groups - 1;
                    let block = &mut self.blocks[group / LANES];
                    if let Some(grey) = view.image.at(x, y) {
                        let row = scattered(n_in_group, size);
                        block.set(row, group % LANES, [x as f32, y as f32], grey);
                        n_in_group += 1;
                    }
                }
            }
        }
    }

    /// Pixels beside every edge between black and white, a group each.
    #[inline(always)]
    fn take_edges(&mut self, view: &View<'_>, pattern: &BlurredPattern, state: &State) {
        let spacing_px = (state.blur_px() / BLUR_PER_SPACING).max(1.0);
        let every = pattern.edges().count().div_ceil(MAX_GROUPS);
        for ends in pattern.edges().step_by(every.max(1)) {
            if self.begin_group() {
                let [a, b] = ends.map(|[u, v]| view.pixel(state.homography.apply(u, v)));
                self.walk(view.image, [a, b], spacing_px);
            }
        }
    }

    /// Takes pixels on either side of the edge from `a` to `b` into the last group.
    #[inline(always)]
    fn walk(&mut self, image: &Image<'_>, [a, b]: [Point; 2], spacing_px: f32) {
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let flat = dx.abs() >= dy.abs();
        // Along the axis that the edge follows, and across it.
        let (start, way, across, slope) = if flat {
            (a[0], dx, a[1], dy / dx)
        } else {
            (a[1], dy, a[0], dx / dy)
        };
        let places = self.places[(way.abs() as usize).clamp(1, MAX_PLACES) - 1];
        let (mut columns, mut edges) = ([0.0; GROUP], [0.0; GROUP]);
        for i in 0..GROUP {
            columns[i] = (start + way * places.along[i] + 0.5).floor();
            edges[i] = across + (columns[i] - start) * slope + places.aside[i] * spacing_px + 0.5;
        }
        let (xs, ys) = if flat {
            (columns, edges)
        } else {
            (edges, columns)
        };
        let group = self.n_groups.wrapping_sub(1);
        if let Some(block) = self.blocks.get_mut(group / LANES) {
            block.take(group % LANES, image, (&xs, &ys), &places.present);
        }
    }
}

/// Places at which an edge is looked at, at most.
const MAX_PLACES: usize = 6;

/// Where a group's pixels lie beside an edge.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// Shares of the way from the edge's start to its end.
    along: [f32; GROUP],
    /// Distances in spacings.
    aside: [f32; GROUP],
    /// 1 where there is a pixel, else 0.
    present: [f32; GROUP],
}

impl Places {
    /// The nearest pixels on either side at so many even distances, and at some of these places two more farther off,
    /// which tell black, white and blur.
    fn evenly(n_places: usize) -> Self {
        let mut places = Self {
            along: [0.0; GROUP],
            aside: [0.0; GROUP],
            present: [0.0; GROUP],
        };
        let n_wide = (GROUP / 2 - n_places).min(n_places);
        let mut n = 0;
        for k in 0..n_places {
            let wide = (k + 1) * n_wide / n_places > k * n_wide / n_places;
            let asides: &[f32] = if wide {
                &[-0.5, 0.5, -1.5, 1.5]
            } else {
                &[-0.5, 0.5]
            };
            for &aside in asides {
                places.along[scattered(n, GROUP)] = (k as f32 + 0.5) / n_places as f32;
                places.aside[scattered(n, GROUP)] = aside;
                places.present[scattered(n, GROUP)] = 1.0;
                n += 1;
            }
        }
        places
    }
}

/// The row for a group's next pixel, after `n` of `size`: neighbours go into rows far apart, so that a few rows are a fair
/// sample.
fn scattered(n: usize, size: usize) -> usize {
    const STEP: usize = 5;
    n * STEP % size
}
