//! The binary image: one bit per pixel, set where the pixel has the colour of a border.

use crate::kernels::{
    LINE_REACH, PaddedRows, TILE, WORD, is_beyond, is_black_or_line, padded_length, threshold,
};
use crate::tiles::Tiles;
use crate::{Image, Pass};
use std::array;
use std::ops::Range;

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    /// Rows of words, for complete rows of tiles.
    words: Vec<u64>,
    /// Copy of a row before erosion.
    above: Vec<u64>,
    /// Range of words in each row of tiles that may have bits.
    live: Vec<Range<usize>>,
    /// Ring buffer of padded image rows, and the length of one.
    rows: Vec<u8>,
    row_length: usize,
}

/// Two rows of words, the second below the first, and the range of words that may have bits.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowPair<'a> {
    pub(crate) upper: &'a [u64],
    pub(crate) lower: &'a [u64],
    pub(crate) live: Range<usize>,
}

impl BitPlane {
    /// Allocates memory for an image of this size.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.words_in_row = width.div_ceil(WORD);
        self.above.resize(self.words_in_row, 0);
        self.live.resize(height.div_ceil(TILE), 0..0);
        self.words
            .resize(self.words_in_row * height.next_multiple_of(TILE), 0);
        self.row_length = padded_length(width);
        self.rows
            .resize(self.rows.len().max(ROWS * self.row_length), 0);
    }

    /// Sets the bits of the pixels that have the border's colour. [`Pass::Eroded`] takes those of the pass before.
    #[inline(always)]
    pub(crate) fn threshold(&mut self, image: &Image<'_>, tiles: &Tiles, pass: Pass) {
        let beyond = match pass {
            Pass::Eroded => return self.erode(),
            Pass::Black | Pass::Middle => u8::MAX,
            Pass::White => 0,
        };
        for row in self.rows.chunks_exact_mut(self.row_length) {
            row[..LINE_REACH].fill(beyond);
            row[LINE_REACH + image.width()..].fill(beyond);
        }
        let mut taken = 0;
        let rows_of_tiles = self.words.chunks_exact_mut(TILE * self.words_in_row);
        for (row, (words, live)) in rows_of_tiles.zip(&mut self.live).enumerate() {
            let (levels, live_words) = tiles.levels(row);
            let here = live_words.start..live_words.end.min(self.words_in_row);
            *live = here.clone();
            words.fill(0);
            if here.is_empty() {
                continue;
            }
            let ys = row * TILE..(row + 1) * TILE + 2 * LINE_REACH;
            take_rows(
                image,
                taken.max(ys.start)..ys.end,
                self.row_length,
                &mut self.rows,
            );
            taken = ys.end;
            let rows: PaddedRows<'_> = array::from_fn(|i| {
                let place = (ys.start + i) % ROWS * self.row_length;
                &self.rows[place..place + self.row_length]
            });
            let (levels, first) = (&levels[here.clone()], here.start);
            match pass {
                Pass::Black => threshold(&rows, levels, first, words, is_black_or_line),
                Pass::White => threshold(&rows, levels, first, words, is_beyond::<false>),
                _ => threshold(&rows, levels, first, words, is_beyond::<true>),
            }
        }
        self.words[image.height() * self.words_in_row..].fill(0);
    }

    /// Leaves only words with columns and rows of a rectangle.
    pub(crate) fn keep(&mut self, columns: &Range<u32>, rows: &Range<u32>) {
        let words = columns.start as usize / WORD..(columns.end as usize).div_ceil(WORD);
        let tiles = rows.start as usize / TILE..(rows.end as usize).div_ceil(TILE);
        for (row, live) in self.live.iter_mut().enumerate() {
            *live = match tiles.contains(&row) {
                true => live.start.max(words.start)..live.end.min(words.end),
                false => 0..0,
            };
            if live.start >= live.end {
                *live = 0..0;
            }
        }
    }

    /// Erodes the plane: clears bits with a clear neighbour to the left, right, above or below, and those between two
    /// diagonal clear ones, since corners that touch within a pixel would stay connected. Pixels outside the words that
    /// are kept are clear.
    #[inline(always)]
    fn erode(&mut self) {
        self.above.fill(0);
        let n = self.words_in_row;
        let at = |row: &[u64], i: usize| row.get(i).copied().unwrap_or(0);
        for row in 0..self.words.len() / n {
            let live = self.live[row / TILE].clone();
            if live.start >= live.end {
                self.above.fill(0);
                continue;
            }
            let (here, below) = self.words[row * n..].split_at_mut(n);
            let mut before = [0; 3];
            for i in live {
                let words = [self.above[i], here[i], at(below, i)];
                let after = [at(&self.above, i + 1), at(here, i + 1), at(below, i + 1)];
                let left = |row: usize| words[row] << 1 | before[row] >> (WORD - 1);
                let right = |row: usize| words[row] >> 1 | after[row] << (WORD - 1);
                let beside = left(1) & right(1) & words[0] & words[2];
                let across = (left(0) | right(2)) & (right(0) | left(2));
                here[i] &= beside & across;
                self.above[i] = words[1];
                before = words;
            }
        }
    }

    /// One word per row, starting at a column and a row; columns beyond the last are undefined.
    #[inline(always)]
    pub(crate) fn strip(&self, column: usize, row: usize) -> impl Iterator<Item = u64> {
        let (word, shift) = (column / WORD, column % WORD);
        let next = (word + 1).min(self.words_in_row - 1);
        let rows = self.words[row * self.words_in_row..].chunks_exact(self.words_in_row);
        rows.map(move |row| row[word] >> shift | row[next] << 1 << (WORD - 1 - shift))
    }

    pub(crate) fn is_set(&self, [x, y]: [u16; 2]) -> bool {
        let (x, y) = (usize::from(x), usize::from(y));
        self.words[y * self.words_in_row + x / WORD] >> (x % WORD) & 1 == 1
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

/// Size of the ring buffer: the rows of a row of tiles and those within the reach of a line above and below.
const ROWS: usize = 16;

/// Loads rows, counted from the reach of a line above the image; outside the image the nearest rows are repeated.
fn take_rows(image: &Image<'_>, rows: Range<usize>, row_length: usize, taken: &mut [u8]) {
    for row in rows {
        let y = row.saturating_sub(LINE_REACH).min(image.height() - 1);
        let padded = &mut taken[row % ROWS * row_length..][..row_length];
        padded[LINE_REACH..][..image.width()].copy_from_slice(image.row(y));
    }
}

#[cfg(test)]
impl BitPlane {
    /// A plane from words, with equally long rows and an even number of them.
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
            ..Self::default()
        }
    }
}
