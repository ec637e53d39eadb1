//! Defocus: the uniform disk into which a defocused lens spreads a point.

use super::psf::weigh_add;

/// Samples of a pixel of the kernel in x and y.
const SAMPLES: usize = 16;

/// A normalised kernel: rows from top to bottom, each from left to right.
pub(super) struct Disk {
    radius: usize,
    taps: Vec<f32>,
}

impl Disk {
    /// A disk of this radius, px; 0 is no defocus.
    pub fn new(radius_px: f64) -> Self {
        let radius = (radius_px - 0.5).max(0.0).ceil() as usize;
        let reach = radius as i32;
        let covered = |x: i32, y: i32| {
            let at = |i: usize, n: i32| f64::from(n) - 0.5 + (i as f64 + 0.5) / SAMPLES as f64;
            let inside = |i: usize| at(i % SAMPLES, x).hypot(at(i / SAMPLES, y)) < radius_px;
            (0..SAMPLES * SAMPLES).filter(|&i| inside(i)).count() as f64
        };
        let cells = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
        let areas: Vec<f64> = cells.map(|(x, y)| covered(x, y)).collect();
        let total: f64 = areas.iter().sum();
        Self {
            radius,
            taps: areas.iter().map(|area| (area / total) as f32).collect(),
        }
    }

    /// Radius of the kernel in whole pixels.
    pub fn radius(&self) -> usize {
        self.radius
    }

    /// Convolves rows of `stride` values; rows of `out` are shorter by twice the radius, and there are as many fewer of
    /// them.
    pub fn blur(&self, rows: &[f32], stride: usize, out: &mut [f32]) {
        let width = 2 * self.radius + 1;
        let n = stride - 2 * self.radius;
        let n_rows = (rows.len() / stride).saturating_sub(2 * self.radius);
        for (y, out) in out.chunks_exact_mut(n).take(n_rows).enumerate() {
            out.fill(0.0);
            for (i, &tap) in self.taps.iter().enumerate() {
                let start = (y + i / width) * stride + i % width;
                weigh_add(out, &rows[start..start + n], tap);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_an_even_disk_of_its_radius() {
        let disk = Disk::new(3.0);
        let (stride, n) = (21, 21 - 2 * disk.radius());
        let mut rows = vec![0.0; stride * stride];
        rows[10 * stride + 10] = 1000.0;
        let mut out = vec![0.0; n * n];
        disk.blur(&rows, stride, &mut out);
        let sum: f32 = out.iter().sum();
        assert!((sum - 1000.0).abs() < 0.01);
        let middle = n / 2;
        let level = 1000.0 / (9.0 * std::f32::consts::PI);
        let at = |x: usize, y: usize| out[y * n + x];
        assert!((at(middle, middle) - level).abs() < 0.02 * level);
        assert!((at(middle + 2, middle) - level).abs() < 0.02 * level);
        assert_eq!(at(middle + 4, middle), 0.0);
    }
}
