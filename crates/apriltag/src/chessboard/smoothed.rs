//! An image as floating-point greys, smoothed with a standard deviation of 1.4 pixels.

use crate::Image;
use crate::quad::Point;

/// A smoothed image.
#[derive(Clone, Debug)]
pub(super) struct Smoothed {
    greys: Vec<f32>,
    width: usize,
    height: usize,
}

impl Smoothed {
    pub(super) fn smooth(image: &Image<'_>) -> Self {
        let (width, height) = (image.width(), image.height());
        let mut greys = Vec::with_capacity(width * height);
        for y in 0..height {
            let row: Vec<f32> = image.row(y).iter().map(|&grey| f32::from(grey)).collect();
            let at = |x: isize| row[x.clamp(0, width as isize - 1) as usize];
            greys.extend((0..width as isize).map(|x| binomial(|by| at(x + by))));
        }
        let mut smoothed = Vec::with_capacity(width * height);
        for y in 0..height as isize {
            let rows: [&[f32]; 9] = std::array::from_fn(|i| {
                let y = (y + i as isize - REACH).clamp(0, height as isize - 1) as usize;
                &greys[y * width..][..width]
            });
            smoothed.extend((0..width).map(|x| binomial(|by| rows[(by + REACH) as usize][x])));
        }
        Self {
            greys: smoothed,
            width,
            height,
        }
    }

    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn height(&self) -> usize {
        self.height
    }

    pub(super) fn row(&self, y: usize) -> &[f32] {
        &self.greys[y * self.width..][..self.width]
    }

    /// Interpolated grey at a point; `None` outside the image.
    pub(super) fn sample(&self, [x, y]: Point) -> Option<f32> {
        let is_inside =
            x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f32 && y < (self.height - 1) as f32;
        if !is_inside {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        let (right, down) = (x - column as f32, y - row as f32);
        let [above, below] = [row, row + 1].map(|row| {
            let greys = &self.row(row)[column..];
            greys[0] + right * (greys[1] - greys[0])
        });
        Some(above + down * (below - above))
    }
}

/// Pixels on either side of the filter.
const REACH: isize = 4;

/// The binomial filter of order 8: a standard deviation of 1.4 pixels.
#[inline(always)]
fn binomial(at: impl Fn(isize) -> f32) -> f32 {
    const WEIGHTS: [f32; 5] = [70.0, 56.0, 28.0, 8.0, 1.0];
    let sides = (1..=REACH).map(|by| WEIGHTS[by as usize] * (at(by) + at(-by)));
    (WEIGHTS[0] * at(0) + sides.sum::<f32>()) / 256.0
}
