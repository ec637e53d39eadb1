//! Of the border's colour or not, one bit a pixel.

use crate::Image;
use crate::kernels::{Kernels, TILES_IN_WORD, WORD};
use crate::tiles::Tiles;
use sextant_tag_families::BorderColour;
use std::ops::Range;

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    /// Of an even number of rows.
    words: Vec<u64>,
    /// Which words of each pair of rows have been set; the others are without bits.
    live: Vec<Range<usize>>,
}

/// Two rows of words, the second below the first, and those words beyond which neither has bits.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowPair<'a> {
    pub(crate) upper: &'a [u64],
    pub(crate) lower: &'a [u64],
    pub(crate) live: Range<usize>,
}

/// A row that is below every level.
const BLACK: [u8; Image::MAX_WIDTH] = [0; Image::MAX_WIDTH];

impl BitPlane {
    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.words_in_row = width.div_ceil(WORD);
        self.live.resize(height.div_ceil(2), 0..0);
        self.words
            .resize(self.words_in_row * 2 * self.live.len(), 0);
    }

    /// Sets the bits of the pixels that have the border's colour: below the level of their tile, or not below it.
    pub(crate) fn threshold(
        &mut self,
        image: &Image<'_>,
        tiles: &Tiles,
        border: BorderColour,
        kernels: &Kernels,
    ) {
        let mut live_bits = [0; Image::MAX_WIDTH / WORD];
        let pairs = self.words.chunks_exact_mut(2 * self.words_in_row);
        for (pair, (words, live)) in pairs.zip(&mut self.live).enumerate() {
            let (levels, live_tiles) = tiles.levels_at(2 * pair);
            let here = live_tiles.start..live_tiles.end.min(self.words_in_row);
            *live = here.clone();
            words.fill(0);
            if here.is_empty() {
                continue;
            }
            let levels = &levels[here.start * TILES_IN_WORD..here.end * TILES_IN_WORD];
            let columns = here.start * WORD..image.width().min(here.end * WORD);
            let rows = words.chunks_exact_mut(self.words_in_row);
            for (words, y) in rows.zip(2 * pair..image.height()) {
                let (pixels, words) = (&image.row(y)[columns.clone()], &mut words[here.clone()]);
                kernels.threshold_row(pixels, levels, words);
                if border == BorderColour::White {
                    kernels.threshold_row(
                        &BLACK[..pixels.len()],
                        levels,
                        &mut live_bits[here.clone()],
                    );
                    for (word, live) in words.iter_mut().zip(&live_bits[here.clone()]) {
                        *word ^= live;
                    }
                }
            }
        }
    }

    /// The words of a row.
    pub(crate) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_in_row..][..self.words_in_row]
    }

    pub(crate) fn row_pairs(&self) -> impl Iterator<Item = RowPair<'_>> {
        let pairs = self.words.chunks_exact(2 * self.words_in_row);
        pairs.zip(&self.live).map(|(words, live)| {
            let (upper, lower) = words.split_at(self.words_in_row);
            RowPair {
                upper,
                lower,
                live: live.clone(),
            }
        })
    }
}

/// The first and the last bit of a row that are set between two columns, and how many are.
#[inline(always)]
pub(crate) fn set_between(row: &[u64], first: u16, last: u16) -> Option<(u16, u16, u32)> {
    let ends = [first, last].map(|column| usize::from(column) / WORD);
    let from_first = u64::MAX << (first % WORD as u16);
    let up_to_last = u64::MAX >> (WORD as u16 - 1 - last % WORD as u16);
    let mut found = None;
    for (i, &word) in (ends[0]..).zip(&row[ends[0]..=ends[1]]) {
        let mut bits = word;
        if i == ends[0] {
            bits &= from_first;
        }
        if i == ends[1] {
            bits &= up_to_last;
        }
        if bits != 0 {
            let at = |bit: u32| (i * WORD) as u16 + bit as u16;
            let (first, _, n) = found.unwrap_or((at(bits.trailing_zeros()), 0, 0));
            found = Some((first, at(bits.ilog2()), n + bits.count_ones()));
        }
    }
    found
}

#[cfg(test)]
impl BitPlane {
    /// Of words, as many in each row, of an even number of rows.
    pub(crate) fn of_rows(rows: &[Vec<u64>]) -> Self {
        let is_live = |pair: &[Vec<u64>], i: &usize| pair[0][*i] | pair[1][*i] != 0;
        let live = |pair: &[Vec<u64>]| match (0..pair[0].len()).find(|i| is_live(pair, i)) {
            Some(first) => first..pair[0].len(),
            None => 0..0,
        };
        Self {
            words_in_row: rows[0].len(),
            words: rows.concat(),
            live: rows.chunks_exact(2).map(live).collect(),
        }
    }
}
