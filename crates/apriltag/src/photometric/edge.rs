//! What one straight blurred edge looks like.
//!
//! Blur is Gaussian, followed by the pixel's own square: across an edge the square is a trapezoid, here a box as wide as the
//! trapezoid's middle and a Gaussian with the rest of its variance.

use crate::quad::Point;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Share of the blur that lies beyond an edge, and the first and half the second derivative of that with the distance, per
/// pixel. Half the second derivative is also the derivative with the variance, as blur obeys the heat equation.
pub(super) type Edge = [f32; 3];

/// How all edges of one direction look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    sigma: f32,
    per_sigma: f32,
    width: f32,
    per_width: f32,
}

impl Profile {
    /// Of edges across the direction `[nx, ny]`, for this variance of the blur and the square together.
    pub(super) fn new([nx, ny]: Point, variance: f32) -> Self {
        const LEAST_VARIANCE: f32 = 0.01;
        let width = nx.abs().max(ny.abs());
        let sigma = (variance - width * width * PIXEL)
            .max(LEAST_VARIANCE)
            .sqrt();
        Self {
            sigma,
            per_sigma: 1.0 / sigma,
            width,
            per_width: 1.0 / width,
        }
    }

    /// At a distance in pixels.
    #[inline(always)]
    pub(super) fn at(&self, distance: f32) -> Edge {
        let (far, near) = (distance + 0.5 * self.width, distance - 0.5 * self.width);
        let (far_share, far_density) = normal(far * self.per_sigma);
        let (near_share, near_density) = normal(near * self.per_sigma);
        let density = far_density - near_density;
        let integral = far * far_share - near * near_share + self.sigma * density;
        [
            integral * self.per_width,
            (far_share - near_share) * self.per_width,
            0.5 * density * self.per_sigma * self.per_width,
        ]
    }
}

/// The normal distribution function and its density (Abramowitz & Stegun, Handbook of Mathematical Functions, 26.2.16,
/// |error| < 1e-5).
#[inline(always)]
fn normal(z: f32) -> (f32, f32) {
    // Not by `min`, which calls a library on 32-bit ARM.
    let x = if z.abs() < 6.0 { z.abs() } else { 6.0 };
    let density = 0.398_942_3 * exp_of_negative(-0.5 * x * x);
    let t = 1.0 / (1.0 + 0.332_67 * x);
    let tail = density * t * (0.436_183_6 + t * (-0.120_167_6 + t * 0.937_298));
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
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
    fn an_edges_density_and_spread_are_its_derivatives() {
        const STEP: f32 = 0.02;
        let profile = Profile::new([0.8, 0.6], 0.45);
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let [share, density, spread] = profile.at(distance);
            let (before, after) = (profile.at(distance - STEP), profile.at(distance + STEP));
            let slope = (after[0] - before[0]) / (2.0 * STEP);
            let bend = (after[1] - before[1]) / (4.0 * STEP);
            assert!((share + profile.at(-distance)[0] - 1.0).abs() < 1e-4);
            assert!(
                (density - slope).abs() < 2e-3,
                "{distance}: {density} {slope}"
            );
            assert!((spread - bend).abs() < 2e-3, "{distance}: {spread} {bend}");
        }
    }
}
