//! Which of a tag's pixels are looked at: those beside edges of its pattern, where all the knowledge of its place is.
//!
//! Of a small tag every pixel is; of a large one, places along the edges are left out evenly, so that it costs no more.

use super::blurred_pattern::{BlurredPattern, CROSSINGS};
use super::lanes::{GROUP, LANES, Lanes, lane, map};
use super::state::{Inverse, State};
use crate::Image;
use crate::quad::{Point, Quad, twice_area};

/// Most pixels of a tag: enough for about two thirds of the accuracy that all pixels of a tag of 60 px would give.
pub(super) const MAX_PIXELS: usize = 32 * LANES;

/// A patch of pixels of a small tag: as many as have their residuals looked at together.
const PATCH_ROWS: usize = 4;
const PATCH_COLUMNS: usize = GROUP / PATCH_ROWS;

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

/// Pixels that are worked on together: where they are and how bright.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) x: Lanes,
    pub(super) y: Lanes,
    pub(super) grey: Lanes,
}

const EMPTY: Block = Block {
    x: [0.0; LANES],
    y: [0.0; LANES],
    grey: [0.0; LANES],
};

#[derive(Debug)]
pub(super) struct Pixels {
    blocks: Vec<Block>,
    n: usize,
    /// How far from the square's middle pixels show the pattern alone.
    pub(super) reach: f32,
    /// Ends of the pattern's edges in the image.
    edges: Vec<[Point; 2]>,
    /// Whether the next place on an edge gets four pixels or two.
    wide: u32,
    /// Distance between the pixels taken across an edge: one, or more where blur spreads the edge.
    spacing_px: f32,
}

impl Default for Pixels {
    fn default() -> Self {
        Self {
            blocks: vec![EMPTY; MAX_PIXELS / LANES],
            n: 0,
            reach: 1.0,
            edges: Vec::with_capacity(2 * CROSSINGS),
            wide: 0,
            spacing_px: 1.0,
        }
    }
}

/// Where pixels come from, and how far from the square's middle they show the pattern alone.
struct View<'a> {
    image: &'a Image<'a>,
    inverse: Inverse,
    reach: f32,
}

impl View<'_> {
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
    /// Pixels that are worked on together, in the order in which they lie beside each other, and how many of the last
    /// block's lanes are pixels.
    pub(super) fn blocks(&self) -> impl Iterator<Item = (&Block, usize)> {
        (0..self.n)
            .step_by(LANES)
            .zip(&self.blocks)
            .map(|(first, block)| (block, (self.n - first).min(LANES)))
    }

    /// Every how many blocks suffice for the first step: a quarter of them, or enough to be sure.
    pub(super) fn first_stride(&self) -> usize {
        const ENOUGH: usize = 6;
        (self.n.div_ceil(LANES) / ENOUGH).clamp(1, 4)
    }

    /// Gathers the pixels to look at.
    pub(super) fn choose(&mut self, image: &Image<'_>, pattern: &BlurredPattern, state: &State) {
        self.n = 0;
        let Some(inverse) = state.inverse() else {
            return;
        };
        let view = View {
            image,
            inverse,
            reach: pattern.reach(state),
        };
        self.reach = view.reach;
        self.spacing_px = (state.blur_px() / BLUR_PER_SPACING).max(1.0);
        let quad = view.outline(state);
        if twice_area(&quad) / 2.0 < MAX_PIXELS as f32 {
            self.take_all(&view, &quad);
        } else {
            self.take_edges(&view, pattern, state);
        }
        self.fill_up();
    }

    /// Gives the last block's lanes beyond all pixels a pixel with which arithmetic is harmless.
    fn fill_up(&mut self) {
        let first = self.blocks[0];
        if let Some(last) = self.blocks.get_mut(self.n / LANES) {
            for lane in (self.n % LANES..LANES).map(lane) {
                (last.x[lane], last.y[lane], last.grey[lane]) =
                    (first.x[0], first.y[0], first.grey[0]);
            }
        }
    }

    /// Takes a pixel that is in the image.
    #[inline]
    fn push(&mut self, image: &Image<'_>, x: u32, y: u32) {
        let Some(grey) = image.at(x as usize, y as usize) else {
            return;
        };
        if let Some(block) = self.blocks.get_mut(self.n / LANES) {
            let lane = lane(self.n);
            (block.x[lane], block.y[lane]) = (x as f32, y as f32);
            block.grey[lane] = f32::from(grey);
            self.n += 1;
        }
    }

    /// Every pixel on the quad, patch after patch.
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
        for y in rows.clone().step_by(PATCH_ROWS) {
            for x in columns.clone().step_by(PATCH_COLUMNS) {
                for dy in 0..PATCH_ROWS {
                    for dx in 0..PATCH_COLUMNS {
                        let (x, y) = (x + dx, y + dy);
                        let [u, v] = view.inverse.apply([x as f32, y as f32]);
                        if u.abs() <= view.reach && v.abs() <= view.reach {
                            self.push(view.image, x as u32, y as u32);
                        }
                    }
                }
            }
        }
    }

    /// Pixels beside every edge between black and white, at even distances along it.
    fn take_edges(&mut self, view: &View<'_>, pattern: &BlurredPattern, state: &State) {
        let project = |[u, v]: Point| state.homography.apply(u, v);
        self.wide = 0;
        self.edges.clear();
        self.edges
            .extend(pattern.edges().map(|ends| ends.map(project)));
        let length: f32 = self.edges.iter().map(|&[a, b]| steps_between(a, b)).sum();
        let stride = (length * PIXELS_ACROSS / MAX_PIXELS as f32).max(1.0);
        let mut along = stride / 2.0;
        for i in 0..self.edges.len() {
            along = self.walk(view, self.edges[i], along, stride);
        }
    }

    /// Goes from `a` to `b`, taking pixels every `stride` steps, the first after `along`; returns what is left of the
    /// stride at the end.
    fn walk(&mut self, view: &View<'_>, [a, b]: [Point; 2], mut along: f32, stride: f32) -> f32 {
        let n_steps = steps_between(a, b);
        let (dx, dy) = ((b[0] - a[0]) / n_steps, (b[1] - a[1]) / n_steps);
        let flat = dx.abs() >= dy.abs();
        let slope = if flat { dy / dx } else { dx / dy };
        while along < n_steps {
            let (x, y) = (a[0] + along * dx, a[1] + along * dy);
            // At a whole column (or row), the nearest pixels on either side of the edge; every other time two more
            // farther off, which tell black, white and blur.
            let (fixed, across) = if flat {
                let column = (x + 0.5).floor();
                (column, y + (column - x) * slope)
            } else {
                let row = (y + 0.5).floor();
                (row, x + (row - y) * slope)
            };
            let asides = if self.wide == 0 {
                &ASIDES[..]
            } else {
                &ASIDES[1..3]
            };
            self.wide = (self.wide + 1) % WIDE_EVERY;
            for aside in asides {
                let at = across + aside * self.spacing_px + 0.5;
                let (x, y) = if flat { (fixed, at) } else { (at, fixed) };
                if x >= 0.0 && y >= 0.0 {
                    self.push(view.image, x as u32, y as u32);
                }
            }
            along += stride;
        }
        along - n_steps
    }
}

/// Where pixels are taken across an edge, in spacings.
const ASIDES: [f32; 4] = [-1.5, -0.5, 0.5, 1.5];

/// Pixels taken at a place, on average.
const PIXELS_ACROSS: f32 = 2.0 + 2.0 / WIDE_EVERY as f32;

/// Every so many places are looked at farther to either side.
const WIDE_EVERY: u32 = 3;

/// Columns or rows that an edge passes, whichever are more.
fn steps_between(a: Point, b: Point) -> f32 {
    (b[0] - a[0])
        .abs()
        .max((b[1] - a[1]).abs())
        .max(f32::MIN_POSITIVE)
}
