//! From a Bayer mosaic to grey, at full resolution and in place.
//!
//! Each pixel becomes the mean of its 3x3 neighbourhood with the binomial weights
//!
//! ```text
//!     1 2 1
//!     2 4 2   / 16
//!     1 2 1
//! ```
//!
//! Whatever its place in the mosaic, a half of that weight falls on green, a quarter each on red and blue: every pixel
//! is (R + 2 G + B) / 4 of its surroundings. So a grey scene under light of any colour has no pattern left in it
//! without a white balance, edges stay where they are (the weights are symmetric), and the order of the colours does
//! not matter. Beyond an edge the image is mirrored about its outermost pixel, which keeps the mosaic going.

/// The filter, with its rows of partial sums.
#[derive(Debug)]
pub(super) struct MosaicFilter {
    width: usize,
    /// Horizontal sums (1 2 1) of the row above, this row and the row below.
    sums: [Vec<u16>; 3],
}

impl MosaicFilter {
    /// A filter for images of this width.
    pub(super) fn new(width: usize) -> Self {
        Self {
            width,
            sums: std::array::from_fn(|_| vec![0; width]),
        }
    }

    /// Filters an image of whole rows.
    pub(super) fn apply(&mut self, pixels: &mut [u8]) {
        let width = self.width;
        if width == 0 || pixels.len() < width {
            return;
        }
        let last = pixels.len() / width - 1;
        let [above, here, below] = &mut self.sums;
        let row = |y: usize| y * width..(y + 1) * width;
        sum_row(&pixels[row(0)], here);
        sum_row(&pixels[row(last.min(1))], above);
        for y in 0..=last {
            match pixels.get(row(y + 1)) {
                Some(next) => sum_row(next, below),
                None => below.copy_from_slice(above),
            }
            combine([above, here, below], &mut pixels[row(y)]);
            std::mem::swap(above, here);
            std::mem::swap(here, below);
        }
    }
}

fn sum_row(row: &[u8], sums: &mut [u16]) {
    let last = row.len() - 1;
    let at = |x: usize| u16::from(row[x]);
    let (first_neighbour, last_neighbour) = (at(last.min(1)), at(last.saturating_sub(1)));
    sums[0] = 2 * at(0) + 2 * first_neighbour;
    sums[last] = 2 * at(last) + 2 * last_neighbour;
    for (neighbours, sum) in row.windows(3).zip(&mut sums[1..]) {
        let [left, middle, right] = [neighbours[0], neighbours[1], neighbours[2]].map(u16::from);
        *sum = left + 2 * middle + right;
    }
}

fn combine([above, here, below]: [&[u16]; 3], row: &mut [u8]) {
    let sums = above.iter().zip(here).zip(below);
    for (((above, here), below), grey) in sums.zip(row) {
        *grey = ((above + 2 * here + below + 8) >> 4) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sextant_simulator::Random;

    /// Mirrors an index about the outermost pixels.
    fn mirrored(index: isize, length: usize) -> usize {
        let last = length as isize - 1;
        let inside = if index < 0 { -index } else { index };
        let inside = if inside > last {
            2 * last - inside
        } else {
            inside
        };
        inside.clamp(0, last) as usize
    }

    fn naive(image: &[u8], [width, height]: [usize; 2], x: usize, y: usize) -> u8 {
        let mut sum = 0;
        for (dy, row_weight) in [(-1, 1), (0, 2), (1, 1)] {
            for (dx, weight) in [(-1, 1), (0, 2), (1, 1)] {
                let (row, column) = (
                    mirrored(y as isize + dy, height),
                    mirrored(x as isize + dx, width),
                );
                sum += row_weight * weight * u32::from(image[row * width + column]);
            }
        }
        ((sum + 8) / 16) as u8
    }

    proptest! {
        #[test]
        fn pixels_are_those_of_the_naive_twin(width in 1usize..20, height in 1usize..20, seed: u64) {
            let mut random = Random::new(seed);
            let image: Vec<u8> = (0..width * height).map(|_| random.bits() as u8).collect();
            let mut filtered = image.clone();
            let mut filter = MosaicFilter::new(width);
            filter.apply(&mut filtered);
            for y in 0..height {
                for x in 0..width {
                    prop_assert_eq!(filtered[y * width + x], naive(&image, [width, height], x, y), "{} {}", x, y);
                }
            }
        }
    }

    #[test]
    fn an_even_scene_has_no_pattern_under_light_of_any_colour() {
        let (width, height) = (9, 7);
        for order in [
            [[200, 120], [120, 40]],
            [[40, 120], [120, 200]],
            [[120, 200], [40, 120]],
            [[120, 40], [200, 120]],
        ] {
            let mut image: Vec<u8> = (0..width * height)
                .map(|n| order[n / width % 2][n % width % 2])
                .collect();
            MosaicFilter::new(width).apply(&mut image);
            assert!(image.iter().all(|grey| *grey == 120), "{image:?}");
        }
    }

    #[test]
    fn an_edge_stays_where_it_is() {
        let (width, height) = (12, 3);
        let mut image: Vec<u8> = (0..width * height)
            .map(|n| if n % width < 6 { 16 } else { 240 })
            .collect();
        MosaicFilter::new(width).apply(&mut image);
        let (left, right) = (u32::from(image[width + 5]), u32::from(image[width + 6]));
        assert_eq!(left + right, 16 + 240);
    }
}
