//! Corners from the whole pattern: the picture that a decoded tag must give is fitted to the pixels.
//!
//! In: an image, a decoded tag's upright quad and its code word. Out: corners with covariance, or nothing where the edges
//! alone say more.
//!
//! The picture is black(u, v) + (white(u, v) - black(u, v)) * response(coverage), where coverage is the blurred pattern
//! ([`BlurredPattern`]), black and white are planes over the tag, and response(c) = c + gain c (1 - c) is how a camera's
//! curve, glare and spreading ink let white grow. Gauss-Newton on 18 parameters: the homography (8), the planes (6), the
//! blur's covariance in the image (3), which takes in the lens and straight motion, and the gain. The derivatives are
//! taken twice, at the start and after the first step, as in Baker & Matthews, Lucas-Kanade 20 years on (IJCV 2004);
//! further steps only look at what is left. The parameters' covariance is that of least squares, made larger where
//! residuals beside each other agree, which noise would not.

mod blurred_pattern;
mod normal_equations;
mod pixels;
mod state;

use crate::Image;
use crate::edges::EdgeFit;
use crate::kernels::Kernels;
use crate::quad::Quad;
use crate::reading::Reading;
use blurred_pattern::{BlurredPattern, Optics};
use normal_equations::{Equations, Factor};
use pixels::{MAX_PIXELS, Pixels};
use state::State;

/// Most steps after the derivatives are fixed.
const MAX_STEPS: usize = 4;

/// Corners that move less than this have settled, in pixels.
const SETTLED_PX: f32 = 0.001;

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
        let mut equations = Equations::default();
        equations.make_room(MAX_PIXELS);
        Self {
            pixels: Pixels::default(),
            equations,
            kernels,
        }
    }

    pub(crate) fn fit(
        &mut self,
        image: &Image<'_>,
        reading: &Reading,
        edges: &EdgeFit,
    ) -> Option<PatternFit> {
        let pattern = BlurredPattern::new(reading.family, reading.found.id);
        let mut state = State::start(&edges.quad, reading)?;
        self.pixels.choose(image, &pattern, &state);
        let first_half = self.pixels.len() / 2;
        self.linearise(&pattern, &state, first_half, START_SCALE * state.contrast())?;
        state.step(
            &self
                .equations
                .factorise(&self.kernels)?
                .solve(&self.equations.right(&self.kernels)),
        )?;

        let scale = self
            .equations
            .residual_scale()
            .max(MODEL_SCALE * state.contrast());
        self.linearise(&pattern, &state, self.pixels.len(), scale)?;
        let factor = self.equations.factorise(&self.kernels)?;
        self.settle(&pattern, &mut state, &factor)?;

        let covariance = state.corner_covariances(&self.equations.covariance(&factor));
        let better = state.is_plausible(&edges.quad)
            && mean_variance(&covariance) < mean_variance(&edges.covariance);
        better.then(|| PatternFit {
            corners: state.corners(),
            covariance,
        })
    }

    /// Derivatives and residuals of the first `n` pixels; those that stray by more than `scale` allows count less.
    fn linearise(
        &mut self,
        pattern: &BlurredPattern,
        state: &State,
        n: usize,
        scale: f32,
    ) -> Option<()> {
        let (inverse, optics) = (state.inverse()?, Optics::of(state, pattern));
        self.equations.clear();
        for pixel in &self.pixels[..n] {
            let place = inverse.place(pixel.point);
            let coverage = pattern.at(&place, &optics);
            let (jacobian, grey) = state.linearise(&place, &coverage, pixel.point);
            let weight = pixel.weight(grey, scale);
            self.equations.push(
                &jacobian,
                pixel.grey - grey,
                weight,
                pattern.nearest_crossing(&place),
            );
        }
        self.equations.add_priors(state);
        self.equations.is_determined().then_some(())
    }

    /// Steps with the same derivatives until the corners rest.
    fn settle(
        &mut self,
        pattern: &BlurredPattern,
        state: &mut State,
        factor: &Factor,
    ) -> Option<()> {
        for _ in 0..MAX_STEPS {
            let step = factor.solve(&self.equations.right(&self.kernels));
            state.step(&step)?;
            if state.corner_motion(&step) < SETTLED_PX {
                break;
            }
            let (inverse, optics) = (state.inverse()?, Optics::of(state, pattern));
            for (i, pixel) in self.pixels.iter().enumerate() {
                let place = inverse.place(pixel.point);
                let grey = state.grey(&place, pattern.at(&place, &optics).value);
                self.equations.set_residual(i, pixel.grey - grey);
            }
            self.equations.add_priors(state);
        }
        Some(())
    }
}

/// Of all corners along either axis.
fn mean_variance(covariance: &[[f32; 3]; 4]) -> f32 {
    covariance.iter().map(|[xx, _, yy]| xx + yy).sum::<f32>() / 8.0
}
