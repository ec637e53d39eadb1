//! Everything that is fitted, and what a pixel should show given it.

use super::blurred_pattern::Coverage;
use super::factor::Factor;
use super::group_sums::Row;
use super::lanes::{Lanes, map, map_into};
use super::normal_equations::PARAMETERS;
use crate::homography::Homography;
use crate::quad::{Point, Quad, distance, mean_edge};
use crate::reading::Reading;

/// Standard deviation of the blur where nothing is known: a good lens, in pixels.
pub(super) const USUAL_BLUR_PX: f32 = 0.6;

/// Standard deviation of the gain where nothing is known: a curve of 1 / 1.4 or ink that spreads by a seventh of a pixel.
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
    /// Logarithm of white's growth.
    pub(super) gain: f32,
    /// By how much white outgrows black where both have half a share.
    growth: f32,
}

/// Pixels' places on the square and how those change over the image.
pub(super) struct Places {
    pub(super) u: Lanes,
    pub(super) v: Lanes,
    from_origin: [Lanes; 2],
    u_gradient: [Lanes; 2],
    v_gradient: [Lanes; 2],
    /// Pixels that u and v take to grow by one, at right angles to their edges.
    pub(super) u_px: Lanes,
    pub(super) v_px: Lanes,
}

impl State {
    pub(super) fn start(quad: &Quad, reading: &Reading) -> Option<Self> {
        Some(Self {
            homography: Homography::centred_square_to_quad(quad)?,
            black: [reading.black, 0.0, 0.0],
            white: [reading.white, 0.0, 0.0],
            blur: [USUAL_BLUR_PX.powi(2), 0.0, USUAL_BLUR_PX.powi(2)],
            gain: 0.0,
            growth: 1.0,
        })
    }

    /// Takes a step; nothing when it leads out of the numbers.
    pub(super) fn step(&mut self, step: &[f32; PARAMETERS]) -> Option<()> {
        const LEAST_BLUR: f32 = 0.05 * 0.05;
        const MOST_BLUR: f32 = 4.0 * 4.0;
        const MOST_GAIN: f32 = 3.0;
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
        self.growth = self.gain.exp();
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

    /// J A^-1 J^T for each corner, given the factor of A.
    pub(super) fn corner_covariances(&self, factor: &Factor) -> [[f32; 3]; 4] {
        CORNERS.map(|corner| {
            let [x, y] = self.homography.jacobian(corner).map(|row| {
                let mut all = [0.0; PARAMETERS];
                all[..row.len()].copy_from_slice(&row);
                factor.whiten(&all)
            });
            let product = |a: &[f32; PARAMETERS], b: &[f32; PARAMETERS]| {
                a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>()
            };
            [product(&x, &x), product(&x, &y), product(&y, &y)]
        })
    }

    pub(super) fn inverse(&self) -> Option<Inverse> {
        Inverse::of(&self.homography)
    }

    /// White's share after the response, and its change with the share before.
    #[inline(always)]
    fn response(&self, share: f32) -> (f32, f32) {
        let part = 1.0 / (1.0 + (self.growth - 1.0) * share);
        (self.growth * share * part, self.growth * part * part)
    }

    /// Grey of black, and what white has more, at a place.
    #[inline(always)]
    fn levels(&self, u: f32, v: f32) -> (f32, f32) {
        let plane = |p: &[f32; 3]| p[0] + p[1] * u + p[2] * v;
        let black = plane(&self.black);
        (black, plane(&self.white) - black)
    }

    /// The greys that pixels should have.
    #[inline(always)]
    pub(super) fn greys(&self, places: &Places, coverage: &Coverage) -> Lanes {
        let [greys] = map(|i| {
            let (black, contrast) = self.levels(places.u[i], places.v[i]);
            [black + contrast * self.response(coverage.value[i]).0]
        });
        greys
    }

    /// Writes the basic derivatives of the pixels' greys and their residuals, times a factor for each pixel.
    #[inline(always)]
    pub(super) fn linearise(
        &self,
        places: &Places,
        coverage: &Coverage,
        residuals: &Lanes,
        factor: &Lanes,
        row: &mut Row,
    ) {
        let (black, white) = (&self.black, &self.white);
        map_into(row, |i| {
            let (u, v) = (places.u[i], places.v[i]);
            let contrast = self.levels(u, v).1 * factor[i];
            let (cover, steepness) = self.response(coverage.value[i]);
            let with_gain = contrast * cover * (1.0 - cover);
            let (rest, cover) = (factor[i] - factor[i] * cover, factor[i] * cover);
            let response = contrast * steepness;
            let along_u = response * coverage.along_u[i] + rest * black[1] + cover * white[1];
            let along_v = response * coverage.along_v[i] + rest * black[2] + cover * white[2];
            // When the square's image moves by d, the grey at a fixed pixel changes by -gradient . d.
            let w = -1.0 / (self.homography.m[6] * u + self.homography.m[7] * v + 1.0);
            let along = |axis: usize| {
                (along_u * places.u_gradient[axis][i] + along_v * places.v_gradient[axis][i]) * w
            };
            let (gx, gy) = (along(0), along(1));
            let towards = -(gx * places.from_origin[0][i] + gy * places.from_origin[1][i]);
            let [xx, xy, yy] = coverage.with_blur.each_ref().map(|with| response * with[i]);
            [
                gx,
                gy,
                towards,
                rest,
                cover,
                xx,
                xy,
                yy,
                with_gain,
                factor[i] * residuals[i],
            ]
        });
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

    /// Whether a pixel lies on the square, or on one so many times as large.
    #[inline]
    pub(super) fn is_within(&self, [x, y]: Point, reach: f32) -> bool {
        let (x, y) = (x - self.homography.origin[0], y - self.homography.origin[1]);
        let m = &self.m;
        let limit = reach * (m[6] * x + m[7] * y + m[8]).abs();
        (m[0] * x + m[1] * y + m[2]).abs() <= limit && (m[3] * x + m[4] * y + m[5]).abs() <= limit
    }

    #[inline(always)]
    pub(super) fn places(&self, x: &Lanes, y: &Lanes) -> Places {
        let m = &self.m;
        let [u, v, dx, dy, ux, uy, vx, vy, u_px, v_px] = map(|i| {
            let (x, y) = (
                x[i] - self.homography.origin[0],
                y[i] - self.homography.origin[1],
            );
            let t = 1.0 / (m[6] * x + m[7] * y + m[8]);
            let (u, v) = (
                (m[0] * x + m[1] * y + m[2]) * t,
                (m[3] * x + m[4] * y + m[5]) * t,
            );
            let (ux, uy) = ((m[0] - u * m[6]) * t, (m[1] - u * m[7]) * t);
            let (vx, vy) = ((m[3] - v * m[6]) * t, (m[4] - v * m[7]) * t);
            let pixels = |x: f32, y: f32| 1.0 / (x * x + y * y).sqrt();
            [u, v, x, y, ux, uy, vx, vy, pixels(ux, uy), pixels(vx, vy)]
        });
        Places {
            u,
            v,
            from_origin: [dx, dy],
            u_gradient: [ux, uy],
            v_gradient: [vx, vy],
            u_px,
            v_px,
        }
    }
}

impl Places {
    /// Directions in the image in which u and v grow, at the first place.
    pub(super) fn first_normals(&self) -> [Point; 2] {
        [
            self.u_gradient.map(|gradient| gradient[0] * self.u_px[0]),
            self.v_gradient.map(|gradient| gradient[0] * self.v_px[0]),
        ]
    }
}
