//! Tiles of 4x4 pixels: the extrema around each, whether their contrast exceeds the noise, and thresholds between
//! black and white.
//!
//! Input: an image. Output: thresholds for each tile, 0 where the contrast is within the noise. As in AprilTag 2 (Wang
//! & Olson, IROS 2016, section III-A), the extrema are those of the 3x3 tiles around each. The contrast gate is
//! measured here, so that noise costs no time in later stages.

use crate::Image;
use crate::kernels::{Levels, TILE, TILES_IN_WORD, TilesOfWord, WORD, vectorise};
use std::array;
use std::mem;
use std::ops::Range;

#[derive(Debug, Default)]
pub(crate) struct Tiles {
    columns: usize,
    rows: usize,
    words_in_row: usize,
    /// Extrema of each tile, row after row, with at least one neutral tile beyond the last.
    darkest: Vec<TilesOfWord>,
    brightest: Vec<TilesOfWord>,
    levels: Vec<Levels>,
    /// For each row, the range of words that contain live tiles.
    live_words: Vec<Range<usize>>,
    /// Minima and maxima of three tiles above each other, with neutral ones at both ends.
    columns_of_three: [Vec<u8>; 2],
}

/// Extremum of three tiles above each other, for each of a row, with one more at either end.
type Column = [u8];

impl Tiles {
    /// Allocates memory for an image of this size.
    fn make_room(&mut self, width: usize, height: usize) {
        (self.columns, self.rows) = (width / TILE, height / TILE);
        self.words_in_row = (self.columns + 1).div_ceil(TILES_IN_WORD);
        let n_words = self.words_in_row * self.rows;
        renew(&mut self.darkest, n_words, [u8::MAX; _]);
        renew(&mut self.brightest, n_words, [0; _]);
        self.levels.resize(n_words, Levels::default());
        self.live_words.resize(self.rows, 0..0);
        let length = self.words_in_row * TILES_IN_WORD + 2;
        for (column, neutral) in self.columns_of_three.iter_mut().zip([u8::MAX, 0]) {
            renew(column, length, neutral);
        }
    }

    /// Range of a row's words among all.
    fn row(&self, row: usize) -> Range<usize> {
        row * self.words_in_row..(row + 1) * self.words_in_row
    }

    /// Range of a row's tiles that contain pixels.
    fn whole_tiles(&self, row: usize) -> Range<usize> {
        let start = self.row(row).start * TILES_IN_WORD;
        start..start + self.columns
    }

    pub(crate) fn measure(&mut self, image: &Image<'_>) {
        self.make_room(image.width(), image.height());
        vectorise!({
            for row in 0..self.rows {
                let rows = [0, 1, 2, 3].map(|i| image.row(row * TILE + i));
                let tiles = self.whole_tiles(row);
                let darkest = &mut self.darkest.as_flattened_mut()[tiles.clone()];
                find_extrema(rows, darkest, &mut self.brightest.as_flattened_mut()[tiles]);
            }
        });
    }

    /// Standard deviation of the noise in grey levels, from the ranges of the flattest tiles.
    ///
    /// The range of 16 normal values has its tenth percentile at 2.6 sigma. Sixteen rows of tiles are sampled, without
    /// clipped tiles, whose noise is too small.
    pub(crate) fn noise_sigma(&self) -> f32 {
        const PERCENTILE: u32 = 10;
        const RANGE_IN_SIGMA: f32 = 2.6;
        const SAMPLED_ROWS: usize = 16;
        let mut counts = [0_u32; 256];
        for row in (0..self.rows).step_by(self.rows.div_ceil(SAMPLED_ROWS)) {
            let tiles = self.whole_tiles(row);
            let brightest = &self.brightest.as_flattened()[tiles.clone()];
            let darkest = &self.darkest.as_flattened()[tiles];
            for (&dark, &bright) in darkest.iter().zip(brightest) {
                let is_clipped = dark == 0 || bright == u8::MAX;
                counts[usize::from(bright - dark)] += u32::from(!is_clipped);
            }
        }
        let mut left = counts.iter().sum::<u32>() * PERCENTILE / 100;
        let range = counts.iter().position(|&count| {
            let here = count > left;
            left = left.saturating_sub(count);
            here
        });
        range.unwrap_or(0) as f32 / RANGE_IN_SIGMA
    }

    /// Whether at most a hundredth of the tiles, in a sample of rows, contain anything as bright as this.
    pub(crate) fn are_below(&self, bright: u8) -> bool {
        const SAMPLED_ROWS: usize = 8;
        let rows = (0..self.rows).step_by(self.rows.div_ceil(SAMPLED_ROWS));
        let (mut n, mut n_below) = (0, 0);
        for row in rows {
            let brightest = &self.brightest.as_flattened()[self.whole_tiles(row)];
            n += brightest.len();
            n_below += brightest.iter().filter(|grey| **grey < bright).count();
        }
        100 * (n - n_below) <= n
    }

    /// Sets the thresholds of tiles where black and white differ by at least the gate; returns whether there are any.
    ///
    /// A low threshold lies a quarter of the tile's own range above its minimum, unless that range is much less than
    /// the contrast around it, and above the noise of black.
    pub(crate) fn set_levels(&mut self, gate: u8) -> bool {
        let mut columns = mem::take(&mut self.columns_of_three);
        vectorise!({
            for row in 0..self.rows {
                self.set_row(row, gate, &mut columns);
            }
        });
        self.columns_of_three = columns;
        self.live_words.iter().any(|words| !words.is_empty())
    }

    #[inline(always)]
    fn set_row(&mut self, row: usize, gate: u8, columns: &mut [Vec<u8>; 2]) {
        let (words, beyond_noise) = (self.row(row), gate / 4 * 3);
        let [dark_column, bright_column] = columns;
        self.spread_down(u8::min, &self.darkest, row, dark_column);
        self.spread_down(u8::max, &self.brightest, row, bright_column);
        let extrema = self.darkest[words.clone()]
            .iter()
            .zip(&self.brightest[words.clone()]);
        let mut live = 0..0;
        let levels = self.levels[words].iter_mut().zip(extrema);
        for (i, (levels, (darkest, brightest))) in levels.enumerate() {
            let dark = spread_across(u8::min, dark_column, i);
            let bright = spread_across(u8::max, bright_column, i);
            // Contrast around a tile and within it.
            let around: TilesOfWord = array::from_fn(|i| bright[i].saturating_sub(dark[i]));
            let within: TilesOfWord = array::from_fn(|i| brightest[i].saturating_sub(darkest[i]));
            let level = |i: usize, up: u8| if around[i] >= gate { dark[i] + up } else { 0 };
            levels.depth = array::from_fn(|i| (around[i] / 8).max(beyond_noise));
            let up: TilesOfWord = array::from_fn(|i| levels.depth[i].max(within[i] / 4));
            levels.low = array::from_fn(|i| level(i, up[i]));
            levels.middle = array::from_fn(|i| level(i, around[i] / 2));
            if u128::from_ne_bytes(levels.low) != 0 {
                live = if live.is_empty() { i } else { live.start }..i + 1;
            }
        }
        self.live_words[row] = live;
    }

    /// Extremum of each tile of a row and those above and below it.
    #[inline(always)]
    fn spread_down(
        &self,
        pick: impl Fn(u8, u8) -> u8,
        extrema: &[TilesOfWord],
        row: usize,
        column: &mut Column,
    ) {
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.rows - 1)];
        let [above, here, below] = rows.map(|row| &extrema[self.row(row)]);
        let words: &mut [TilesOfWord] = column[1..].as_chunks_mut().0;
        for (((out, a), b), c) in words.iter_mut().zip(above).zip(here).zip(below) {
            *out = array::from_fn(|i| pick(pick(a[i], b[i]), c[i]));
        }
    }

    /// Thresholds of a row of tiles, the last of which also covers the pixels below it, and the range of words with
    /// live tiles.
    pub(crate) fn levels(&self, row: usize) -> (&[Levels], Range<usize>) {
        let row = row.min(self.rows - 1);
        (&self.levels[self.row(row)], self.live_words[row].clone())
    }
}

fn renew<T: Clone>(buffer: &mut Vec<T>, n: usize, value: T) {
    buffer.clear();
    buffer.resize(n, value);
}

/// Minimum and maximum of each tile of four rows, block by block: compilers vectorise loops of constant
/// length. Pixels beyond the last whole tile are ignored.
#[inline(always)]
fn find_extrema(rows: [&[u8]; TILE], darkest: &mut [u8], brightest: &mut [u8]) {
    let n_blocks = darkest.len() / TILES_IN_WORD;
    for block in 0..n_blocks {
        let [a, b, c, d] = rows.map(|row| &row.as_chunks::<WORD>().0[block]);
        let [mut low, mut high] = [[0_u8; WORD]; 2];
        for i in 0..WORD {
            low[i] = a[i].min(b[i]).min(c[i]).min(d[i]);
            high[i] = a[i].max(b[i]).max(c[i]).max(d[i]);
        }
        let tiles = block * TILES_IN_WORD..(block + 1) * TILES_IN_WORD;
        of_fours(&low, &mut darkest[tiles.clone()], u32::min);
        of_fours(&high, &mut brightest[tiles], u32::max);
    }
    for tile in n_blocks * TILES_IN_WORD..darkest.len() {
        let pixels = rows.iter().flat_map(|row| &row[tile * TILE..][..TILE]);
        darkest[tile] = pixels
            .clone()
            .fold(u8::MAX, |least, &pixel| least.min(pixel));
        brightest[tile] = pixels.fold(0, |most, &pixel| most.max(pixel));
    }
}

/// Reduces each four neighbours to one.
#[inline(always)]
fn of_fours(columns: &[u8; WORD], tiles: &mut [u8], pick: impl Fn(u32, u32) -> u32) {
    for (tile, four) in tiles.iter_mut().zip(columns.as_chunks::<TILE>().0) {
        let four = u32::from_le_bytes(*four);
        let [a, b, c, d] = [0, 8, 16, 24].map(|bits| four >> bits & 0xff);
        *tile = pick(pick(a, b), pick(c, d)) as u8;
    }
}

/// Extremum of each tile of a word and its neighbours.
#[inline(always)]
fn spread_across(pick: impl Fn(u8, u8) -> u8, column: &Column, word: usize) -> TilesOfWord {
    let near = &column[word * TILES_IN_WORD..][..TILES_IN_WORD + 2];
    array::from_fn(|i| pick(pick(near[i], near[i + 1]), near[i + 2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::vectorised;
    use proptest::prelude::*;

    fn rows() -> impl Strategy<Value = Vec<Vec<u8>>> {
        (1_usize..300).prop_flat_map(|width| {
            prop::collection::vec(prop::collection::vec(any::<u8>(), width), TILE)
        })
    }

    proptest! {
        #[test]
        fn extrema_are_those_of_each_tiles_pixels(rows in rows()) {
            let n_tiles = rows[0].len() / TILE;
            for best in [false, true] {
                let (mut darkest, mut brightest) = (vec![0; n_tiles], vec![0; n_tiles]);
                let pixels = [0, 1, 2, 3].map(|i| &rows[i][..]);
                let mut find = || find_extrema(pixels, &mut darkest, &mut brightest);
                if best { vectorised(&mut find) } else { find() }
                for tile in 0..n_tiles {
                    let pixels = rows.iter().flat_map(|row| &row[tile * TILE..][..TILE]);
                    prop_assert_eq!(pixels.clone().min(), Some(&darkest[tile]));
                    prop_assert_eq!(pixels.max(), Some(&brightest[tile]));
                }
            }
        }
    }
}
