//! Intensity profile of a straight blurred edge.
//!
//! Blur is a Gaussian, and sharpening adds the difference of that to a wider one, its halo, which leaves bright and
//! dark seams beside edges (unsharp masking); glare subtracts it. The pixel's square has a known fourth cumulant, the
//! next term of Edgeworth's series (Cramér, Mathematical Methods of Statistics, 1946, 17.7). Where blur is so small
//! that the square is visible, one term is not enough: the edge is then a ramp as wide as the square, convolved with a
//! Gaussian for everything else.

use super::SHIFT;
use crate::quad::Point;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Variance of the halo beyond that of the blur, in square pixels: cameras sharpen with radii of one to two and a half
/// pixels.
const HALO: f32 = 1.5 * 1.5;

/// Correction for the corners of modules, per product of the derivatives of the profiles of both axes with respect to
/// the halo, and its derivative: light with a halo h is (1 + h) times that without less h times the halo's, in both
/// dimensions together, which is h (1 + h) times that product less than the product of two profiles.
pub(super) fn beside_product(halo: f32) -> [f32; 2] {
    [-halo * (1.0 + halo), -1.0 - 2.0 * halo]
}

/// What a halo adds to the variance of the blur, in square pixels.
pub(super) fn halo_variance(halo: f32) -> f32 {
    -halo * HALO
}

/// Standard deviation of the blur, or what makes up for it where the halo shows farther away, in pixels: a halo is
/// fainter than an edge.
pub(super) fn spread_px(variance: f32, halo: f32) -> f32 {
    const LEAST_HALO: f32 = 0.1;
    /// Of the blur's extent in standard deviations, as far as a halo shows.
    const SHARE: f32 = 0.6;
    let of_blur = variance.sqrt();
    if halo.abs() > LEAST_HALO {
        of_blur.max(SHARE * (variance + HALO).sqrt())
    } else {
        of_blur
    }
}

/// Step response at a distance beyond an edge, and its derivatives with respect to distance (per pixel), variance of
/// the blur (per square pixel) and halo.
pub(super) type Edge = [f32; 4];

/// Profile of all edges of one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    per_sigma: f32,
    /// A twenty-fourth of the excess kurtosis of blur and pixel square.
    shape: f32,
    /// The share of light that is moved from the halo to the edge, and the halo's width.
    halo: f32,
    per_halo_sigma: f32,
    /// Width of the pixel's square, across the edge, between its two sides most parallel to the edge; and the standard
    /// deviation of all other blur.
    width: f32,
    beside_width: f32,
}

impl Profile {
    /// Profile of edges perpendicular to the direction `[nx, ny]`, for the variance of blur and pixel square together,
    /// and a halo.
    pub(super) fn new([nx, ny]: Point, variance: f32, halo: f32) -> Self {
        // The fourth cumulant of a box is -width^4 / 120, and those of the square's sides along and across add up.
        let of_square = (nx.powi(4) + ny.powi(4)) / (120.0 * 24.0);
        let width = nx.abs().max(ny.abs());
        Self {
            per_sigma: 1.0 / variance.sqrt(),
            shape: -of_square / (variance * variance),
            halo,
            per_halo_sigma: 1.0 / (variance + HALO).sqrt(),
            width,
            beside_width: (variance - width * width * PIXEL).sqrt(),
        }
    }

    /// Step response at a distance in pixels, with the model for sharp or for blurred images.
    #[inline(always)]
    pub(super) fn at<const SHARP: bool>(&self, distance: f32) -> Edge {
        let [share, density, spread] = if SHARP {
            self.sharp_at(distance)
        } else {
            self.blurred_at(distance)
        };
        let (z, of_halo, halo) = normal(distance * self.per_halo_sigma);
        let halo_density = of_halo * self.per_halo_sigma;
        let halo_spread = spread_of(z, self.per_halo_sigma, halo_density);
        [
            share + self.halo * (share - halo),
            density + self.halo * (density - halo_density),
            spread + self.halo * (spread - halo_spread),
            share - halo,
        ]
    }

    /// Mean of the normal distribution function over the width of the square, and its first derivatives.
    #[inline(always)]
    fn sharp_at(&self, distance: f32) -> [f32; 3] {
        let (half, per_width) = (0.5 * self.width, 1.0 / self.width);
        let far = until(distance + half, self.beside_width);
        let near = until(distance - half, self.beside_width);
        std::array::from_fn(|i| (far[i] - near[i]) * per_width)
    }

    /// The series of blur and square, and its first derivatives.
    #[inline(always)]
    fn blurred_at(&self, distance: f32) -> [f32; 3] {
        let (z, density, share) = normal(distance * self.per_sigma);
        let square = z * z;
        // Hermite polynomials of third and fourth order.
        let third = z * (square - 3.0);
        let fourth = square * (square - 6.0) + 3.0;
        let density_px = density * (1.0 + self.shape * fourth) * self.per_sigma;
        [
            share - self.shape * third * density,
            density_px,
            spread_of(z, self.per_sigma, density_px),
        ]
    }
}

/// Derivative of a step response with respect to the variance: half that of its density with respect to the distance.
#[inline(always)]
fn spread_of(z: f32, per_sigma: f32, density_px: f32) -> f32 {
    -0.5 * z * per_sigma * density_px
}

/// Of a Gaussian-blurred step: its integral up to a distance, its value, and the integral's derivative with respect to
/// the variance.
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

/// Upper tail of the normal distribution divided by its density (Abramowitz & Stegun, Handbook of Mathematical
/// Functions, 26.2.16, |error| < 1e-5).
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
    fn check_derivatives(at: impl Fn(f32, f32, f32) -> Edge, variance: f32) {
        const STEP: f32 = 0.02;
        const HALO: f32 = 0.6;
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let slope = |[distance_step, variance_step, halo_step]: [f32; 3]| {
                let share = |sign: f32| {
                    let (distance, variance) = (
                        distance + sign * distance_step,
                        variance + sign * variance_step,
                    );
                    at(distance, variance, HALO + sign * halo_step)[0]
                };
                (share(1.0) - share(-1.0)) / (2.0 * STEP)
            };
            let [value, derivatives @ ..] = at(distance, variance, HALO);
            assert!((value + at(-distance, variance, HALO)[0] - 1.0).abs() < 1e-4);
            let steps = [[STEP, 0.0, 0.0], [0.0, STEP, 0.0], [0.0, 0.0, STEP]];
            for (derivative, step) in derivatives.iter().zip(steps) {
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
        let blurred = |distance: f32, variance: f32, halo: f32| {
            let profile = Profile {
                shape: -0.02,
                ..Profile::new([1.0, 0.0], variance, halo)
            };
            profile.at::<false>(distance)
        };
        check_derivatives(blurred, 0.45);
        let sharp = |distance: f32, variance: f32, halo: f32| {
            Profile::new([0.8, 0.6], variance, halo).at::<true>(distance)
        };
        check_derivatives(sharp, 0.25);
    }

    #[test]
    fn a_sharpened_edge_goes_beyond_white_beside_it() {
        let profile = Profile::new([1.0, 0.0], 0.5, 1.0);
        assert!(profile.at::<false>(1.5)[0] > 1.1);
        assert!(profile.at::<false>(-1.5)[0] < -0.1);
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
