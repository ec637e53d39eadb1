//! Everything that is fitted, and what a pixel should show given it.

use super::blurred_pattern::Coverage;
use super::normal_equations::PARAMETERS;
use crate::homography::Homography;
use crate::quad::{Point, Quad, distance, mean_edge};
use crate::reading::Reading;

/// Standard deviation of the blur where nothing is known: a good lens, in pixels.
pub(super) const USUAL_BLUR_PX: f32 = 0.6;

/// Standard deviation of the gain where nothing is known.
pub(super) const USUAL_GAIN: f32 = 0.3;

/// Corners of the square in its own coordinates.
const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// From the square -1..1 (u right, v down) to pixels.
    pub(super) homography: Homography,
    /// Grey = p0 + p1 u + p2 v.
    black: [f32; 3],
    white: [f32; 3],
    /// Covariance of the blur in the image, in square pixels: xx, xy, yy.
    pub(super) blur: [f32; 3],
    /// Curvature of the response to white's share.
    pub(super) gain: f32,
}

/// A pixel's place on the square and how that changes over the image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) u: f32,
    pub(super) v: f32,
    u_gradient: Point,
    v_gradient: Point,
    /// Pixels that u and v take to grow by one, at right angles to their edges.
    pub(super) u_px: f32,
    pub(super) v_px: f32,
    /// Denominator of the homography at the place.
    w: f32,
}

impl State {
    pub(super) fn start(quad: &Quad, reading: &Reading) -> Option<Self> {
        Some(Self {
            homography: Homography::centred_square_to_quad(quad)?,
            black: [reading.black, 0.0, 0.0],
            white: [reading.white, 0.0, 0.0],
            blur: [USUAL_BLUR_PX.powi(2), 0.0, USUAL_BLUR_PX.powi(2)],
            gain: 0.0,
        })
    }

    /// Takes a step; nothing when it leads out of the numbers.
    pub(super) fn step(&mut self, step: &[f32; PARAMETERS]) -> Option<()> {
        const LEAST_BLUR: f32 = 0.05 * 0.05;
        const MOST_BLUR: f32 = 4.0 * 4.0;
        const MOST_GAIN: f32 = 0.8;
        let planes = self.black.iter_mut().chain(&mut self.white);
        let optics = self.blur.iter_mut().chain([&mut self.gain]);
        for (value, change) in self
            .homography
            .m
            .iter_mut()
            .chain(planes)
            .chain(optics)
            .zip(step)
        {
            *value += change;
        }
        self.gain = self.gain.clamp(-MOST_GAIN, MOST_GAIN);
        self.blur[0] = self.blur[0].clamp(LEAST_BLUR, MOST_BLUR);
        self.blur[2] = self.blur[2].clamp(LEAST_BLUR, MOST_BLUR);
        let most = 0.9 * (self.blur[0] * self.blur[2]).sqrt();
        self.blur[1] = self.blur[1].clamp(-most, most);
        step.iter().all(|change| change.is_finite()).then_some(())
    }

    /// Standard deviation of the blur, whichever way, in pixels.
    pub(super) fn blur_px(&self) -> f32 {
        ((self.blur[0] + self.blur[2]) / 2.0).sqrt()
    }

    pub(super) fn contrast(&self) -> f32 {
        self.white[0] - self.black[0]
    }

    pub(super) fn corners(&self) -> Quad {
        CORNERS.map(|[u, v]| self.homography.apply(u, v))
    }

    /// Every corner is in the neighbourhood that the edges leave open, and white is brighter than black.
    pub(super) fn is_plausible(&self, start: &Quad) -> bool {
        let limit = 0.5 + 0.03 * mean_edge(start);
        let near = |(&a, &b): (&Point, &Point)| distance(a, b) < limit;
        self.corners().iter().zip(start).all(near) && self.contrast() > 0.0
    }

    /// Greatest distance that a step moves a corner.
    pub(super) fn corner_motion(&self, step: &[f32; PARAMETERS]) -> f32 {
        let motion = |corner: Point| {
            let moved = self
                .homography
                .jacobian(corner)
                .map(|row| row.iter().zip(step).map(|(a, b)| a * b).sum::<f32>());
            moved[0].hypot(moved[1])
        };
        CORNERS.into_iter().map(motion).fold(0.0, f32::max)
    }

    pub(super) fn corner_covariances(&self, covariance: &[[f32; 8]; 8]) -> [[f32; 3]; 4] {
        CORNERS.map(|corner| {
            let [x, y] = self.homography.jacobian(corner);
            let product = |a: &[f32; 8], b: &[f32; 8]| {
                let row = |i: usize| (0..8).map(|j| covariance[i][j] * b[j]).sum::<f32>();
                (0..8).map(|i| a[i] * row(i)).sum::<f32>()
            };
            [product(&x, &x), product(&x, &y), product(&y, &y)]
        })
    }

    pub(super) fn inverse(&self) -> Option<Inverse> {
        Inverse::of(&self.homography)
    }

    /// White's share after the response, and its change with the share before.
    #[inline]
    fn response(&self, share: f32) -> (f32, f32) {
        (
            share + self.gain * share * (1.0 - share),
            1.0 + self.gain * (1.0 - 2.0 * share),
        )
    }

    /// Grey of black, and what white has more, at a place.
    #[inline]
    fn levels(&self, u: f32, v: f32) -> (f32, f32) {
        let plane = |p: &[f32; 3]| p[0] + p[1] * u + p[2] * v;
        let black = plane(&self.black);
        (black, plane(&self.white) - black)
    }

    /// The grey that a pixel should have, and its derivative with respect to every parameter.
    #[inline]
    pub(super) fn linearise(
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
            ..
        } = *place;
        let (black, contrast) = self.levels(u, v);
        let (cover, steepness) = self.response(coverage.value);
        let rest = 1.0 - cover;
        let response = contrast * steepness;
        let along_u = response * coverage.along_u + rest * self.black[1] + cover * self.white[1];
        let along_v = response * coverage.along_v + rest * self.black[2] + cover * self.white[2];
        // When the square's image moves by d, the grey at a fixed pixel changes by -gradient . d.
        let gx = -(along_u * u_gradient[0] + along_v * v_gradient[0]) / w;
        let gy = -(along_u * u_gradient[1] + along_v * v_gradient[1]) / w;
        let (x, y) = (
            pixel[0] - self.homography.origin[0],
            pixel[1] - self.homography.origin[1],
        );
        let towards = -(gx * x + gy * y);
        let [xx, xy, yy] = coverage.with_blur;
        let curve = contrast * coverage.value * (1.0 - coverage.value);
        #[rustfmt::skip]
        let jacobian = [
            gx * u, gx * v, gx, gy * u, gy * v, gy, towards * u, towards * v,
            rest, rest * u, rest * v, cover, cover * u, cover * v,
            response * xx, response * xy, response * yy, curve,
        ];
        (jacobian, black + contrast * cover)
    }
}

impl Homography {
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

/// Image to square, as a matrix on pixels relative to the homography's origin.
pub(super) struct Inverse {
    homography: Homography,
    m: [f32; 9],
}

impl Inverse {
    fn of(homography: &Homography) -> Option<Self> {
        let [a, b, c, d, e, f, g, h] = homography.m;
        #[rustfmt::skip]
        let m = [
            e - f * h, c * h - b, b * f - c * e,
            f * g - d, a - c * g, c * d - a * f,
            d * h - e * g, b * g - a * h, a * e - b * d,
        ];
        m[8].is_normal().then_some(Self {
            homography: *homography,
            m,
        })
    }

    #[inline]
    pub(super) fn place(&self, [x, y]: Point) -> Place {
        let (x, y) = (x - self.homography.origin[0], y - self.homography.origin[1]);
        let m = &self.m;
        let t = 1.0 / (m[6] * x + m[7] * y + m[8]);
        let (u, v) = (
            (m[0] * x + m[1] * y + m[2]) * t,
            (m[3] * x + m[4] * y + m[5]) * t,
        );
        let u_gradient = [(m[0] - u * m[6]) * t, (m[1] - u * m[7]) * t];
        let v_gradient = [(m[3] - v * m[6]) * t, (m[4] - v * m[7]) * t];
        let pixels =
            |gradient: Point| 1.0 / (gradient[0] * gradient[0] + gradient[1] * gradient[1]).sqrt();
        Place {
            u,
            v,
            u_gradient,
            v_gradient,
            u_px: pixels(u_gradient),
            v_px: pixels(v_gradient),
            w: self.homography.m[6] * u + self.homography.m[7] * v + 1.0,
        }
    }
}

impl Place {
    /// Directions in the image in which u and v grow.
    pub(super) fn normals(&self) -> [Point; 2] {
        [
            self.u_gradient.map(|g| g * self.u_px),
            self.v_gradient.map(|g| g * self.v_px),
        ]
    }
}
