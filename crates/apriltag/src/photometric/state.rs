//! The fitted parameters and what is derived from them: optics, homography, corners.

use super::edge::{PIXEL, Profile, beside_product, halo_variance, spread_px};
use super::equations::PixelEquations;
use super::parameters::{BLACK, BLUR, HALO, HOMOGRAPHY, PARAMETERS, Vector, WHITE};
use super::pattern::Optics;
use crate::homography::Homography;
use crate::quad::{Point, Quad, distance, mean_edge};
use nalgebra::Matrix3;

/// Derivatives with respect to the parameters of the homography.
pub(super) type Row = [f32; HOMOGRAPHY];

/// Prior standard deviation of the blur: a good lens, in pixels.
const USUAL_BLUR_PX: f32 = 0.6;

/// Variance of the blur, including the pixel's, in square pixels, below which the series of [`Profile`] is off by more
/// than 0.003 px from the response of the pixel's square.
const SHARP_BLUR: f32 = PIXEL + 0.3 * 0.3;

/// Minimum, maximum and prior standard deviation of the last parameters.
const RANGES: [[f32; 3]; PARAMETERS - BLUR] = {
    const BLURS: [f32; 3] = [LEAST_BLUR, 16.0, USUAL_BLUR_PX * USUAL_BLUR_PX];
    const LEAST_BLUR: f32 = PIXEL + 0.05 * 0.05;
    [
        // Variance of the blur, including the pixel's, across edges of u and of v, and their covariance, in square
        // pixels.
        BLURS,
        BLURS,
        [-16.0, 16.0, USUAL_BLUR_PX * USUAL_BLUR_PX],
        // Halo, in shares of the step: half of the light may be glare, and menus of cameras sharpen up to three times.
        [-0.5, 4.0, 0.2],
        // Gain of the response where shares are about equal: a tone curve of 1 / 1.4, or ink that spreads by a
        // seventh of a pixel.
        [-0.9, 0.9, 0.3],
        // Brightness beyond the ring minus white, in shares of the contrast.
        [-5.0, 5.0, 0.5],
    ]
};

/// Corners of the square in its own coordinates.
const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

#[derive(Clone, Copy, Debug)]
pub(super) struct PatternState {
    /// In pixels, shares of the initial contrast, and the units of [`RANGES`].
    pub(super) values: Vector,
    /// Initial centre of the square.
    pub(super) origin: Point,
    /// Unit of the homography's denominator, so that all its parameters are in pixels.
    pub(super) size_px: f32,
    /// Prior means of the last parameters.
    usual: [f32; PARAMETERS - BLUR],
}

impl PatternState {
    /// Initial state from the corners and the level of black, in shares of the contrast.
    pub(super) fn start(quad: &Quad, black: f32) -> Option<Self> {
        let Homography { origin, m } = Homography::square_to_quad(quad)?;
        let size_px = mean_edge(quad);
        let mut values = [0.0; PARAMETERS];
        values[..HOMOGRAPHY].copy_from_slice(&m);
        values[6] *= size_px;
        values[7] *= size_px;
        values[BLACK] = black;
        values[WHITE] = black + 1.0;
        let mut state = Self {
            values,
            origin,
            size_px,
            usual: [0.0; _],
        };
        // An isotropic blur.
        let [(u, _), (v, _)] = state.normals()?;
        let variance = USUAL_BLUR_PX.powi(2) + PIXEL;
        let covariance = variance * (u[0] * v[0] + u[1] * v[1]);
        state.usual[..3].copy_from_slice(&[variance, variance, covariance]);
        state.values[BLUR..].copy_from_slice(&state.usual);
        Some(state)
    }

    /// Prior of each of the last parameters: its mean minus the current value, and its standard deviation. Matters only
    /// where the pixels carry little information. Without a halo its prior keeps it at zero: far from the blur's
    /// variance, a step would rather explain the blur by glare.
    pub(super) fn priors(&self, with_halo: bool) -> [[f32; 2]; PARAMETERS - BLUR] {
        const NO_HALO: f32 = 0.01;
        let mut priors =
            std::array::from_fn(|i| [self.usual[i] - self.values[BLUR + i], RANGES[i][2]]);
        if !with_halo {
            priors[HALO - BLUR][1] = NO_HALO;
        }
        priors
    }

    /// Directions of u and v in the image at the centre of the square, and their increase per pixel.
    fn normals(&self) -> Option<[(Point, f32); 2]> {
        let [u, v, _] = self.inverse()?;
        Some([u, v].map(|[x, y, _]| ([x / x.hypot(y), y / x.hypot(y)], x.hypot(y))))
    }

    /// Applies a step; `None` if it is not finite.
    pub(super) fn step(&mut self, step: &Vector) -> Option<()> {
        if !step.iter().all(|change| change.is_finite()) {
            return None;
        }
        for (value, change) in self.values.iter_mut().zip(step) {
            *value += change;
        }
        for (value, [least, most, _]) in self.values[BLUR..].iter_mut().zip(RANGES) {
            *value = value.clamp(least, most);
        }
        Some(())
    }

    pub(super) fn optics(&self) -> Option<Optics> {
        let [.., light_u, light_v, uu, vv, uv, halo, _, ground] = self.values;
        let [(u, u_per_px), (v, v_per_px)] = self.normals()?;
        // Blur mixes in more light from the brighter side, so edges appear displaced towards the darker one by the
        // blur's covariance times the light's slope (Stein's lemma).
        let [slope_u, slope_v] = [light_u * u_per_px, light_v * v_per_px];
        let more = halo_variance(halo);
        let across = uv + more * (u[0] * v[0] + u[1] * v[1]);
        Some(Optics {
            profiles: [Profile::new(u, uu, halo), Profile::new(v, vv, halo)],
            covariance: uv,
            beside_product: beside_product(halo),
            shift_px: [
                (uu + more) * slope_u + across * slope_v,
                across * slope_u + (vv + more) * slope_v,
            ],
            ground,
        })
    }

    /// Variance of the blur across the edges of u and of v, in square pixels.
    pub(super) fn blur(&self) -> [f32; 2] {
        [self.values[BLUR], self.values[BLUR + 1]]
    }

    /// How far the edges of u and of v spread, in pixels.
    pub(super) fn spread_px(&self) -> [f32; 2] {
        let halo = self.values[HALO];
        self.blur().map(|variance| spread_px(variance, halo))
    }

    /// Whether the pixel's square is visible in the edges of u or of v.
    pub(super) fn is_sharp(&self) -> bool {
        let [uu, vv] = self.blur();
        uu.min(vv) < SHARP_BLUR
    }

    pub(super) fn contrast(&self) -> f32 {
        self.values[WHITE] - self.values[BLACK]
    }

    /// From the square -1..1 (u right, v down) to pixels.
    pub(super) fn homography(&self) -> Homography {
        let mut m: [f32; 8] = std::array::from_fn(|i| self.values[i]);
        m[6] /= self.size_px;
        m[7] /= self.size_px;
        Homography {
            origin: self.origin,
            m,
        }
    }

    pub(super) fn corners(&self) -> Quad {
        CORNERS.map(|[u, v]| self.homography().apply(u, v))
    }

    /// Whether every corner is within half an edge of its initial position and white is brighter than black. Beside a
    /// background as dark as the border, a corner is easily confused with one modules away.
    pub(super) fn is_plausible(&self, start: &Quad) -> bool {
        let near = |(&a, &b): (&Point, &Point)| distance(a, b) < self.size_px / 2.0;
        self.corners().iter().zip(start).all(near) && self.contrast() > 0.0
    }

    /// Largest motion of a corner by a step.
    pub(super) fn motion(&self, step: &Vector) -> f32 {
        let motion = |[x, y]: [[f32; 8]; 2]| dot(&x, step).hypot(dot(&y, step));
        let motions = CORNERS.map(|corner| motion(self.jacobian(corner)));
        motions.into_iter().fold(0.0, f32::max)
    }

    /// Dependence of x and y of each corner on eight independent variables of unit variance, from the solved equations:
    /// products of rows are covariances.
    pub(super) fn corner_rows(&self, equations: &PixelEquations) -> [[Row; 2]; 4] {
        CORNERS.map(|corner| self.jacobian(corner).map(|row| equations.whiten(row)))
    }

    /// Derivative of a mapped point with respect to the homography's parameters: rows for x and y.
    fn jacobian(&self, [u, v]: Point) -> [[f32; 8]; 2] {
        let homography = self.homography();
        let [.., g, h] = homography.m;
        let w = 1.0 / (g * u + h * v + 1.0);
        let [x, y] = homography.apply(u, v);
        let [ox, oy] = self.origin;
        let (x, y) = ((ox - x) * w / self.size_px, (oy - y) * w / self.size_px);
        [
            [u * w, v * w, w, 0.0, 0.0, 0.0, x * u, x * v],
            [0.0, 0.0, 0.0, u * w, v * w, w, y * u, y * v],
        ]
    }

    /// Map from pixels, relative to the origin, to the square: rows of the matrix.
    pub(super) fn inverse(&self) -> Option<[[f32; 3]; 3]> {
        let [a, b, c, d, e, f, g, h] = self.homography().m;
        let inverse = Matrix3::new(a, b, c, d, e, f, g, h, 1.0).try_inverse()?;
        let finite = inverse.iter().all(|value| value.is_finite());
        finite.then_some(inverse.transpose().into())
    }
}

/// Sum of products, up to the length of the shorter one.
pub(super) fn dot(a: &[f32; 8], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
