//! Corners from the whole pattern: the picture that a decoded tag must give is fitted to the pixels.
//!
//! In: an image, a decoded tag's upright quad and its code word. Out: corners with covariance, or nothing where the
//! picture explains the pixels no better than the edges' corners do.
//!
//! The picture is black(u, v) + (white(u, v) - black(u, v)) * response(coverage), where coverage is the blurred pattern
//! ([`BlurredPattern`]), black and white are planes over the tag, and response(c) = c + gain c (1 - c) is how a camera's
//! curve, glare and spreading ink let white grow. Gauss-Newton on 18 parameters: the homography (8), the planes (6), the
//! blur's covariance in the image (3), which takes in the lens and straight motion, and the gain.
//! (Baker & Matthews, Lucas-Kanade 20 years on, IJCV 2004; the parameters' covariance is that of least
//! squares, made larger where residuals beside each other agree, which noise would not.)

mod blurred_pattern;
mod normal_equations;

use crate::Image;
use crate::edges::EdgeFit;
use crate::homography::Homography;
use crate::quad::{Point, Quad, mean_edge};
use crate::reading::Reading;
use blurred_pattern::{BlurredPattern, Coverage};
use normal_equations::{NormalEquations, PARAMETERS};

/// Most iterations; from an edge fit two or three suffice.
const MAX_ITERATIONS: usize = 6;

/// Corners that move less than this have settled, in pixels.
const SETTLED_PX: f32 = 0.002;

/// Standard deviation of the blur where nothing is known: a good lens.
const USUAL_BLUR_PX: f32 = 0.6;

/// Residuals that lenses, sharpening and compression leave where nothing is wrong, as a share of the contrast: pixels
/// that stray no further than these are not held to be hidden or lit by something else.
const MODEL_SCALE: f32 = 0.03;

/// Most pixels of a tag's bounding box that are looked at.
const MAX_PIXELS: f32 = 3000.0;

/// Corners, upright, and their covariance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatternFit {
    pub(crate) corners: Quad,
    pub(crate) covariance: [[f32; 3]; 4],
}

/// Everything that is fitted.
#[derive(Clone, Copy, Debug)]
struct State {
    /// From the square -1..1 (u right, v down) to pixels.
    homography: Homography,
    /// Grey = p0 + p1 u + p2 v.
    black: [f32; 3],
    white: [f32; 3],
    /// Covariance of the blur in the image: xx, xy, yy.
    blur: [f32; 3],
    /// Curvature of the response to white's share.
    gain: f32,
}

pub(crate) fn fit(image: &Image<'_>, reading: &Reading, edges: &EdgeFit) -> Option<PatternFit> {
    let pattern = BlurredPattern::new(reading.family, reading.found.id);
    let mut state = State::start(&edges.quad, reading)?;
    let mut scale = f32::INFINITY;
    let mut equations = NormalEquations::default();
    for _ in 0..MAX_ITERATIONS {
        equations = accumulate(image, &pattern, &state, scale)?;
        scale = equations
            .residual_scale()
            .max(MODEL_SCALE * (state.white[0] - state.black[0]));
        let step = equations.solve()?;
        state.step(&step);
        if !state.is_plausible(&edges.quad) {
            return None;
        }
        if state.corner_motion(&step) < SETTLED_PX {
            break;
        }
    }
    let covariance = state.corner_covariances(&equations.covariance()?);
    let better = mean_variance(&covariance) < mean_variance(&edges.covariance);
    better.then(|| PatternFit {
        corners: state.corners(),
        covariance,
    })
}

/// Of all corners along either axis.
fn mean_variance(covariance: &[[f32; 3]; 4]) -> f32 {
    covariance.iter().map(|[xx, _, yy]| xx + yy).sum::<f32>() / 8.0
}

/// Corners of the square in its own coordinates.
const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

impl State {
    fn start(quad: &Quad, reading: &Reading) -> Option<Self> {
        Some(Self {
            homography: Homography::centred_square_to_quad(quad)?,
            black: [reading.black, 0.0, 0.0],
            white: [reading.white, 0.0, 0.0],
            blur: [USUAL_BLUR_PX.powi(2), 0.0, USUAL_BLUR_PX.powi(2)],
            gain: 0.0,
        })
    }

    fn step(&mut self, step: &[f32; PARAMETERS]) {
        for (value, change) in self.homography.m.iter_mut().zip(&step[..8]) {
            *value += change;
        }
        for (value, change) in self
            .black
            .iter_mut()
            .chain(&mut self.white)
            .chain(&mut self.blur)
            .chain([&mut self.gain])
            .zip(&step[8..])
        {
            *value += change;
        }
        const LEAST: f32 = 0.05 * 0.05;
        const MOST: f32 = 4.0 * 4.0;
        self.gain = self.gain.clamp(-0.8, 0.8);
        self.blur[0] = self.blur[0].clamp(LEAST, MOST);
        self.blur[2] = self.blur[2].clamp(LEAST, MOST);
        let limit = 0.9 * (self.blur[0] * self.blur[2]).sqrt();
        self.blur[1] = self.blur[1].clamp(-limit, limit);
    }

    fn corners(&self) -> Quad {
        CORNERS.map(|[u, v]| self.homography.apply(u, v))
    }

    /// Every corner stays in the neighbourhood that the edges leave open, and white is brighter than black.
    fn is_plausible(&self, start: &Quad) -> bool {
        let limit = 0.5 + 0.03 * mean_edge(start);
        let near = |(a, b): (&Point, &Point)| (a[0] - b[0]).hypot(a[1] - b[1]) < limit;
        self.corners().iter().zip(start).all(near) && self.white[0] > self.black[0]
    }

    fn corner_motion(&self, step: &[f32; PARAMETERS]) -> f32 {
        let motion = |corner: Point| {
            let [x, y] = self.homography.jacobian(corner);
            let dot = |row: [f32; 8]| row.iter().zip(step).map(|(a, b)| a * b).sum::<f32>();
            dot(x).hypot(dot(y))
        };
        CORNERS.into_iter().map(motion).fold(0.0, f32::max)
    }

    fn corner_covariances(&self, covariance: &[[f32; PARAMETERS]; PARAMETERS]) -> [[f32; 3]; 4] {
        CORNERS.map(|corner| {
            let [x, y] = self.homography.jacobian(corner);
            let product = |a: &[f32; 8], b: &[f32; 8]| {
                let row = |i: usize| (0..8).map(|j| covariance[i][j] * b[j]).sum::<f32>();
                (0..8).map(|i| a[i] * row(i)).sum::<f32>()
            };
            [product(&x, &x), product(&x, &y), product(&y, &y)]
        })
    }
}

/// One pass over the tag's pixels; those that stray by more than `scale` allows count less.
fn accumulate(
    image: &Image<'_>,
    pattern: &BlurredPattern,
    state: &State,
    scale: f32,
) -> Option<NormalEquations> {
    let inverse = state.homography.inverse()?;
    let mut equations = NormalEquations::default();
    let reach = pattern.reach(state);
    let window = Window::around(image, state, reach);
    for y in window.rows() {
        let row = image.row(y);
        for x in window.columns(y) {
            let place = inverse.place([x as f32, y as f32]);
            if place.u.abs() > reach || place.v.abs() > reach {
                continue;
            }
            let coverage = pattern.at(&place, &state.blur);
            let (jacobian, grey) = state.linearise(&place, &coverage, [x as f32, y as f32]);
            let seen = f32::from(row[x]);
            let clipped = row[x] >= 254 && grey > seen || row[x] <= 1 && grey < seen;
            if !clipped {
                equations.add(
                    &jacobian,
                    seen - grey,
                    scale,
                    pattern.nearest_crossing(&place),
                );
            }
        }
    }
    equations.add_priors(state.blur, USUAL_BLUR_PX.powi(2), state.gain);
    equations.is_determined().then_some(equations)
}

/// A pixel's place on the square and how that changes over the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) u_gradient: Point,
    pub(crate) v_gradient: Point,
    /// Denominator of the homography at the place.
    w: f32,
}

/// Image to square, as a matrix on pixels relative to the homography's origin.
struct Inverse {
    homography: Homography,
    m: [f32; 9],
}

impl Homography {
    fn inverse(&self) -> Option<Inverse> {
        let [a, b, c, d, e, f, g, h] = self.m;
        let m = [
            e - f * h,
            c * h - b,
            b * f - c * e,
            f * g - d,
            a - c * g,
            c * d - a * f,
            d * h - e * g,
            b * g - a * h,
            a * e - b * d,
        ];
        m[8].is_normal().then_some(Inverse {
            homography: *self,
            m,
        })
    }

    /// Change of the image of a place with each parameter: rows for x and y.
    fn jacobian(&self, [u, v]: Point) -> [[f32; 8]; 2] {
        let w = 1.0 / (self.m[6] * u + self.m[7] * v + 1.0);
        let [x, y] = self.apply(u, v);
        let (x, y) = (x - self.origin[0], y - self.origin[1]);
        [
            [u * w, v * w, w, 0.0, 0.0, 0.0, -x * u * w, -x * v * w],
            [0.0, 0.0, 0.0, u * w, v * w, w, -y * u * w, -y * v * w],
        ]
    }
}

impl Inverse {
    #[inline]
    fn place(&self, [x, y]: Point) -> Place {
        let (x, y) = (x - self.homography.origin[0], y - self.homography.origin[1]);
        let m = &self.m;
        let t = 1.0 / (m[6] * x + m[7] * y + m[8]);
        let (u, v) = (
            (m[0] * x + m[1] * y + m[2]) * t,
            (m[3] * x + m[4] * y + m[5]) * t,
        );
        let w = self.homography.m[6] * u + self.homography.m[7] * v + 1.0;
        Place {
            u,
            v,
            u_gradient: [(m[0] - u * m[6]) * t, (m[1] - u * m[7]) * t],
            v_gradient: [(m[3] - v * m[6]) * t, (m[4] - v * m[7]) * t],
            w,
        }
    }
}

impl State {
    /// White's share after the response, and its change with the share before.
    #[inline]
    fn response(&self, share: f32) -> (f32, f32) {
        (
            share + self.gain * share * (1.0 - share),
            1.0 + self.gain * (1.0 - 2.0 * share),
        )
    }

    /// The model's grey at a pixel and its derivative with respect to every parameter.
    #[inline]
    fn linearise(
        &self,
        place: &Place,
        coverage: &Coverage,
        pixel: Point,
    ) -> ([f32; PARAMETERS], f32) {
        let Place {
            u,
            v,
            u_gradient,
            v_gradient,
            w,
        } = *place;
        let plane = |p: &[f32; 3]| p[0] + p[1] * u + p[2] * v;
        let (black, contrast) = (plane(&self.black), plane(&self.white) - plane(&self.black));
        let (cover, steepness) = self.response(coverage.value);
        let grey = black + contrast * cover;
        let response = contrast * steepness;
        let along_u =
            response * coverage.along_u + self.black[1] + (self.white[1] - self.black[1]) * cover;
        let along_v =
            response * coverage.along_v + self.black[2] + (self.white[2] - self.black[2]) * cover;
        // When the square's image moves by d, the grey at a fixed pixel changes by -gradient . d.
        let gx = -(along_u * u_gradient[0] + along_v * v_gradient[0]) / w;
        let gy = -(along_u * u_gradient[1] + along_v * v_gradient[1]) / w;
        let (x, y) = (
            pixel[0] - self.homography.origin[0],
            pixel[1] - self.homography.origin[1],
        );
        let towards = -(gx * x + gy * y);
        let rest = 1.0 - cover;
        let jacobian = [
            gx * u,
            gx * v,
            gx,
            gy * u,
            gy * v,
            gy,
            towards * u,
            towards * v,
            rest,
            rest * u,
            rest * v,
            cover,
            cover * u,
            cover * v,
            response * coverage.with_blur[0],
            response * coverage.with_blur[1],
            response * coverage.with_blur[2],
            contrast * coverage.value * (1.0 - coverage.value),
        ];
        (jacobian, grey)
    }
}

/// The pixels to look at: a lattice thinned out so that large tags cost no more than middling ones.
struct Window {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
    step: usize,
}

impl Window {
    fn around(image: &Image<'_>, state: &State, reach: f32) -> Self {
        let corners = CORNERS.map(|[u, v]| state.homography.apply(u * reach, v * reach));
        let bound = |axis: usize, size: usize| {
            let low = corners
                .iter()
                .map(|corner| corner[axis])
                .fold(f32::INFINITY, f32::min);
            let high = corners
                .iter()
                .map(|corner| corner[axis])
                .fold(0.0, f32::max);
            (
                low.ceil().max(0.0) as usize,
                ((high + 1.0) as usize).min(size),
            )
        };
        let ((left, right), (top, bottom)) = (bound(0, image.width()), bound(1, image.height()));
        let n_pixels = (right.saturating_sub(left) * bottom.saturating_sub(top)) as f32;
        let step = (n_pixels / MAX_PIXELS).ceil().max(1.0) as usize;
        Self {
            left,
            right,
            top,
            bottom,
            step,
        }
    }

    fn rows(&self) -> std::ops::Range<usize> {
        self.top..self.bottom
    }

    /// Every `step`th pixel, shifted from row to row by a golden share of it, so that no pattern is met in step.
    fn columns(&self, y: usize) -> std::iter::StepBy<std::ops::Range<usize>> {
        let shift = (y * 618 / 1000 + y) % self.step;
        (self.left + shift..self.right).step_by(self.step)
    }
}
