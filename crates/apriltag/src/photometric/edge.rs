//! What one straight blurred edge looks like.
//!
//! Blur is Gaussian, followed by the pixel's own square: across an edge the square is a trapezoid, here a box as wide as the
//! trapezoid's middle and a Gaussian with the rest of its variance.

use super::lanes::{LANES, Lanes};
use crate::quad::Point;

/// Variance of a pixel's square along either axis, in square pixels.
pub(super) const PIXEL: f32 = 1.0 / 12.0;

/// Share of the blur that lies beyond an edge, and the first and half the second derivative of that with the distance, per
/// pixel. Half the second derivative is also the derivative with the variance, as blur obeys the heat equation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Edge<Value = f32> {
    pub(super) share: Value,
    pub(super) density: Value,
    pub(super) spread: Value,
}

impl Edge {
    #[inline(always)]
    pub(super) fn minus(&self, other: &Self) -> Self {
        Self {
            share: self.share - other.share,
            density: self.density - other.density,
            spread: self.spread - other.spread,
        }
    }
}

/// How all edges of one direction look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    sigma: f32,
    width: f32,
    /// Distance beyond which all is black or white.
    pub(super) reach_px: f32,
}

impl Profile {
    /// Of edges across the direction `[nx, ny]`, for a blur with this covariance (xx, xy, yy).
    pub(super) fn new([nx, ny]: Point, blur: &[f32; 3]) -> Self {
        const LEAST_VARIANCE: f32 = 0.01;
        const SIGMAS: f32 = 3.2;
        let width = nx.abs().max(ny.abs());
        let gaussian = blur[0] * nx * nx + 2.0 * blur[1] * nx * ny + blur[2] * ny * ny;
        let sigma = (gaussian + (1.0 - width * width) * PIXEL)
            .max(LEAST_VARIANCE)
            .sqrt();
        Self {
            sigma,
            width,
            reach_px: SIGMAS * sigma + width / 2.0,
        }
    }

    /// At distances in pixels.
    #[inline(always)]
    pub(super) fn at(&self, distances: &Lanes, edge: &mut Edge<Lanes>) {
        let (half_width, per_sigma) = (self.width / 2.0, 1.0 / self.sigma);
        let (per_width, per_both) = (1.0 / self.width, 0.5 / (self.sigma * self.width));
        for i in 0..LANES {
            let (far, near) = (distances[i] + half_width, distances[i] - half_width);
            let (far_share, far_density) = normal(far * per_sigma);
            let (near_share, near_density) = normal(near * per_sigma);
            let (share, density) = (far_share - near_share, far_density - near_density);
            let integral = far * far_share - near * near_share + self.sigma * density;
            edge.share[i] = integral * per_width;
            edge.density[i] = share * per_width;
            edge.spread[i] = density * per_both;
        }
    }
}

/// The normal distribution function and its density (Abramowitz & Stegun, Handbook of Mathematical Functions, 26.2.16,
/// |error| < 1e-5).
#[inline(always)]
fn normal(z: f32) -> (f32, f32) {
    let x = z.abs().min(6.0);
    let density = 0.398_942_3 * exp_of_negative(-0.5 * x * x);
    let t = 1.0 / (1.0 + 0.332_67 * x);
    let tail = density * t * (0.436_183_6 + t * (-0.120_167_6 + t * 0.937_298));
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
}

/// e^x for x from -80 to 0, without a call: 2^n is put together from its bits, 2^f for |f| <= 1/2 is a Taylor series in
/// f ln 2 (|relative error| < 3e-6).
#[inline(always)]
fn exp_of_negative(x: f32) -> f32 {
    /// Adding it leaves the nearest whole number in the lowest bits.
    const SHIFT: f32 = 12_582_912.0;
    let power = x * std::f32::consts::LOG2_E;
    let shifted = power + SHIFT;
    let y = (power - (shifted - SHIFT)) * std::f32::consts::LN_2;
    let series =
        1.0 + y * (1.0 + y * (1.0 / 2.0 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0)))));
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
            assert!((fast / exact - 1.0).abs() < 1e-5, "{x}: {fast} {exact}");
        }
    }

    #[test]
    fn an_edges_density_and_spread_are_its_derivatives() {
        const STEP: f32 = 0.02;
        let profile = Profile::new([0.8, 0.6], &[0.4, -0.1, 0.2]);
        let at = |distance: f32| {
            let mut edge = Edge {
                share: [0.0; LANES],
                density: [0.0; LANES],
                spread: [0.0; LANES],
            };
            profile.at(&[distance; LANES], &mut edge);
            (edge.share[0], edge.density[0], edge.spread[0])
        };
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let (share, density, spread) = at(distance);
            let (before, after) = (at(distance - STEP), at(distance + STEP));
            let (slope, bend) = (
                (after.0 - before.0) / (2.0 * STEP),
                (after.1 - before.1) / (4.0 * STEP),
            );
            assert!((share + at(-distance).0 - 1.0).abs() < 1e-4, "{distance}");
            assert!(
                (density - slope).abs() < 2e-3,
                "{distance}: {density} {slope}"
            );
            assert!((spread - bend).abs() < 2e-3, "{distance}: {spread} {bend}");
        }
    }
}
