//! Bayer to grey: by the manual's words for one pixel, and as weights of a binomial filter for whole images.
//!
//! With the weighted sums S of each colour, R = 4 S_R / 16, G = 2 S_G / 16 and B = 4 S_B / 16. Then Y = (76 R + 152 G +
//! 28 B) / 256 is (19 S_R + 19 S_G + 7 S_B) / 256: each pixel times the weight of its colour, filtered by \[1 2 1\]
//! down and across, over 256. All intermediate values fit 16 bits, since the greatest is 255 * 256.

use crate::Raster;
use crate::binomial::{self, BLOCK, Weights};
use crate::raster::Window;

/// Weights of red and green, and of blue.
const RED_GREEN: u16 = 19;
const BLUE: u16 = 7;

/// Weighted sums of the red, green and blue pixels of a window.
pub(crate) fn sums(window: &Window) -> [u32; 3] {
    const WEIGHTS: [[u32; 3]; 3] = [[1, 2, 1], [2, 4, 2], [1, 2, 1]];
    let [x_is_odd, y_is_odd] = window.is_odd;
    let mut sums = [0; 3];
    for (dy, (row, weights)) in window.rows.iter().zip(WEIGHTS).enumerate() {
        for (dx, (&pixel, weight)) in row.iter().zip(weights).enumerate() {
            // The middle of the window has index 1: its neighbours have the other parity.
            let column_is_odd = x_is_odd ^ (dx != 1);
            let row_is_odd = y_is_odd ^ (dy != 1);
            let colour = usize::from(column_is_odd) + usize::from(row_is_odd);
            sums[colour] += u32::from(pixel) * weight;
        }
    }
    sums
}

/// Y with one division.
pub(crate) fn luma([red, green, blue]: &[u32; 3], rounding: u32) -> u8 {
    let weighted = u32::from(RED_GREEN) * (red + green) + u32::from(BLUE) * blue;
    ((weighted + rounding) >> 8) as u8
}

/// Y of colours that were brought to bytes first, by truncation or, with `half` 1, by rounding.
pub(crate) fn luma_of_bytes([red, green, blue]: &[u32; 3], half: u32, rounding: u32) -> u8 {
    let (red, green, blue) = (
        (red + 2 * half) >> 2,
        (green + 4 * half) >> 3,
        (blue + 2 * half) >> 2,
    );
    ((76 * red + 152 * green + 28 * blue + rounding) >> 8) as u8
}

/// Y of a whole image with one division, `ROUNDING` added before it.
pub(crate) fn to_grey<const ROUNDING: u16>(input: &Raster<'_>, output: &mut [u8]) {
    const WEIGHTS: [Weights; 2] = [weights(false), weights(true)];
    binomial::filter::<8>(input, &WEIGHTS, ROUNDING, output);
}

/// Weights of a row of even or odd index.
const fn weights(row_is_odd: bool) -> Weights {
    let (mut own, mut beside) = ([2 * RED_GREEN; BLOCK], [RED_GREEN; BLOCK]);
    let mut i = 1;
    while i < BLOCK {
        if row_is_odd {
            own[i] = 2 * BLUE;
        } else {
            beside[i] = BLUE;
        }
        i += 2;
    }
    Weights { own, beside }
}
