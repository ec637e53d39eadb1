//! Corners from the whole pattern: the picture that a decoded tag must give is fitted to the pixels.
//!
//! In: an image, a decoded tag's upright quad and its code word. Out: corners with covariance, or nothing where the edges
//! alone say more.
//!
//! The picture is light(u, v) * (black + (white - black) * response(coverage)), where coverage is the blurred pattern
//! ([`Pattern`]), light is a plane over the tag that is 1 at its middle, and response(c) = c + gain c (1 - c) is how a
//! camera's curve, glare and spreading ink let white grow. Gauss-Newton on 17 parameters: the homography (8), black, white,
//! the light's slope (2), the blur's covariance (3), which takes in the lens and straight motion, its halo, which takes in
//! sharpening, and the gain. (Least squares on images: Baker & Matthews, Lucas-Kanade 20 years on, IJCV 2004.) First with a
//! few of the pixels, then with all of them, mostly once. The parameters' covariance is that of least squares, made larger
//! where residuals beside each other agree, which noise would not.
//!
//! The corners are taken where residuals are no more than the image's noise, and where they are some times as large only if
//! they are surer than those of the edges.

#![allow(
    clippy::needless_range_loop,
    reason = "loops over many arrays at once, which zipped would not say what they do"
)]

mod edge;
mod equations;
mod model;
mod pattern;
mod pixels;
mod state;
mod straightened;

use crate::Image;
use crate::edges::EdgeFit;
use crate::kernels::Kernels;
use crate::quad::Quad;
use crate::reading::Reading;
use equations::{Equations, Matrix, Vector};
use model::{Model, TUKEY};
use pattern::Pattern;
use pixels::{Pixels, Tag};
use sextant_geometry::Lens;
use state::State;
use straightened::Straightened;

/// Most steps with all pixels.
const MAX_STEPS: usize = 6;

/// Most steps with a few of the pixels.
const MAX_FIRST_STEPS: usize = 3;

/// After a step with a few pixels that moves no corner farther, one with all of them is likely to settle it.
const NEAR_PX: f32 = 0.15;

/// After a step that moves no corner farther, the next would hardly move them by a thousandth of a pixel: each doubles the
/// digits that are right.
const SETTLED_PX: f32 = 0.06;

/// Residuals in standard deviations of the image's noise up to which the model explains the picture, so that what it says
/// of the corners holds. The noise is known to a third or so.
const EXPLAINED: f32 = 2.0;

/// The same up to which its covariance says what the corners are worth, and the surer ones of both are taken: aliasing,
/// sharpening and compression leave several times the noise that flat parts show. Where print or optics are others than the
/// model's, residuals are ten times as large and more; the edges need no more than that the border is straight.
const TOLD: f32 = 8.0;

/// Share of the pixels' weight from which a picture explained down to the noise is the tag's wherever its corners seemed to
/// be: beside a ground as dark as its border, a corner is easily taken for one that lies modules away.
const MOST_OF_IT: f32 = 0.5;

/// Pictures with less blur and no noise are no camera's: what they do between pixels is not what the model says.
const LEAST_BLUR_PX: f32 = 0.25;

/// Residuals that lenses, sharpening and compression leave where nothing is wrong, as a share of the contrast: pixels
/// that stray no further than these are not held to be hidden or lit by something else.
const MODEL_SCALE: f32 = 0.03;

/// The same before the first step, when corners may be a few tenths of a pixel off.
const START_SCALE: f32 = 0.12;

/// Standard deviation of what rounding to whole grey levels adds.
const ROUNDING: f32 = 0.29;

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
        let pattern = Pattern::new(reading.family, reading.found.id);
        let lens = self.lens.as_ref();
        let straightened = lens.and_then(|lens| Straightened::around(lens, &edges.quad));
        let straightened = straightened.as_ref();
        let start = match straightened {
            Some(straightened) => straightened.quad(&edges.quad)?,
            None => edges.quad,
        };
        let mut state = State::start(&start, reading)?;
        self.choose(&Tag {
            image,
            outline: model::outline(&pattern, &state)
                .map(|place| straightened.map_or(place, |lens| lens.pixel(place).unwrap_or(place))),
            contrast: state.contrast(),
            edges_px: pattern.edges_px(state.size_px()),
            straightened,
        });
        let (inverse, excess) = self.settle(&pattern, &mut state)?;
        let rounding = (ROUNDING / state.contrast()).powi(2);
        let variance = self.equations.residual_variance().max(rounding) * excess;
        let covariances = state.corner_covariances(&inverse);
        let fit = PatternFit {
            corners: state.unshaded_corners()?,
            covariance: covariances.map(|corner| corner.map(|value| value * variance)),
        };
        let real = noise_sigma > 0.0 || state.blur_px() > LEAST_BLUR_PX;
        let surer = mean_variance(&fit.covariance) < mean_variance(&edges.covariance);
        let most_noises = if surer { TOLD } else { EXPLAINED };
        let residual = self.equations.residual_variance().sqrt() * state.contrast();
        let noises = residual / noise_sigma.max(ROUNDING);
        let farthest = if noises < EXPLAINED && self.equations.share() > MOST_OF_IT {
            state.size_px() / 2.0
        } else {
            pattern.module_px(state.size_px()) + 0.5
        };
        if !(real && noises < most_noises && state.is_plausible(&start, farthest)) {
            return None;
        }
        match straightened {
            Some(straightened) => fit.seen_through(straightened),
            None => Some(fit),
        }
    }

    fn choose(&mut self, tag: &Tag<'_>) {
        let pixels = &mut self.pixels;
        self.kernels.run(
            #[inline(always)]
            || pixels.choose(tag),
        );
    }

    /// Steps with a few of the pixels until the corners are about where they belong, then with all until they rest; what
    /// strays much from what is usual then counts less. Returns the inverse of the last step's matrix and by how much
    /// variances are larger than it says.
    fn settle(&mut self, pattern: &Pattern, state: &mut State) -> Option<(Matrix, f32)> {
        const ENOUGH_GROUPS: usize = 10;
        let few = (self.pixels.groups().len() / ENOUGH_GROUPS).max(1);
        let (mut scale, mut last) = (START_SCALE, None);
        for (every, most_steps, rest_px) in
            [(few, MAX_FIRST_STEPS, NEAR_PX), (1, MAX_STEPS, SETTLED_PX)]
        {
            for _ in 0..most_steps {
                let (step, inverse) = self.step(pattern, state, every, scale)?;
                scale = self.equations.residual_variance().sqrt().max(MODEL_SCALE);
                let rests = state.corner_motion(&step) < rest_px;
                last = Some((step, inverse));
                if rests {
                    break;
                }
            }
        }
        let (step, inverse) = last?;
        let equations = &mut self.equations;
        let excess = self.kernels.run(
            #[inline(always)]
            || {
                equations.take_step(&step);
                equations.excess()
            },
        );
        Some((inverse, excess))
    }

    /// One Gauss-Newton step with every so many groups, pixels straying by more than a share of the contrast counting less.
    /// Returns the step and the inverse of its matrix.
    fn step(
        &mut self,
        pattern: &Pattern,
        state: &mut State,
        every: usize,
        scale: f32,
    ) -> Option<(Vector, Matrix)> {
        let model = Model::new(pattern, state, scale)?;
        let (pixels, equations) = (&self.pixels, &mut self.equations);
        equations.clear(TUKEY * scale);
        self.kernels.run(
            #[inline(always)]
            || match (model.seen_modules(), state.is_sharp()) {
                (..0.5, true) => linearise::<1, true>(&model, pixels, every, equations),
                (_, true) => linearise::<3, true>(&model, pixels, every, equations),
                (..0.5, _) => linearise::<1, false>(&model, pixels, every, equations),
                (..1.5, _) => linearise::<3, false>(&model, pixels, every, equations),
                _ => linearise::<5, false>(&model, pixels, every, equations),
            },
        );
        equations.finish(&self.kernels);
        if !equations.is_determined() {
            return None;
        }
        let priors = state.priors()?;
        let (step, inverse) = self.kernels.run(
            #[inline(always)]
            || equations.solve(&priors),
        )?;
        state.step(&step)?;
        Some((step, inverse))
    }
}

#[inline(always)]
fn linearise<const EDGES: usize, const SHARP: bool>(
    model: &Model<'_>,
    pixels: &Pixels,
    every: usize,
    equations: &mut Equations,
) {
    for group in pixels.groups().step_by(every) {
        model.linearise::<EDGES, SHARP>(&group, equations);
    }
}

/// Of all corners along either axis.
fn mean_variance(covariance: &[[f32; 3]; 4]) -> f32 {
    covariance.iter().map(|[xx, _, yy]| xx + yy).sum::<f32>() / 8.0
}
