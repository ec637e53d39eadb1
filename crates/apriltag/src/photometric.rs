//! Corners from the whole pattern: the picture that a decoded tag must give is fitted to the pixels.
//!
//! In: an image, a decoded tag's upright quad and its code word. Out: corners with covariance, or nothing where the edges
//! alone say more.
//!
//! The picture is black(u, v) + (white(u, v) - black(u, v)) * response(coverage), where coverage is the blurred pattern
//! ([`BlurredPattern`]), black and white are planes over the tag, and response(c) = k c / (1 + (k - 1) c), k = exp(gain), is
//! how a camera's curve, glare and spreading ink let white grow: across a blurred edge it is a shift, as if c were a
//! logistic function of the distance. Gauss-Newton on 18 parameters: the homography (8), the planes (6), the
//! blur's covariance in the image (3), which takes in the lens and straight motion, and the gain. (Least squares on images:
//! Baker & Matthews, Lucas-Kanade 20 years on, IJCV 2004.) The parameters' covariance is that of least squares, made
//! larger where residuals beside each other agree, which noise would not.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes of many arrays, which zipped would not say what they do"
)]

mod blurred_pattern;
mod lanes;
mod normal_equations;
mod pixels;
mod state;

use crate::Image;
use crate::edges::EdgeFit;
use crate::kernels::Kernels;
use crate::quad::Quad;
use crate::reading::Reading;
use blurred_pattern::{BlurredPattern, Optics};
use lanes::{LANES, lane};
use normal_equations::{Equations, Factor, ROUNDING, Rows};
use pixels::{Block, Pixels, weights};
use state::{Inverse, State};

/// Blur for which the pixels are chosen anew, in pixels.
const STRONG_BLUR_PX: f32 = 1.0;

/// Most steps with all pixels.
const MAX_STEPS: usize = 6;

/// After a step that moves no corner farther, the next would not move them by a thousandth of a pixel: each halves the
/// digits that are wrong.
const SETTLED_PX: f32 = 0.03;

/// Residuals in standard deviations of the image's noise up to which the model explains the picture, so that what it says
/// of the corners holds. The noise is known to a third or so; where optics or print are others than the model's, residuals
/// are several times as large.
const EXPLAINED: f32 = 2.0;

/// Where the model does not explain the picture, the share of the edges' variance below which the pattern's must be, so
/// that its corners are taken: the edges need no more than that the border is straight.
const SURER: f32 = 0.15;

/// Residuals that lenses, sharpening and compression leave where nothing is wrong, as a share of the contrast: pixels
/// that stray no further than these are not held to be hidden or lit by something else.
const MODEL_SCALE: f32 = 0.03;

/// The same before the first step, when corners may be a few tenths of a pixel off.
const START_SCALE: f32 = 0.12;

/// Corners, upright, and their covariance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatternFit {
    pub(crate) corners: Quad,
    pub(crate) covariance: [[f32; 3]; 4],
}

/// Fits patterns; keeps its memory between tags.
#[derive(Debug)]
pub(crate) struct PatternFitter {
    pixels: Pixels,
    equations: Equations,
    kernels: Kernels,
}

impl PatternFitter {
    pub(crate) fn new(kernels: Kernels) -> Self {
        Self {
            pixels: Pixels::default(),
            equations: Equations::default(),
            kernels,
        }
    }

    pub(crate) fn fit(
        &mut self,
        image: &Image<'_>,
        reading: &Reading,
        edges: &EdgeFit,
        noise_sigma: f32,
    ) -> Option<PatternFit> {
        let pattern = BlurredPattern::new(reading.family, reading.found.id);
        let mut state = State::start(&edges.quad, reading)?;
        self.pixels.choose(image, &pattern, &state);
        self.step(
            &pattern,
            &mut state,
            self.pixels.first_stride(),
            START_SCALE,
        )?;
        if state.blur_px() > STRONG_BLUR_PX {
            self.pixels.choose(image, &pattern, &state);
        }
        let factor = self.settle(&pattern, &mut state)?;
        let covariance =
            state.corner_covariances(&self.equations.covariance(&factor, &self.kernels));
        let share = mean_variance(&covariance) / mean_variance(&edges.covariance);
        let explained = self.equations.residual_scale() < EXPLAINED * noise_sigma.max(ROUNDING);
        let trusted = explained || share < SURER;
        let plausible = trusted && state.is_plausible(&edges.quad);
        plausible.then(|| PatternFit {
            corners: state.corners(),
            covariance,
        })
    }

    /// Steps with all pixels until the corners rest; what strays much from what is usual then counts less.
    fn settle(&mut self, pattern: &BlurredPattern, state: &mut State) -> Option<Factor> {
        let mut settled = None;
        for _ in 0..MAX_STEPS {
            let scale = (self.equations.residual_scale() / state.contrast()).max(MODEL_SCALE);
            let (factor, motion) = self.step(pattern, state, 1, scale)?;
            settled = Some(factor);
            if motion < SETTLED_PX {
                break;
            }
        }
        settled
    }

    /// One Gauss-Newton step with every so many blocks of pixels, those straying by more than a share of the contrast counting less;
    /// the residuals are left as they should be after the step. Returns how far it moved a corner, in pixels.
    fn step(
        &mut self,
        pattern: &BlurredPattern,
        state: &mut State,
        stride: usize,
        scale: f32,
    ) -> Option<(Factor, f32)> {
        self.linearise(pattern, state, stride, scale * state.contrast())?;
        let factor = self.equations.factorise()?;
        let step = factor.solve(&self.equations.right());
        state.step(&step)?;
        self.equations.take_step(&step, &self.kernels);
        Some((factor, state.corner_motion(&step)))
    }

    /// Derivatives and residuals of every so many blocks of pixels; those that stray by more than `scale` allows count less.
    fn linearise(
        &mut self,
        pattern: &BlurredPattern,
        state: &State,
        stride: usize,
        scale: f32,
    ) -> Option<()> {
        let model = Model {
            pattern,
            state,
            reach: self.pixels.reach,
            inverse: state.inverse()?,
            optics: Optics::of(state, pattern),
        };
        let (blocks, equations) = (self.pixels.blocks().step_by(stride), &mut self.equations);
        equations.clear();
        self.kernels.run(
            #[inline(always)]
            || {
                for (block, n) in blocks {
                    if let Some(rows) = equations.next() {
                        model.linearise(block, n, scale, rows);
                    }
                }
            },
        );
        self.equations.multiply(&self.kernels);
        self.equations.add_priors(state);
        self.equations.is_determined().then_some(())
    }
}

/// What pixels should show.
struct Model<'a> {
    pattern: &'a BlurredPattern,
    state: &'a State,
    /// Places farther from the square's middle count nothing.
    reach: f32,
    inverse: Inverse,
    optics: Optics,
}

impl Model<'_> {
    /// The rows of the block's first `n` pixels.
    #[inline(always)]
    fn linearise(&self, block: &Block, n: usize, scale: f32, rows: Rows<'_>) {
        let places = self.inverse.places(&block.x, &block.y);
        let coverage = self.pattern.at(&places, &self.optics);
        let greys = self.state.greys(&places, &coverage);
        let weights = weights(&block.grey, &greys, scale);
        for i in 0..LANES {
            let within = places.u[i].abs().max(places.v[i].abs()) <= self.reach;
            rows.roots[i] = if within { weights[i].sqrt() } else { 0.0 };
        }
        for lane in (n..LANES).map(lane) {
            rows.roots[lane] = 0.0;
        }
        for i in 0..LANES {
            rows.residuals[i] = rows.roots[i] * (block.grey[i] - greys[i]);
        }
        let pixels = (&block.x, &block.y);
        self.state
            .derivatives(&places, &coverage, pixels, rows.roots, rows.columns);
    }
}

/// Of all corners along either axis.
fn mean_variance(covariance: &[[f32; 3]; 4]) -> f32 {
    covariance.iter().map(|[xx, _, yy]| xx + yy).sum::<f32>() / 8.0
}
