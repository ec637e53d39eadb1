//! What one straight blurred edge looks like.
//!
//! Blur is a Gaussian; what makes it another shape is told by the halo: that many times the Gaussian more, and one twice as
//! wide that many times less. Sharpening does just that and leaves halos beside the edges; the blur of an open aperture, of
//! motion and of the pixel's own square ends as abruptly; with glare it is the other way round.

/// Share of the blur that lies beyond an edge, its derivative with the distance, per pixel, with the Gaussian's variance, per
/// square pixel, and with the halo.
pub(super) type Edge = [f32; 4];

/// How all edges of one direction look.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    per_sigma: f32,
    halo: f32,
}

impl Profile {
    pub(super) fn new(variance: f32, halo: f32) -> Self {
        Self {
            per_sigma: 1.0 / variance.sqrt(),
            halo,
        }
    }

    /// At a distance in pixels.
    #[inline(always)]
    pub(super) fn at(&self, distance: f32) -> Edge {
        const FAR: f32 = 12.0;
        let z = distance * self.per_sigma;
        // Not by `min`, which calls a library on 32-bit ARM.
        let x = if z.abs() < FAR { z.abs() } else { FAR };
        let root = exp_of_negative(-0.125 * x * x);
        let square = root * root;
        let (density, wide_density) = (PEAK * square * square, PEAK * root * 0.5);
        let tail = density * tail_over_density(x);
        let wide_tail = PEAK * root * tail_over_density(x * 0.5);
        let less = tail - wide_tail;
        let beyond = tail + self.halo * less;
        let density = (density + self.halo * (density - wide_density)) * self.per_sigma;
        let (share, with_halo) = if z < 0.0 {
            (beyond, less)
        } else {
            (1.0 - beyond, -less)
        };
        let with_variance = -0.5 * z * self.per_sigma * density;
        [share, density, with_variance, with_halo]
    }
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
        const STEP: f32 = 0.02;
        let (variance, halo) = (0.45, 0.4);
        let share =
            |distance: f32, variance: f32, halo: f32| Profile::new(variance, halo).at(distance)[0];
        for i in -100..=100 {
            let distance = 0.04 * i as f32;
            let [value, derivatives @ ..] = Profile::new(variance, halo).at(distance);
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
        let profile = Profile::new(1.0, 1.0);
        assert!(profile.at(2.2)[0] > 1.03);
        assert!(profile.at(-2.2)[0] < -0.03);
    }
}
