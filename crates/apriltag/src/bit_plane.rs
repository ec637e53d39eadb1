//! Of the border's colour or not, one bit a pixel.

use crate::Image;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD, WORD};
use crate::tiles::Tiles;
use sextant_tag_families::BorderColour;
use std::ops::Range;

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    words: Vec<u64>,
    /// Which words of each row have been set; the others are without bits.
    live: Vec<Range<usize>>,
}

/// The words of a row, and those of them beyond which there are no bits.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row<'a> {
    pub(crate) words: &'a [u64],
    pub(crate) live: Range<usize>,
}

impl BitPlane {
    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.words_in_row = width.div_ceil(WORD);
        self.words.resize(self.words_in_row * height, 0);
        self.live.resize(height, 0..0);
    }

    /// Sets the bits of the pixels that have the border's colour: below the level of their tile, or not below it.
    pub(crate) fn threshold(
        &mut self,
        image: &Image<'_>,
        tiles: &Tiles,
        border: BorderColour,
        kernels: &Kernels,
    ) {
        self.words.fill(0);
        for (y, live_here) in self.live.iter_mut().enumerate() {
            let (levels, live) = tiles.levels_at(y);
            let live = live.start..live.end.min(self.words_in_row);
            *live_here = live.clone();
            if live.is_empty() {
                continue;
            }
            let pixels = &image.row(y)[live.start * WORD..image.width().min(live.end * WORD)];
            let levels = &levels[live.start * TILES_IN_WORD..live.end * TILES_IN_WORD];
            let words = &mut self.words[y * self.words_in_row..][live];
            kernels.threshold_row(pixels, levels, words);
            if border == BorderColour::White {
                invert_live(words, levels, pixels.len());
            }
        }
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        let rows = self.words.chunks_exact(self.words_in_row).zip(&self.live);
        rows.map(|(words, live)| Row {
            words,
            live: live.clone(),
        })
    }
}

#[cfg(test)]
impl BitPlane {
    /// Of words, as many in each row.
    pub(crate) fn of_rows(rows: &[Vec<u64>]) -> Self {
        let live = |row: &Vec<u64>| match row.iter().position(|word| *word != 0) {
            Some(first) => first..row.len(),
            None => 0..0,
        };
        Self {
            words_in_row: rows[0].len(),
            words: rows.concat(),
            live: rows.iter().map(live).collect(),
        }
    }
}

/// Turns the bits of the first `width` pixels over where their tiles have a level.
fn invert_live(words: &mut [u64], levels: &[u8], width: usize) {
    const TILE_BITS: u64 = (1 << TILE) - 1;
    let levels = levels.chunks(TILES_IN_WORD);
    for (i, (word, levels)) in words.iter_mut().zip(levels).enumerate() {
        let live = levels.iter().rev().fold(0, |bits, &level| {
            bits << TILE | if level > 0 { TILE_BITS } else { 0 }
        });
        let within = width - i * WORD;
        let image = if within < WORD {
            (1 << within) - 1
        } else {
            u64::MAX
        };
        *word = !*word & live & image;
    }
}
