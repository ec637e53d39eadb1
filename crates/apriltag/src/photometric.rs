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
//!
//! The corners are taken where residuals are no more than the image's noise; elsewhere only where they are much surer than
//! those of the edges.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over lanes of many arrays, which zipped would not say what they do"
)]

mod blurred_pattern;
mod edge;
mod factor;
mod group_sums;
mod lanes;
mod normal_equations;
mod pixels;
mod state;
mod straightened;

use crate::Image;
use crate::edges::EdgeFit;
use crate::kernels::Kernels;
use crate::quad::Quad;
use crate::reading::Reading;
use blurred_pattern::{BlurredPattern, Optics};
use factor::Factor;
use group_sums::Rows;
use lanes::LANES;
use normal_equations::{Equations, ROUNDING};
use pixels::{Block, GROUP, Pixels, weights};
use sextant_geometry::Lens;
use state::{Inverse, State};
use straightened::Straightened;

/// Blur for which the pixels are chosen anew, in pixels.
const STRONG_BLUR_PX: f32 = 1.0;

/// Most steps with all pixels.
const MAX_STEPS: usize = 6;

/// Most steps with a few pixels of each group.
const MAX_FIRST_STEPS: usize = 3;

/// After a step with a few pixels that moves no corner farther, one with all of them is likely to settle it.
const NEAR_PX: f32 = 0.15;

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

/// Pictures with less blur and no noise are no camera's: what they do between pixels is not what the model says, and is only believed
/// where it explains them.
const LEAST_BLUR_PX: f32 = 0.1;

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

impl PatternFit {
    /// The same where the lens shows it.
    fn seen_through(self, straightened: &Straightened) -> Option<Self> {
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|i| straightened.corner(self.corners[i], self.covariance[i]));
        let corners = [a?, b?, c?, d?];
        Some(Self {
            corners: corners.map(|(corner, _)| corner),
            covariance: corners.map(|(_, covariance)| covariance),
        })
    }
}

/// Fits patterns; keeps its memory between tags.
#[derive(Debug)]
pub(crate) struct PatternFitter {
    pixels: Pixels,
    equations: Equations,
    kernels: Kernels,
    /// What bends the tags' edges, if it is known.
    pub(crate) lens: Option<Lens>,
}

impl PatternFitter {
    pub(crate) fn new(kernels: Kernels) -> Self {
        Self {
            pixels: Pixels::default(),
            equations: Equations::default(),
            kernels,
            lens: None,
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
        let lens = self.lens.as_ref();
        let straightened = lens.and_then(|lens| Straightened::around(lens, &edges.quad));
        let straightened = straightened.as_ref();
        let start = match straightened {
            Some(straightened) => straightened.quad(&edges.quad)?,
            None => edges.quad,
        };
        let mut state = State::start(&start, reading)?;
        self.choose(image, &pattern, &state, straightened);
        self.approach(&pattern, &mut state)?;
        if state.blur_px() > STRONG_BLUR_PX {
            self.choose(image, &pattern, &state, straightened);
        }
        let factor = self.settle(&pattern, &mut state)?;
        let variance = self.equations.variance(&factor, &self.kernels);
        let fit = PatternFit {
            corners: state.corners(),
            covariance: state
                .corner_covariances(&factor)
                .map(|corner| corner.map(|value| value * variance)),
        };
        let share = mean_variance(&fit.covariance) / mean_variance(&edges.covariance);
        let explained = self.equations.residual_scale() < EXPLAINED * noise_sigma.max(ROUNDING);
        let real = noise_sigma > 0.0 || state.blur_px() > LEAST_BLUR_PX;
        let trusted = explained || share < SURER && real;
        if !trusted || !state.is_plausible(&start) {
            return None;
        }
        match straightened {
            Some(straightened) => fit.seen_through(straightened),
            None => Some(fit),
        }
    }

    fn choose(
        &mut self,
        image: &Image<'_>,
        pattern: &BlurredPattern,
        state: &State,
        straightened: Option<&Straightened>,
    ) {
        let pixels = &mut self.pixels;
        self.kernels.run(
            #[inline(always)]
            || pixels.choose(image, pattern, state, straightened),
        );
    }

    /// Steps with a few pixels of each group until the corners are about where they belong.
    fn approach(&mut self, pattern: &BlurredPattern, state: &mut State) -> Option<()> {
        let n_rows = self.pixels.first_rows();
        for _ in 0..MAX_FIRST_STEPS {
            let (_, motion) = self.step(pattern, state, n_rows, START_SCALE)?;
            if motion < NEAR_PX {
                break;
            }
        }
        Some(())
    }

    /// Steps with all pixels until the corners rest; what strays much from what is usual then counts less.
    fn settle(&mut self, pattern: &BlurredPattern, state: &mut State) -> Option<Factor> {
        let mut settled = None;
        for _ in 0..MAX_STEPS {
            let scale = (self.equations.residual_scale() / state.contrast()).max(MODEL_SCALE);
            let (factor, motion) = self.step(pattern, state, self.pixels.all_rows(), scale)?;
            settled = Some(factor);
            if motion < SETTLED_PX {
                break;
            }
        }
        settled
    }

    /// One Gauss-Newton step with the first `n_rows` pixels of each group, those straying by more than a share of the
    /// contrast counting less; the residuals are left as they should be after the step. Returns how far it moved a corner,
    /// in pixels.
    fn step(
        &mut self,
        pattern: &BlurredPattern,
        state: &mut State,
        n_rows: usize,
        scale: f32,
    ) -> Option<(Factor, f32)> {
        self.linearise(pattern, state, n_rows, scale * state.contrast())?;
        let equations = &self.equations;
        let (factor, step) = self.kernels.run(
            #[inline(always)]
            || {
                let factor = equations.factorise()?;
                let step = factor.solve(&equations.right());
                Some((factor, step))
            },
        )?;
        state.step(&step)?;
        self.equations.take_step(&step);
        Some((factor, state.corner_motion(&step)))
    }

    /// The equations of the first `n_rows` pixels of each group; those that stray by more than `scale` allows count less.
    fn linearise(
        &mut self,
        pattern: &BlurredPattern,
        state: &State,
        n_rows: usize,
        scale: f32,
    ) -> Option<()> {
        let inverse = state.inverse()?;
        let (pixels, equations) = (&self.pixels, &mut self.equations);
        equations.clear();
        self.kernels.run(
            #[inline(always)]
            || {
                let model = Model {
                    pattern,
                    state,
                    reach: pixels.reach,
                    optics: Optics::of(state, &inverse, pattern),
                    inverse,
                };
                for block in pixels.blocks() {
                    equations.add(
                        n_rows,
                        #[inline(always)]
                        |rows| model.linearise(block, n_rows, scale, rows),
                    );
                }
                equations.finish();
            },
        );
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
    /// The block's first `n` rows.
    #[inline(always)]
    fn linearise(&self, block: &Block, n: usize, scale: f32, rows: &mut Rows) {
        for row in 0..n.min(GROUP) {
            let places = self.inverse.places(&block.x[row], &block.y[row]);
            let coverage = self.pattern.at(&places, &self.optics);
            let greys = self.state.greys(&places, &coverage);
            let weights = weights(&block.grey[row], &greys, scale);
            let (mut roots, mut residuals) = ([0.0; LANES], [0.0; LANES]);
            for i in 0..LANES {
                let within = places.u[i].abs().max(places.v[i].abs()) <= self.reach;
                let weight = if within {
                    weights[i] * block.present[row][i]
                } else {
                    0.0
                };
                rows.weights[i] += weight;
                rows.places[0][i] += weight * places.u[i];
                rows.places[1][i] += weight * places.v[i];
                roots[i] = weight.sqrt();
                rows.roots[i] += roots[i];
                residuals[i] = block.grey[row][i] - greys[i];
            }
            self.state.linearise(
                &places,
                &coverage,
                &residuals,
                &roots,
                &mut rows.columns[row],
            );
        }
    }
}

/// Of all corners along either axis.
fn mean_variance(covariance: &[[f32; 3]; 4]) -> f32 {
    covariance.iter().map(|[xx, _, yy]| xx + yy).sum::<f32>() / 8.0
}
