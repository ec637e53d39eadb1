//! Corners from the whole pattern: the picture that a decoded tag must give is fitted to the pixels.
//!
//! In: an image, a decoded tag's upright quad and its code word. Out: corners with covariance, or nothing where the edges
//! alone say more.
//!
//! The picture is light(u, v) * (black + (white - black) * response(coverage)), where coverage is the blurred pattern
//! ([`Pattern`]), light is a plane over the tag that is 1 at its middle, and response(c) = c + gain c (1 - c) is how a
//! camera's curve, glare and spreading ink let white grow. Gauss-Newton on 18 parameters: the homography (8), black, white,
//! the light's slope (2), the blur's covariance (3), which takes in the lens and straight motion, its halo, which takes in
//! sharpening, the gain, and how much blur mixes in of what the image shows beyond the ring. (Least squares on images: Baker
//! & Matthews, Lucas-Kanade 20 years on, IJCV 2004.) First with a few of the pixels, then with all of them, mostly once. The
//! parameters' covariance is that of least squares, made larger where residuals beside each other agree, which noise would
//! not.
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
use crate::kernels::vectorised;
use crate::quad::Quad;
use crate::reading::Reading;
use equations::{Equations, Factor, Vector};
use model::{FAR_APART, Model, TUKEY};
use pattern::Pattern;
use pixels::{Pixels, Tag};
use sextant_geometry::Lens;
use state::State;
use straightened::Straightened;

/// Steps of one kind.
struct Stage {
    /// One of so many groups of pixels is looked at.
    every: usize,
    most_steps: usize,
    /// After a step that moves no corner farther and leaves the blur, no more are taken.
    rest_px: f32,
    /// By how much farther pixels may stray where too few agree.
    wider: f32,
    /// Standard deviation of the halo where nothing is known.
    usual_halo: f32,
}

impl Stage {
    /// With a few of the pixels: after such a step one with all of them is likely to settle it. Halos are held small as long
    /// as the blur is not known: one of -1 makes the same of it as twice the width, from where the fit would not come back.
    fn first(every: usize) -> Self {
        Self {
            every,
            most_steps: 5,
            rest_px: 0.15,
            wider: 2.0,
            usual_halo: 0.1,
        }
    }

    /// With all pixels: after such a step the next would hardly move corners by a thousandth of a pixel, as each doubles the
    /// digits that are right.
    const LAST: Self = Self {
        every: 1,
        most_steps: 6,
        rest_px: 0.06,
        wider: 1.0,
        usual_halo: 0.3,
    };
}

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

/// Share from which it may be the tag's at all. Of a tag that is hidden in part, more is seen.
const LEAST_OF_IT: f32 = 0.25;

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
#[derive(Debug, Default)]
pub(crate) struct PatternFitter {
    pixels: Pixels,
    equations: Equations,
    /// What bends the tags' edges, if it is known.
    pub(crate) lens: Option<Lens>,
}

impl PatternFitter {
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
        let tag = Tag {
            image,
            outline: model::outline(&pattern, &state),
            contrast: state.contrast(),
            edges_px: pattern.edges_px(state.size_px()),
            straightened,
        };
        self.choose(&tag);
        let (factor, excess) = self.settle(&tag, &pattern, &mut state)?;
        let rounding = (ROUNDING / state.contrast()).powi(2);
        let variance = self.equations.residual_variance().max(rounding) * excess;
        let covariances = state.corner_covariances(&factor);
        let fit = PatternFit {
            corners: state.unshaded_corners()?,
            covariance: covariances.map(|corner| corner.map(|value| value * variance)),
        };
        let real = noise_sigma > 0.0 || state.blur_px() > LEAST_BLUR_PX;
        let surer = mean_variance(&fit.covariance) < mean_variance(&edges.covariance);
        let most_noises = if surer { TOLD } else { EXPLAINED };
        let residual = self.equations.residual_variance().sqrt() * state.contrast();
        let noises = residual / noise_sigma.max(ROUNDING);
        let share = self.equations.share();
        let farthest = if noises < EXPLAINED && share > MOST_OF_IT {
            state.size_px() / 2.0
        } else {
            pattern.module_px(state.size_px()) + 0.5
        };
        let explained = noises < most_noises && share > LEAST_OF_IT;
        if !(real && explained && state.is_plausible(&start, farthest)) {
            return None;
        }
        match straightened {
            Some(straightened) => fit.seen_through(straightened),
            None => Some(fit),
        }
    }

    fn choose(&mut self, tag: &Tag<'_>) {
        let pixels = &mut self.pixels;
        vectorised(
            #[inline(always)]
            || pixels.choose(tag),
        );
    }

    /// Steps with a few of the pixels until the corners are about where they belong, then with all until they rest; what
    /// strays much from what is usual then counts less. Where too few of the few agree, corners are farther off than was
    /// thought. Returns the factor of the last step's matrix and by how much
    /// variances are larger than it says.
    fn settle(
        &mut self,
        tag: &Tag<'_>,
        pattern: &Pattern,
        state: &mut State,
    ) -> Option<(Factor, f32)> {
        const ENOUGH_GROUPS: usize = 10;
        let few = (self.pixels.groups().len() / ENOUGH_GROUPS).max(1);
        let (mut scale, mut last) = (START_SCALE, None);
        for stage in [Stage::first(few), Stage::LAST] {
            let model = Model::new(pattern, state, scale)?;
            if model.seen_modules() > FAR_APART {
                self.pixels.look_beyond(tag, &model);
            }
            for _ in 0..stage.most_steps {
                last = self.step(pattern, state, &stage, scale);
                let Some((step, _)) = &last else {
                    scale *= stage.wider;
                    continue;
                };
                scale = self.equations.residual_variance().sqrt().max(MODEL_SCALE);
                if state.corner_motion(step) < stage.rest_px && !State::blurs(step) {
                    break;
                }
            }
        }
        let (step, factor) = last?;
        let equations = &mut self.equations;
        let excess = vectorised(
            #[inline(always)]
            || {
                equations.take_step(&step);
                equations.excess()
            },
        );
        Some((factor, excess))
    }

    /// One Gauss-Newton step, pixels straying by more than a share of the contrast counting less.
    /// Returns the step and the factor of its matrix.
    fn step(
        &mut self,
        pattern: &Pattern,
        state: &mut State,
        stage: &Stage,
        scale: f32,
    ) -> Option<(Vector, Factor)> {
        let model = Model::new(pattern, state, scale)?;
        let (pixels, equations) = (&self.pixels, &mut self.equations);
        equations.clear(TUKEY * scale);
        vectorised(
            #[inline(always)]
            || match (model.seen_modules(), state.is_sharp()) {
                (..FAR_APART, true) => linearise::<1, true>(&model, pixels, stage.every, equations),
                (_, true) => linearise::<3, true>(&model, pixels, stage.every, equations),
                (..FAR_APART, _) => linearise::<1, false>(&model, pixels, stage.every, equations),
                (..1.5, _) => linearise::<3, false>(&model, pixels, stage.every, equations),
                _ => linearise::<5, false>(&model, pixels, stage.every, equations),
            },
        );
        equations.finish();
        if !equations.is_determined() {
            return None;
        }
        let priors = state.priors(stage.usual_halo)?;
        let (step, factor) = vectorised(
            #[inline(always)]
            || equations.solve(&priors),
        );
        state.step(&step)?;
        Some((step, factor))
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
