//! Corners from the whole pattern: a rendering of the decoded tag is fitted to the pixels.
//!
//! Input: an image, the upright quad of a decoded tag and its code word. Output: corners with covariance, or `None` if
//! the edges alone are more accurate.
//!
//! The rendering is light(u, v) * (black + (white - black) * response(coverage)), where coverage is the blurred pattern
//! ([`Pattern`]), light is a plane over the tag that is 1 at its middle, and response(c) = c + gain c (1 - c) models
//! the tone curve, glare and spreading ink. Gauss-Newton on 18 parameters: the homography (8), black, white,
//! the light's slope (2), the blur's covariance (3), which takes in the lens and straight motion, the halo of
//! sharpening or glare, the grey that blur mixes in from beyond the ring, and the gain. (Least squares on images: Baker
//! & Matthews, Lucas-Kanade 20 years on, IJCV 2004.) It uses a subset of the pixels first, then all of them, usually
//! once. The covariance is that of least squares, inflated where residuals along a line of the pattern are correlated,
//! unlike noise.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over many arrays at once, which zipped would not say what they do"
)]

mod edge;
mod equations;
mod model;
mod parameters;
mod pattern;
mod pixels;
mod state;
mod undistortion;

use crate::Image;
use crate::edges::Corners;
use crate::quad::Quad;
use crate::reading::Reading;
use equations::PixelEquations;
use model::{Model, TUKEY};
use parameters::{BLUR, PARAMETERS};
use pattern::{MOST_EDGES, Pattern};
use pixels::Pixels;
use sextant_geometry::{CORNER_PAIRS, Lens};
use state::{PatternState, Row, dot};
use undistortion::Undistortion;

/// Ratio of the true to the estimated variance of the edges, at most: the scatter of a line does not show what blur
/// adds to all of it from beside the border.
const UNSTATED: f32 = 9.0;

/// Variance of corners, in square pixels, below which edges show no scatter: they run along rows and columns of a
/// drawing.
const EXACT_VARIANCE: f32 = 0.02 * 0.02;

/// Usual residuals from optics, sharpening and compression, as a share of the contrast. Pixels within them are not
/// treated as occluded or lit by something else.
const MODEL_SCALE: f32 = 0.03;

/// Usual residuals before the first step, when corners may be off by tenths of a pixel, as a share of the contrast.
const START_SCALE: f32 = 0.12;

/// Added to a float, it leaves the nearest integer in the lowest bits.
const SHIFT: f32 = 12_582_912.0;

/// Standard deviation of rounding to whole grey levels.
const ROUNDING: f32 = 0.29;

/// Fits patterns; reuses its memory between tags.
#[derive(Debug, Default)]
pub(crate) struct PatternFitter {
    pixels: Pixels,
    equations: PixelEquations,
    /// Lens that distorts the tags, if it is known.
    pub(crate) lens: Option<Lens>,
}

impl PatternFitter {
    /// Allocates the memory that an image of this size can need.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.pixels.make_room(width, height);
    }

    /// Fits the pattern of a decoded tag, starting from its edges, with the noise of the image.
    #[inline(always)]
    pub(crate) fn fit(
        &mut self,
        image: &Image<'_>,
        reading: &Reading,
        edges: &Corners,
        noise_sigma: f32,
    ) -> Option<Corners> {
        let pattern = Pattern::new(reading.family, reading.found.id);
        let lens = self.lens.as_ref();
        let undistortion = lens.and_then(|lens| Undistortion::at(lens, &edges.quad));
        let start = match &undistortion {
            Some(undistortion) => edges.quad.map(|corner| undistortion.place(corner)),
            None => edges.quad,
        };
        let levels = (reading.white - reading.black).max(1.0);
        let mut state = PatternState::start(&start, reading.black / levels)?;
        let mut outline = model::outline(&pattern, &state);
        if let Some(undistortion) = &undistortion {
            outline = outline.map(|place| undistortion.pixel(place).unwrap_or(place));
        }
        let edges_px = pattern.edges_px(state.size_px);
        self.pixels.choose(image, &outline, levels, edges_px)?;
        if let Some(undistortion) = &undistortion {
            self.pixels.straighten(undistortion);
        }
        let excess = self.settle(&pattern, levels, &mut state)?;

        let residual = levels * self.equations.residual_variance().sqrt();
        let variance = (residual.max(ROUNDING) / levels).powi(2) * excess;
        let mut rows = state.corner_rows(&self.equations);
        let squares = rows.as_flattened().iter().map(|row| dot(row, row));
        let mean_variance = variance * squares.sum::<f32>() / 8.0;

        // Where all edges cross their pixels alike in a sharp picture without noise, a fit may come to rest beside
        // them.
        let exact =
            noise_sigma == 0.0 && state.is_sharp() && edges.mean_variance() < EXACT_VARIANCE;
        let surer = mean_variance < UNSTATED * edges.mean_variance();
        if exact || !surer || !state.is_plausible(&start) {
            return None;
        }
        let mut quad = state.corners();
        if let Some(undistortion) = &undistortion {
            for (corner, rows) in quad.iter_mut().zip(&mut rows) {
                (*corner, *rows) = undistortion.shown(*corner, *rows)?;
            }
        }
        Some(with_covariance(quad, &rows, variance))
    }

    /// Iterates with a subset of the pixels and no halo until the corners are approximately right, then with all until
    /// convergence, with less weight for outliers. Returns the factor by which variances exceed those of the last
    /// equations.
    #[inline(always)]
    fn settle(&mut self, pattern: &Pattern, levels: f32, state: &mut PatternState) -> Option<f32> {
        const ENOUGH_GROUPS: usize = 10;
        // Iterations with a few pixels, and with all, end when a step moves corners and changes the blur by less than
        // this. Convergence is quadratic: one more step with all pixels would move corners by about a thousandth of a
        // pixel.
        const REST_PX: [f32; 2] = [0.2, 0.02];
        const REST_VARIANCE: [f32; 2] = [0.4, 0.2];
        const MOST_STEPS: usize = 6;
        let few = (self.pixels.groups().len() / ENOUGH_GROUPS).max(1);
        let (mut scale, mut step) = (START_SCALE, [0.0; _]);
        for (i, every) in [few, 1].into_iter().enumerate() {
            for _ in 0..MOST_STEPS {
                self.linearise(&Model::new(pattern, state, scale, levels)?, scale, every);
                step = self.equations.solve(&state.priors(i > 0));
                state.step(&step)?;
                scale = self.equations.residual_variance().sqrt().max(MODEL_SCALE);
                if state.motion(&step) < REST_PX[i]
                    && (step[BLUR] + step[BLUR + 1]).abs() < REST_VARIANCE[i]
                {
                    break;
                }
            }
        }
        self.equations.take_step(&step);
        Some(self.equations.excess())
    }

    /// The normal equations of every n-th group of pixels; residuals beyond a share of the contrast have less weight.
    #[inline(always)]
    fn linearise(&mut self, model: &Model<'_>, scale: f32, every: usize) {
        let equations = &mut self.equations;
        equations.clear(TUKEY * scale);
        let groups = self.pixels.groups().iter().step_by(every);
        match (model.n_edges, model.state.is_sharp()) {
            (1, false) => model.linearise::<1, false>(groups, equations),
            (1, true) => model.linearise::<1, true>(groups, equations),
            (2, false) => model.linearise::<2, false>(groups, equations),
            (2, true) => model.linearise::<2, true>(groups, equations),
            (_, true) => model.linearise::<MOST_EDGES, true>(groups, equations),
            (_, false) => model.linearise::<MOST_EDGES, false>(groups, equations),
        }
        // The ground, the last parameter, shows only where more than one edge does.
        equations.finish(if model.n_edges == 1 {
            PARAMETERS - 1
        } else {
            PARAMETERS
        });
    }
}

/// Corners with the covariances that the whitened rows of their derivatives have at this variance of a residual.
#[inline(always)]
fn with_covariance(quad: Quad, rows: &[[Row; 2]; 4], variance: f32) -> Corners {
    let shared = |a: &Row, b: &Row| variance * dot(a, b);
    Corners {
        quad,
        covariance: rows
            .each_ref()
            .map(|[x, y]| [shared(x, x), shared(x, y), shared(y, y)]),
        cross_covariance: CORNER_PAIRS.map(|pair| {
            let [[ax, ay], [bx, by]] = pair.map(|corner| &rows[corner]);
            [
                shared(ax, bx),
                shared(ax, by),
                shared(ay, bx),
                shared(ay, by),
            ]
        }),
    }
}
