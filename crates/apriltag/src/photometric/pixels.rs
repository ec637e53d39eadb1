//! Which of a tag's pixels are looked at: those beside edges of its pattern, where all the knowledge of its place is.
//!
//! Of a small tag every pixel is; of a large one, places along the edges are left out evenly, so that it costs no more.

use super::blurred_pattern::{BlurredPattern, CROSSINGS};
use super::state::{Inverse, State};
use crate::Image;
use crate::quad::{Point, Quad, twice_area};
use std::ops::Deref;

/// Most pixels of a tag: enough for about two thirds of the accuracy that all pixels of a tag of 60 px would give.
pub(super) const MAX_PIXELS: usize = 900;

/// Blur at which pixels a pixel apart across an edge see all of it that matters.
const BLUR_PER_SPACING: f32 = 0.8;

/// Residuals beyond this many scales count nothing at all (Tukey's biweight).
const TUKEY: f32 = 4.7;

#[derive(Clone, Copy, Debug)]
pub(super) struct Pixel {
    pub(super) point: Point,
    pub(super) grey: f32,
}

impl Pixel {
    /// What the pixel counts when `expected` is the model's grey: less the more it strays, and nothing when it is clipped
    /// and the model rightly goes beyond.
    #[inline]
    pub(super) fn weight(&self, expected: f32, scale: f32) -> f32 {
        let clipped =
            self.grey >= 254.0 && expected > self.grey || self.grey <= 1.0 && expected < self.grey;
        let strays = (self.grey - expected) / (TUKEY * scale);
        if clipped {
            0.0
        } else {
            (1.0 - strays * strays).max(0.0).powi(2)
        }
    }
}

#[derive(Debug)]
pub(super) struct Pixels {
    pixels: Vec<Pixel>,
    /// Ends of the pattern's edges in the image.
    edges: Vec<[Point; 2]>,
    /// Whether the next place on an edge gets four pixels or two.
    wide: bool,
    /// Distance between the pixels taken across an edge: one, or more where blur spreads the edge.
    spacing_px: f32,
}

impl Default for Pixels {
    fn default() -> Self {
        Self {
            pixels: Vec::with_capacity(MAX_PIXELS),
            edges: Vec::with_capacity(2 * CROSSINGS),
            wide: false,
            spacing_px: 1.0,
        }
    }
}

impl Deref for Pixels {
    type Target = [Pixel];

    fn deref(&self) -> &[Pixel] {
        &self.pixels
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
    /// So many of the first pixels are spread over the tag like all of them: about a quarter, or enough to be sure.
    pub(super) fn quarter(&self) -> usize {
        const ENOUGH: usize = 160;
        (self.pixels.len() / 4).max(ENOUGH).min(self.pixels.len())
    }

    /// Gathers the pixels to look at.
    pub(super) fn choose(&mut self, image: &Image<'_>, pattern: &BlurredPattern, state: &State) {
        self.pixels.clear();
        let Some(inverse) = state.inverse() else {
            return;
        };
        let view = View {
            image,
            inverse,
            reach: pattern.reach(state),
        };
        self.spacing_px = (state.blur_px() / BLUR_PER_SPACING).max(1.0);
        let quad = view.outline(state);
        if twice_area(&quad) / 2.0 < MAX_PIXELS as f32 {
            self.take_all(&view, &quad);
        } else {
            self.take_edges(&view, pattern, state);
        }
    }

    /// Takes a pixel that is in the image and shows the pattern and nothing from around it.
    fn push(&mut self, view: &View<'_>, x: usize, y: usize) {
        let point = [x as f32, y as f32];
        let place = view.inverse.place(point);
        let on_pattern = place.u.abs() <= view.reach && place.v.abs() <= view.reach;
        if on_pattern
            && self.pixels.len() < MAX_PIXELS
            && x < view.image.width()
            && y < view.image.height()
        {
            self.pixels.push(Pixel {
                point,
                grey: f32::from(view.image.row(y)[x]),
            });
        }
    }

    /// Every pixel on the quad, every fourth row first.
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
        for y in [0, 2, 1, 3]
            .into_iter()
            .flat_map(|first| rows.clone().skip(first).step_by(4))
        {
            for x in columns.clone() {
                self.push(view, x, y);
            }
        }
    }

    /// Pixels beside every edge between black and white, at even distances along it.
    fn take_edges(&mut self, view: &View<'_>, pattern: &BlurredPattern, state: &State) {
        let project = |[u, v]: Point| state.homography.apply(u, v);
        self.wide = false;
        self.edges.clear();
        self.edges
            .extend(pattern.edges().map(|ends| ends.map(project)));
        let length: f32 = self.edges.iter().map(|&[a, b]| steps_between(a, b)).sum();
        let stride = (length * PIXELS_ACROSS / MAX_PIXELS as f32).max(1.0);
        for quarter in [0.5, 2.5, 1.5, 3.5] {
            let mut along = stride * quarter;
            for i in 0..self.edges.len() {
                along = self.walk(view, self.edges[i], along, 4.0 * stride);
            }
        }
    }

    /// Goes from `a` to `b`, taking pixels every `stride` steps, the first after `along`; returns what is left of the
    /// stride at the end.
    fn walk(&mut self, view: &View<'_>, [a, b]: [Point; 2], mut along: f32, stride: f32) -> f32 {
        let n_steps = steps_between(a, b);
        let (dx, dy) = ((b[0] - a[0]) / n_steps, (b[1] - a[1]) / n_steps);
        let flat = dx.abs() >= dy.abs();
        while along < n_steps {
            let (x, y) = (a[0] + along * dx, a[1] + along * dy);
            // At a whole column (or row), the nearest pixels on either side of the edge; every other time two more
            // farther off, which tell black, white and blur.
            let (fixed, across) = if flat {
                (x.round(), y + (x.round() - x) * dy / dx)
            } else {
                (y.round(), x + (y.round() - y) * dx / dy)
            };
            let asides = if self.wide {
                &ASIDES[..]
            } else {
                &ASIDES[1..3]
            };
            self.wide = !self.wide;
            for aside in asides {
                let at = (across + aside * self.spacing_px).round();
                let (x, y) = if flat { (fixed, at) } else { (at, fixed) };
                if x >= 0.0 && y >= 0.0 {
                    self.push(view, x as usize, y as usize);
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
const PIXELS_ACROSS: f32 = 3.0;

/// Columns or rows that an edge passes, whichever are more.
fn steps_between(a: Point, b: Point) -> f32 {
    (b[0] - a[0])
        .abs()
        .max((b[1] - a[1]).abs())
        .max(f32::MIN_POSITIVE)
}
