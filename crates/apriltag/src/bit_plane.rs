//! Of the border's colour or not, one bit a pixel.

use crate::Image;
use crate::components::Span;
use crate::kernels::{TILE, TILES_IN_WORD, WORD, threshold_row};
use crate::tiles::Tiles;
use sextant_tag_families::BorderColour;
use std::ops::Range;

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    /// Of an even number of rows.
    words: Vec<u64>,
    /// Which words of each row of tiles have been set; the others are without bits.
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
        self.live.resize(height.div_ceil(TILE), 0..0);
        self.words
            .resize(self.words_in_row * height.next_multiple_of(2), 0);
    }

    /// Sets the bits of the pixels that have the border's colour: below the level of their tile, or not below it.
    #[inline(always)]
    pub(crate) fn threshold(&mut self, image: &Image<'_>, tiles: &Tiles, border: BorderColour) {
        let mut live_bits = [0; Image::MAX_WIDTH / WORD];
        let rows_of_tiles = self.words.chunks_mut(TILE * self.words_in_row);
        for (row, (words, live)) in rows_of_tiles.zip(&mut self.live).enumerate() {
            let (levels, live_words) = tiles.levels(row);
            let here = live_words.start..live_words.end.min(self.words_in_row);
            *live = here.clone();
            words.fill(0);
            if here.is_empty() {
                continue;
            }
            let levels = &levels[here.start * TILES_IN_WORD..here.end * TILES_IN_WORD];
            let columns = here.start * WORD..image.width().min(here.end * WORD);
            let live_bits = &mut live_bits[here.clone()];
            if border == BorderColour::White {
                threshold_row(&BLACK[columns.clone()], levels, live_bits);
            }
            let rows = words.chunks_exact_mut(self.words_in_row);
            for (words, y) in rows.zip(row * TILE..image.height()) {
                let words = &mut words[here.clone()];
                threshold_row(&image.row(y)[columns.clone()], levels, words);
                if border == BorderColour::White {
                    for (word, live) in words.iter_mut().zip(&*live_bits) {
                        *word ^= live;
                    }
                }
            }
        }
    }

    /// The words of each row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.words_in_row)
    }

    /// The words of a row.
    pub(crate) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_in_row..][..self.words_in_row]
    }

    pub(crate) fn row_pairs(&self) -> impl Iterator<Item = RowPair<'_>> {
        let pairs = self.words.chunks_exact(2 * self.words_in_row);
        pairs.enumerate().map(|(pair, words)| {
            let (upper, lower) = words.split_at(self.words_in_row);
            let live = self.live[2 * pair / TILE].clone();
            RowPair { upper, lower, live }
        })
    }
}

/// The first bit of a row that is set within a span, the one beyond the last, and how many are; an empty span where none are.
#[inline(always)]
pub(crate) fn set_between(row: &[u64], [start, end]: Span) -> (Span, u32) {
    let [start, last] = [start, end - 1].map(usize::from);
    let (mut first, mut beyond, mut n) = (0, 0, 0);
    let mut mask = u64::MAX << (start % WORD);
    let mut i = start / WORD;
    while i <= last / WORD {
        if i == last / WORD {
            mask &= u64::MAX >> (WORD - 1 - last % WORD);
        }
        let bits = row[i] & mask;
        if bits != 0 {
            let here = i * WORD + bits.trailing_zeros() as usize;
            first = if n == 0 { here } else { first };
            beyond = i * WORD + WORD - bits.leading_zeros() as usize;
            n += bits.count_ones();
        }
        mask = u64::MAX;
        i += 1;
    }
    ([first as u16, beyond as u16], n)
}

#[cfg(test)]
impl BitPlane {
    /// Of words, as many in each row, of an even number of rows.
    pub(crate) fn of_rows(rows: &[Vec<u64>]) -> Self {
        let is_live = |rows: &[Vec<u64>], i: usize| rows.iter().any(|row| row[i] != 0);
        let live = |rows: &[Vec<u64>]| match (0..rows[0].len()).find(|i| is_live(rows, *i)) {
            Some(first) => first..rows[0].len(),
            None => 0..0,
        };
        Self {
            words_in_row: rows[0].len(),
            words: rows.concat(),
            live: rows.chunks(TILE).map(live).collect(),
        }
    }
}
