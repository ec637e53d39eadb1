//! Everything that is fitted.

use super::edge::Profile;
use super::equations::{Factor, Priors, Vector};
use super::pattern::Optics;
use crate::homography::Homography;
use crate::quad::{Point, Quad, distance, mean_edge};
use crate::reading::Reading;

/// Standard deviation of the blur where nothing is known: a good lens, in pixels.
const USUAL_BLUR_PX: f32 = 0.6;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Standard deviation of the gain where nothing is known: a curve of 1 / 1.4 or ink that spreads by a seventh of a pixel.
const USUAL_GAIN: f32 = 0.3;

/// Standard deviation of the ground's grey, in parts of the contrast, where nothing is known.
const USUAL_GROUND: f32 = 0.5;

/// Corners of the square in its own coordinates.
const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// From the square -1..1 (u right, v down) to pixels.
    pub(super) homography: Homography,
    /// Length in which the homography's denominator is measured, so that all its parameters are pixels.
    size_px: f32,
    /// Greys at the square's middle.
    pub(super) black: f32,
    pub(super) white: f32,
    /// By what part they are brighter a unit of u or v farther.
    pub(super) light: [f32; 2],
    /// Variance of the blur, with the pixels' own, across edges of u and of v, and their covariance, in square pixels.
    pub(super) blur: [f32; 3],
    /// How much the blur is another than a Gaussian.
    pub(super) halo: f32,
    /// How much more than its share white has where shares are about even.
    pub(super) gain: f32,
    /// How much of what lies beyond the ring the blur mixes in.
    pub(super) ground: f32,
}

impl State {
    pub(super) fn start(quad: &Quad, reading: &Reading) -> Option<Self> {
        let mut state = Self {
            homography: Homography::centred_square_to_quad(quad)?,
            size_px: mean_edge(quad),
            black: reading.black,
            white: reading.white,
            light: [0.0; 2],
            blur: [0.0; 3],
            halo: 0.0,
            gain: 0.0,
            ground: 1.0,
        };
        state.blur = state.usual_blur()?;
        Some(state)
    }

    /// Of a round blur.
    fn usual_blur(&self) -> Option<[f32; 3]> {
        let [u, v] = self.normals()?;
        let variance = USUAL_BLUR_PX.powi(2) + PIXEL;
        Some([variance, variance, variance * (u[0] * v[0] + u[1] * v[1])])
    }

    /// Directions in the image in which u and v grow, at the square's middle.
    fn normals(&self) -> Option<[Point; 2]> {
        let gradients = self.gradients([0.0; 2])?;
        Some(gradients.map(|[x, y]| [x / x.hypot(y), y / x.hypot(y)]))
    }

    /// By how much u and v grow in the image, per pixel, at a place of the square.
    fn gradients(&self, [u, v]: Point) -> Option<[Point; 2]> {
        let [m_u, m_v, m_w] = self.inverse()?;
        let [_, _, c, _, _, f, g, h] = self.homography.m;
        let per_w = (g * u + h * v + 1.0) / (m_w[0] * c + m_w[1] * f + m_w[2]);
        let gradient =
            |m: [f32; 3], place: f32| [0, 1].map(|axis| (m[axis] - place * m_w[axis]) * per_w);
        Some([gradient(m_u, u), gradient(m_v, v)])
    }

    /// Takes a step; nothing when it leads out of the numbers.
    pub(super) fn step(&mut self, step: &Vector) -> Option<()> {
        const LEAST_BLUR: f32 = PIXEL + 0.05 * 0.05;
        const MOST_BLUR: f32 = 4.0 * 4.0;
        const MOST_HALO: f32 = 2.0;
        const MOST_GAIN: f32 = 0.9;
        const MOST_GROUND: f32 = 5.0;
        if !step.iter().all(|change| change.is_finite()) {
            return None;
        }
        let [.., g, h, black, white, u, v, uu, vv, uv, halo, gain, ground] = step;
        let (contrast, m) = (self.contrast(), &mut self.homography.m);
        for (value, change) in m[..6].iter_mut().zip(step) {
            *value += change;
        }
        m[6] += g / self.size_px;
        m[7] += h / self.size_px;
        self.black += contrast * black;
        self.white += contrast * white;
        self.light = [self.light[0] + u, self.light[1] + v];
        self.halo = (self.halo + halo).clamp(-MOST_HALO, MOST_HALO);
        self.gain = (self.gain + gain).clamp(-MOST_GAIN, MOST_GAIN);
        self.ground = (self.ground + ground).clamp(-MOST_GROUND, MOST_GROUND);
        let uu = (self.blur[0] + uu).clamp(LEAST_BLUR, MOST_BLUR);
        let vv = (self.blur[1] + vv).clamp(LEAST_BLUR, MOST_BLUR);
        let most = 0.9 * (uu * vv).sqrt();
        self.blur = [uu, vv, (self.blur[2] + uv).clamp(-most, most)];
        Some(())
    }

    /// The blur is near the usual one, give or take as much, halo and gain near 0: matters only where the pixels don't tell.
    pub(super) fn priors(&self, usual_halo: f32) -> Option<Priors> {
        const SPREAD: f32 = USUAL_BLUR_PX * USUAL_BLUR_PX;
        let usual = self.usual_blur()?;
        let [uu, vv, uv] = [0, 1, 2].map(|i| (usual[i] - self.blur[i], SPREAD));
        Some([
            uu,
            vv,
            uv,
            (-self.halo, usual_halo),
            (-self.gain, USUAL_GAIN),
            (1.0 - self.ground, USUAL_GROUND),
        ])
    }

    /// Standard deviation of the blur without the pixels' own, whichever way, in pixels.
    pub(super) fn blur_px(&self) -> f32 {
        ((self.blur[0] + self.blur[1]) / 2.0 - PIXEL).sqrt()
    }

    pub(super) fn optics(&self) -> Option<Optics> {
        let [uu, vv, covariance] = self.blur;
        let [u, v] = self.normals()?;
        Some(Optics {
            profiles: [(u, uu), (v, vv)]
                .map(|(normal, variance)| Profile::new(normal, variance, self.halo)),
            covariance,
        })
    }

    /// Whether the pixels' own square is a good part of the blur, so that its shape shows.
    pub(super) fn is_sharp(&self) -> bool {
        const SHARP: f32 = 2.4 * PIXEL;
        self.blur[0].min(self.blur[1]) < SHARP
    }

    pub(super) fn contrast(&self) -> f32 {
        self.white - self.black
    }

    pub(super) fn size_px(&self) -> f32 {
        self.size_px
    }

    pub(super) fn corners(&self) -> Quad {
        CORNERS.map(|[u, v]| self.homography.apply(u, v))
    }

    /// The corners as they lie where light falls off to one side: blur mixes in more from the brighter side, so that all edges
    /// show nearer to the darker one, by the blur's covariance times the light's gradient over the light (Stein's lemma).
    pub(super) fn unshaded_corners(&self) -> Option<Quad> {
        let [uu, vv, uv] = self.blur;
        let (power, of_halo) = (self.inverse_power(), 1.0 - 3.0 * self.halo);
        let [uu, vv, uv] = [uu * of_halo, vv * of_halo, uv].map(|variance| variance * power);
        let corner = |place @ [u, v]: Point| {
            let [along_u, along_v] = self.gradients(place)?.map(|[x, y]| x.hypot(y));
            let light = 1.0 + self.light[0] * u + self.light[1] * v;
            let (slope_u, slope_v) = (
                self.light[0] * along_u / light,
                self.light[1] * along_v / light,
            );
            let (shift_u, shift_v) = (
                along_u * (uu * slope_u + uv * slope_v),
                along_v * (uv * slope_u + vv * slope_v),
            );
            Some(self.homography.apply(u + shift_u, v + shift_v))
        };
        let [a, b, c, d] = CORNERS.map(corner);
        Some([a?, b?, c?, d?])
    }

    /// What undoes the camera's curve, if it is a power p of the light, as far as the gain tells: of relative slopes it leaves p
    /// times as much. The mean of power 1/p of black and white lies by (1/p - 1) (white - black)^2 / (8 mean) above the middle,
    /// to first order, and so by a quarter of the gain times their difference.
    fn inverse_power(&self) -> f32 {
        const MOST: f32 = 2.5;
        let power = 1.0 + self.gain * (self.white + self.black) / self.contrast();
        power.clamp(1.0 / MOST, MOST)
    }

    /// No corner is farther from where it seemed to be when the code was read, and white is brighter than black.
    pub(super) fn is_plausible(&self, start: &Quad, farthest_px: f32) -> bool {
        let near = |(&a, &b): (&Point, &Point)| distance(a, b) < farthest_px;
        self.corners().iter().zip(start).all(near) && self.contrast() > 0.0
    }

    /// Greatest distance that a step moves a corner.
    pub(super) fn corner_motion(&self, step: &Vector) -> f32 {
        let motion = |[x, y]: [[f32; 8]; 2]| dot(&x, step).hypot(dot(&y, step));
        CORNERS
            .map(|corner| motion(self.jacobian(corner)))
            .into_iter()
            .fold(0.0, f32::max)
    }

    /// Whether a step changes the blur, in square pixels, so much that the next changes it again: that of a good lens changes
    /// by less.
    pub(super) fn blurs(step: &Vector) -> bool {
        const SETTLED: f32 = 0.25;
        let [.., uu, vv, _, _, _, _] = step;
        uu.abs().max(vv.abs()) > SETTLED
    }

    /// Of the corners, given what is known of the parameters.
    pub(super) fn corner_covariances(&self, factor: &Factor) -> [[f32; 3]; 4] {
        CORNERS.map(|corner| {
            let [x, y] = self.jacobian(corner).map(|row| factor.whiten(row));
            [dot(&x, &x), dot(&x, &y), dot(&y, &y)]
        })
    }

    /// Change of the image of a place with the homography's parameters: rows for x and y.
    fn jacobian(&self, [u, v]: Point) -> [[f32; 8]; 2] {
        let [.., g, h] = self.homography.m;
        let w = 1.0 / (g * u + h * v + 1.0);
        let [x, y] = self.homography.apply(u, v);
        let [ox, oy] = self.homography.origin;
        let (x, y) = ((ox - x) * w / self.size_px, (oy - y) * w / self.size_px);
        [
            [u * w, v * w, w, 0.0, 0.0, 0.0, x * u, x * v],
            [0.0, 0.0, 0.0, u * w, v * w, w, y * u, y * v],
        ]
    }

    /// From pixels, relative to the homography's origin, to the square: rows of the matrix.
    pub(super) fn inverse(&self) -> Option<[[f32; 3]; 3]> {
        let [a, b, c, d, e, f, g, h] = self.homography.m;
        let scale = 1.0 / (a * e - b * d);
        #[rustfmt::skip]
        let rows = [
            [e - f * h, c * h - b, b * f - c * e],
            [f * g - d, a - c * g, c * d - a * f],
            [d * h - e * g, b * g - a * h, a * e - b * d],
        ];
        scale
            .is_finite()
            .then_some(rows.map(|row| row.map(|value| value * scale)))
    }
}

/// Sum of products, as far as the shorter one goes.
fn dot(a: &[f32; 8], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
