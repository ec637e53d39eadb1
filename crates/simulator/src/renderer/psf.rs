//! Blur of a lens: a small round Gaussian on the pixel grid.

/// Half of a symmetric, normalised kernel, from the centre outwards.
#[derive(Clone, Debug)]
pub(crate) struct Psf {
    taps: Vec<f32>,
}

impl Psf {
    /// Gaussian of `sigma_px`, cut off at 3 sigma; 0 is no blur.
    pub fn gaussian(sigma_px: f64) -> Self {
        let radius = (3.0 * sigma_px).ceil() as usize;
        let tap = |i: usize| libm::exp(-0.5 * (i as f64 / sigma_px) * (i as f64 / sigma_px));
        let side: Vec<f64> = (1..=radius).map(tap).collect();
        let total = 1.0 + 2.0 * side.iter().sum::<f64>();
        let taps = std::iter::once(1.0).chain(side).map(|t| (t / total) as f32);
        Self {
            taps: taps.collect(),
        }
    }

    /// Radius of the kernel in pixels.
    pub fn radius(&self) -> usize {
        self.taps.len() - 1
    }

    /// Blurs along a row: `out[i]` from `row[i..i + 2 radius + 1]`.
    pub fn blur_row(&self, row: &[f32], out: &mut [f32]) {
        let (n, radius) = (out.len(), self.radius());
        let window = |offset: usize| &row[offset..offset + n];
        weigh(out, window(radius), self.taps[0]);
        for (i, &tap) in self.taps.iter().enumerate().skip(1) {
            weigh_pair(out, window(radius - i), window(radius + i), tap);
        }
    }

    /// Blurs columns: `out` from the `2 radius + 1` rows that `row` returns.
    pub fn blur_column<'a>(&self, row: impl Fn(usize) -> &'a [f32], out: &mut [f32]) {
        let radius = self.radius();
        weigh(out, row(radius), self.taps[0]);
        for (i, &tap) in self.taps.iter().enumerate().skip(1) {
            weigh_pair(out, row(radius - i), row(radius + i), tap);
        }
    }
}

/// Adds values times a tap of the kernel.
pub(super) fn weigh_add(out: &mut [f32], values: &[f32], tap: f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += tap * value;
    }
}

fn weigh(out: &mut [f32], values: &[f32], tap: f32) {
    for (out, value) in out.iter_mut().zip(values) {
        *out = tap * value;
    }
}

fn weigh_pair(out: &mut [f32], before: &[f32], after: &[f32], tap: f32) {
    for ((out, before), after) in out.iter_mut().zip(before).zip(after) {
        *out += tap * (before + after);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blur_keeps_the_sum_and_spreads_by_sigma() {
        let psf = Psf::gaussian(0.8);
        let (n, middle) = (21, 10);
        let mut row = vec![0.0; n + 2 * psf.radius()];
        row[middle + psf.radius()] = 100.0;
        let mut out = vec![0.0; n];
        psf.blur_row(&row, &mut out);
        let sum: f32 = out.iter().sum();
        let spread: f32 = out
            .iter()
            .enumerate()
            .map(|(i, v)| v * (i as f32 - middle as f32).powi(2))
            .sum();
        assert!((sum - 100.0).abs() < 1e-3);
        assert!(((spread / sum).sqrt() - 0.8).abs() < 0.02);
    }

    #[test]
    fn no_blur_changes_nothing() {
        let psf = Psf::gaussian(0.0);
        assert_eq!(psf.radius(), 0);
        let mut out = [0.0; 3];
        psf.blur_row(&[1.0, 2.0, 3.0], &mut out);
        assert_eq!(out, [1.0, 2.0, 3.0]);
    }
}
