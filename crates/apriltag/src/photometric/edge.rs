//! What one straight blurred edge looks like.
//!
//! Blur is a Gaussian and the next term of Edgeworth's series (Cramér, Mathematical Methods of Statistics, 1946, 17.7), by
//! which its fourth cumulant shows. That of the pixel's own square is known. The rest is fitted: sharpening, the blur of an
//! open aperture and that of motion end more abruptly than a Gaussian, glare less so.

use super::SHIFT;
use crate::quad::Point;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Share of the blur that lies beyond an edge, its derivative with the distance, per pixel, with the blur's variance, per
/// square pixel, and with its shape.
pub(super) type Edge = [f32; 4];

/// How all edges of one direction look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    per_sigma: f32,
    /// A twenty-fourth of the excess kurtosis.
    shape: f32,
}

impl Profile {
    /// Of edges across the direction `[nx, ny]`, for this variance of the blur and the pixel's square together, and this shape
    /// of the blur besides that square.
    pub(super) fn new([nx, ny]: Point, variance: f32, shape: f32) -> Self {
        // The fourth cumulant of a box is -width^4 / 120, and those of the square's sides along and across add up.
        let of_square = (nx.powi(4) + ny.powi(4)) / (120.0 * 24.0);
        Self {
            per_sigma: 1.0 / variance.sqrt(),
            shape: shape - of_square / (variance * variance),
        }
    }

    /// At a distance in pixels.
    #[inline(always)]
    pub(super) fn at(&self, distance: f32) -> Edge {
        let z = bounded(distance * self.per_sigma);
        let square = z * z;
        let density = PEAK * exp_of_negative(-0.5 * square);
        let tail = density * tail_over_density(z.abs());
        let share = if z < 0.0 { tail } else { 1.0 - tail };
        // Hermite's polynomials of third and fourth order.
        let with_shape = -z * (square - 3.0) * density;
        let fourth = square * (square - 6.0) + 3.0;
        let density_px = density * (1.0 + self.shape * fourth) * self.per_sigma;
        [
            share + self.shape * with_shape,
            density_px,
            -0.5 * z * self.per_sigma * density_px,
            with_shape,
        ]
    }
}

/// As far from the middle as the exponential goes. Not by `clamp`, which calls a library on 32-bit ARM.
#[inline(always)]
fn bounded(z: f32) -> f32 {
    const FAR: f32 = 12.0;
    if z.abs() < FAR { z } else { FAR.copysign(z) }
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
        const STEP: f32 = 0.02;
        let at = |distance: f32, variance: f32, shape: f32| {
            let per_sigma = 1.0 / variance.sqrt();
            Profile { per_sigma, shape }.at(distance)
        };
        let share = |distance, variance, shape| at(distance, variance, shape)[0];
        let (variance, shape) = (0.45, 0.06);
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let [value, derivatives @ ..] = at(distance, variance, shape);
            assert!((value + share(-distance, variance, shape) - 1.0).abs() < 1e-4);
            let differences = [
                share(distance + STEP, variance, shape) - share(distance - STEP, variance, shape),
                share(distance, variance + STEP, shape) - share(distance, variance - STEP, shape),
                share(distance, variance, shape + STEP) - share(distance, variance, shape - STEP),
            ];
            for (derivative, difference) in derivatives.iter().zip(differences) {
                let error = derivative - difference / (2.0 * STEP);
                assert!(error.abs() < 2e-3, "{distance}: {derivative} {difference}");
            }
        }
    }

    #[test]
    fn an_edge_that_ends_abruptly_goes_beyond_white_beside_it() {
        let profile = Profile::new([1.0, 0.0], 1.0, -0.2);
        assert!(profile.at(2.2)[0] > 1.01);
        assert!(profile.at(-2.2)[0] < -0.01);
    }

    #[test]
    fn an_edge_of_a_sharp_picture_is_nearly_a_pixels_share() {
        for (i, most) in [(0, 0.001), (2, 0.03), (4, 0.03), (6, 0.03)] {
            let distance = 0.1 * i as f32;
            let share = Profile::new([1.0, 0.0], PIXEL + 0.01, 0.0).at(distance)[0];
            assert!(
                (share - 0.5 - distance.min(0.5)).abs() < most,
                "{distance}: {share}"
            );
        }
    }
}
