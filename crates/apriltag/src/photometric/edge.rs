//! What one straight blurred edge looks like.
//!
//! Blur is a Gaussian. In sharp pictures it is one after the pixel's own square, which across an edge is a trapezoid: here a
//! box with the trapezoid's fourth cumulant, and the rest of its variance is the Gaussian's. What makes blur another shape is
//! told by the halo: that many times the blur more, and a Gaussian twice as wide that many times less. Sharpening does just
//! that and leaves halos beside the edges; the blur of an open aperture and of motion ends as abruptly; with glare it is the
//! other way round.

use super::state::PIXEL;
use crate::quad::Point;

/// Share of the blur that lies beyond an edge, its derivative with the distance, per pixel, with the Gaussian's variance, per
/// square pixel, and with the halo.
pub(super) type Edge = [f32; 4];

/// How all edges of one direction look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    /// Of the whole blur.
    per_sigma: f32,
    halo: f32,
    /// Of the box, and of the Gaussian besides.
    width: f32,
    sigma_besides: f32,
}

impl Profile {
    /// Of edges across the direction `[nx, ny]`, for this variance of the blur and the pixel's square together.
    pub(super) fn new([nx, ny]: Point, variance: f32, halo: f32) -> Self {
        const LEAST_BESIDES: f32 = 0.0025;
        // A box's fourth cumulant is -width^4 / 120, and those of the square's sides along and across add up.
        let width = (nx.powi(4) + ny.powi(4)).sqrt().sqrt();
        Self {
            per_sigma: 1.0 / variance.sqrt(),
            halo,
            width,
            sigma_besides: (variance - width * width * PIXEL).max(LEAST_BESIDES).sqrt(),
        }
    }

    /// At a distance in pixels, of a sharp picture or of one in which the box does not show.
    #[inline(always)]
    pub(super) fn at<const SHARP: bool>(&self, distance: f32) -> Edge {
        let z = distance * self.per_sigma;
        let with_variance = -0.5 * z * self.per_sigma;
        let x = bounded(z);
        let root = exp_of_negative(-0.125 * x * x);
        let wide_share = share(z, 0.5 * x, PEAK * root);
        let wide_density = 0.5 * PEAK * root * self.per_sigma;
        let blur = if SHARP {
            self.with_box(distance)
        } else {
            let density = PEAK * root.powi(4);
            let density_px = density * self.per_sigma;
            [share(z, x, density), density_px, with_variance * density_px]
        };
        let wide = [wide_share, wide_density, with_variance * wide_density];
        let [share, density, spread] = [0, 1, 2].map(|i| blur[i] + self.halo * (blur[i] - wide[i]));
        [share, density, spread, blur[0] - wide_share]
    }

    /// The integral of the Gaussian's shares over the box; blur obeys the heat equation, so that the derivative with the
    /// variance is half the second with the distance.
    #[inline(always)]
    fn with_box(&self, distance: f32) -> [f32; 3] {
        let (per_width, per_sigma) = (1.0 / self.width, 1.0 / self.sigma_besides);
        let ends = [distance + 0.5 * self.width, distance - 0.5 * self.width];
        let [(far, far_density), (near, near_density)] = ends.map(|end| normal(end * per_sigma));
        let density = far_density - near_density;
        let integral = ends[0] * far - ends[1] * near + self.sigma_besides * density;
        [
            integral * per_width,
            (far - near) * per_width,
            0.5 * density * per_sigma * per_width,
        ]
    }
}

/// The normal distribution function and its density.
#[inline(always)]
fn normal(z: f32) -> (f32, f32) {
    let x = bounded(z);
    let density = PEAK * exp_of_negative(-0.5 * x * x);
    (share(z, x, density), density)
}

/// How far from the middle, as far as the exponential goes. Not by `min`, which calls a library on 32-bit ARM.
#[inline(always)]
fn bounded(z: f32) -> f32 {
    const FAR: f32 = 12.0;
    if z.abs() < FAR { z.abs() } else { FAR }
}

/// The normal distribution function at z, given |z| and the density there.
#[inline(always)]
fn share(z: f32, x: f32, density: f32) -> f32 {
    let tail = density * tail_over_density(x);
    if z < 0.0 { tail } else { 1.0 - tail }
}

/// Of the normal distribution.
const PEAK: f32 = 0.398_942_3;

/// One less the normal distribution function, over its density (Abramowitz & Stegun, Handbook of Mathematical Functions,
/// 26.2.16, |error| < 1e-5).
#[inline(always)]
fn tail_over_density(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.332_67 * x);
    t * (0.436_183_6 + t * (-0.120_167_6 + t * 0.937_298))
}

/// e^x for x from -80 to 0, without a call: 2^n is put together from its bits, 2^f for |f| <= 1/2 is a Taylor series in
/// f ln 2 (|relative error| < 5e-5).
#[inline(always)]
fn exp_of_negative(x: f32) -> f32 {
    /// Adding it leaves the nearest whole number in the lowest bits.
    const SHIFT: f32 = 12_582_912.0;
    let power = x * std::f32::consts::LOG2_E;
    let shifted = power + SHIFT;
    let y = (power - (shifted - SHIFT)) * std::f32::consts::LN_2;
    let series = 1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y * (1.0 / 24.0))));
    series * f32::from_bits(shifted.to_bits().wrapping_add(127) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_the_librarys() {
        for i in 0..=8000 {
            let x = -0.01 * i as f32;
            let (fast, exact) = (exp_of_negative(x), x.exp());
            assert!((fast / exact - 1.0).abs() < 1e-4, "{x}: {fast} {exact}");
        }
    }

    #[test]
    fn an_edges_derivatives_are_those_of_its_share() {
        derivatives_are_right::<true>();
        derivatives_are_right::<false>();
    }

    fn derivatives_are_right<const SHARP: bool>() {
        const STEP: f32 = 0.02;
        let (variance, halo) = (0.45, 0.4);
        let share = |distance: f32, variance: f32, halo: f32| {
            Profile::new([0.8, 0.6], variance, halo).at::<SHARP>(distance)[0]
        };
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let [value, derivatives @ ..] =
                Profile::new([0.8, 0.6], variance, halo).at::<SHARP>(distance);
            assert!((value + share(-distance, variance, halo) - 1.0).abs() < 1e-4);
            let differences = [
                share(distance + STEP, variance, halo) - share(distance - STEP, variance, halo),
                share(distance, variance + STEP, halo) - share(distance, variance - STEP, halo),
                share(distance, variance, halo + STEP) - share(distance, variance, halo - STEP),
            ];
            for (derivative, difference) in derivatives.iter().zip(differences) {
                let error = derivative - difference / (2.0 * STEP);
                assert!(error.abs() < 2e-3, "{distance}: {derivative} {difference}");
            }
        }
    }

    #[test]
    fn a_halo_goes_beyond_white_beside_an_edge() {
        let profile = Profile::new([1.0, 0.0], 1.0, 1.0);
        assert!(profile.at::<false>(2.2)[0] > 1.03);
        assert!(profile.at::<false>(-2.2)[0] < -0.03);
    }
}
