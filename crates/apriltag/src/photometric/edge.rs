//! Intensity profile of a straight blurred edge.
//!
//! Blur is a Gaussian with the next term of Edgeworth's series (Cramér, Mathematical Methods of Statistics, 1946, 17.7), which
//! represents its fourth cumulant. That of the pixel's square is known; the rest is fitted: sharpening, defocus and motion
//! end more abruptly than a Gaussian, glare less so. Where blur is so small that the pixel's square is visible, one term is
//! not enough: the edge is then a ramp as wide as the square, convolved with a Gaussian for everything else.

use super::SHIFT;
use crate::quad::Point;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Step response at a distance beyond an edge, and its derivatives with respect to distance (per pixel), variance of the blur (per
/// square pixel) and shape.
pub(super) type Edge = [f32; 4];

/// Profile of all edges of one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    per_sigma: f32,
    /// A twenty-fourth of the excess kurtosis.
    shape: f32,
    /// Width of the pixel's square, across the edge, between its two sides most parallel to the edge; and the standard deviation
    /// of all other blur.
    width: f32,
    beside_width: f32,
}

impl Profile {
    /// Profile of edges perpendicular to the direction `[nx, ny]`, for the variance of blur and pixel square together, and the shape
    /// of the blur without that square.
    pub(super) fn new([nx, ny]: Point, variance: f32, shape: f32) -> Self {
        // The fourth cumulant of a box is -width^4 / 120, and those of the square's sides along and across add up.
        let of_square = (nx.powi(4) + ny.powi(4)) / (120.0 * 24.0);
        let width = nx.abs().max(ny.abs());
        Self {
            per_sigma: 1.0 / variance.sqrt(),
            shape: shape - of_square / (variance * variance),
            width,
            beside_width: (variance - width * width * PIXEL).sqrt(),
        }
    }

    /// Step response at a distance in pixels, with the model for sharp or for blurred images.
    #[inline(always)]
    pub(super) fn at<const SHARP: bool>(&self, distance: f32) -> Edge {
        if SHARP {
            self.sharp_at(distance)
        } else {
            self.blurred_at(distance)
        }
    }

    /// Mean of the normal distribution function over the width of the square; ignores the shape.
    #[inline(always)]
    fn sharp_at(&self, distance: f32) -> Edge {
        let (half, per_width) = (0.5 * self.width, 1.0 / self.width);
        let far = until(distance + half, self.beside_width);
        let near = until(distance - half, self.beside_width);
        [
            (far[0] - near[0]) * per_width,
            (far[1] - near[1]) * per_width,
            (far[2] - near[2]) * per_width,
            0.0,
        ]
    }

    #[inline(always)]
    fn blurred_at(&self, distance: f32) -> Edge {
        let (z, density, share) = normal(distance * self.per_sigma);
        let square = z * z;
        // Hermite polynomials of third and fourth order.
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

/// Of a Gaussian-blurred step: its integral up to a distance, its value, and the integral's derivative with respect to the variance.
#[inline(always)]
fn until(distance: f32, sigma: f32) -> [f32; 3] {
    let (z, density, share) = normal(distance / sigma);
    let tail = if z < 0.0 { share } else { 1.0 - share };
    let beyond = if distance > 0.0 { distance } else { 0.0 };
    [
        beyond + sigma * (density - z.abs() * tail),
        share,
        0.5 * density / sigma,
    ]
}

/// The bounded argument, and density and distribution function of the standard normal distribution.
#[inline(always)]
fn normal(z: f32) -> (f32, f32, f32) {
    let z = bounded(z);
    let density = PEAK * exp_of_negative(-0.5 * z * z);
    let tail = density * tail_over_density(z.abs());
    (z, density, if z < 0.0 { tail } else { 1.0 - tail })
}

/// Limits an argument to the range of the exponential. `clamp` would call a library on 32-bit ARM.
#[inline(always)]
fn bounded(z: f32) -> f32 {
    const FAR: f32 = 12.0;
    if z.abs() < FAR { z } else { FAR.copysign(z) }
}

/// Peak of the standard normal density.
const PEAK: f32 = 0.398_942_3;

/// Upper tail of the normal distribution divided by its density (Abramowitz & Stegun, Handbook of Mathematical Functions,
/// 26.2.16, |error| < 1e-5).
#[inline(always)]
fn tail_over_density(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.332_67 * x);
    t * (0.436_183_6 + t * (-0.120_167_6 + t * 0.937_298))
}

/// e^x for x from -80 to 0, without a call: 2^n is assembled from its bits, 2^f for |f| <= 1/2 is a Taylor series in
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

    /// Compares profile and derivatives with finite differences.
    fn check_derivatives(at: impl Fn(f32, f32, f32) -> Edge, variance: f32, n: usize) {
        const STEP: f32 = 0.02;
        const SHAPE: f32 = 0.06;
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let slope = |[distance_step, variance_step, shape_step]: [f32; 3]| {
                let share = |sign: f32| {
                    let (distance, variance) = (
                        distance + sign * distance_step,
                        variance + sign * variance_step,
                    );
                    at(distance, variance, SHAPE + sign * shape_step)[0]
                };
                (share(1.0) - share(-1.0)) / (2.0 * STEP)
            };
            let [value, derivatives @ ..] = at(distance, variance, SHAPE);
            assert!((value + at(-distance, variance, SHAPE)[0] - 1.0).abs() < 1e-4);
            let steps = [[STEP, 0.0, 0.0], [0.0, STEP, 0.0], [0.0, 0.0, STEP]];
            for (derivative, step) in derivatives.iter().zip(steps).take(n) {
                let error = derivative - slope(step);
                assert!(
                    error.abs() < 2e-3,
                    "{distance}: {derivative} {}",
                    slope(step)
                );
            }
        }
    }

    #[test]
    fn an_edges_derivatives_are_those_of_its_share() {
        let blurred = |distance: f32, variance: f32, shape: f32| {
            let profile = Profile {
                shape,
                ..Profile::new([1.0, 0.0], variance, shape)
            };
            profile.at::<false>(distance)
        };
        check_derivatives(blurred, 0.45, 3);
        let sharp = |distance: f32, variance: f32, shape: f32| {
            Profile::new([0.8, 0.6], variance, shape).at::<true>(distance)
        };
        check_derivatives(sharp, 0.25, 2);
    }

    #[test]
    fn an_edge_that_ends_abruptly_goes_beyond_white_beside_it() {
        let profile = Profile::new([1.0, 0.0], 1.0, -0.2);
        assert!(profile.at::<false>(2.2)[0] > 1.01);
        assert!(profile.at::<false>(-2.2)[0] < -0.01);
    }

    #[test]
    fn an_edge_of_a_sharp_picture_is_a_pixels_share() {
        let profile = Profile::new([1.0, 0.0], PIXEL + 0.05 * 0.05, 0.0);
        for i in -30..=30 {
            let distance = 0.1 * i as f32;
            let share = profile.at::<true>(distance)[0];
            let ramp = (0.5 + distance).clamp(0.0, 1.0);
            assert!((share - ramp).abs() < 0.021, "{distance}: {share}");
        }
    }

    #[test]
    fn where_squares_hardly_show_an_edge_is_what_it_is_when_sharp() {
        for angle in [0.0_f32, 0.4, 0.78] {
            let profile = Profile::new([angle.cos(), angle.sin()], PIXEL + 0.3 * 0.3, 0.0);
            for i in -40..=40 {
                let distance = 0.05 * i as f32;
                let (sharp, blurred) =
                    (profile.at::<true>(distance), profile.at::<false>(distance));
                assert!(
                    (sharp[0] - blurred[0]).abs() < 0.004,
                    "{distance}: {} {}",
                    sharp[0],
                    blurred[0]
                );
            }
        }
    }
}
