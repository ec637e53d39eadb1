//! Of the border's colour or not, one bit a pixel.

use crate::Image;
use crate::components::make_room;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD, WORD};
use crate::tiles::{Pass, Tiles};
use sextant_tag_families::BorderColour;

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    words: Vec<u64>,
    levels: Vec<u8>,
}

impl BitPlane {
    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.words_in_row = width.div_ceil(WORD);
        self.words.resize(self.words_in_row * height, 0);
        make_room(
            &mut self.levels,
            (width / TILE + 1).next_multiple_of(TILES_IN_WORD),
        );
    }

    /// Sets the bits of the pixels that have the border's colour: below the level of their tile, or not below it.
    pub(crate) fn threshold(
        &mut self,
        image: &Image<'_>,
        tiles: &Tiles,
        pass: Pass,
        kernels: &Kernels,
    ) {
        for y in 0..image.height() {
            let tile_row = (y / TILE).min(tiles.rows() - 1);
            if y % TILE == 0 && y / TILE == tile_row {
                tiles.levels(tile_row, pass.level, &mut self.levels);
            }
            let words = &mut self.words[y * self.words_in_row..][..self.words_in_row];
            kernels.threshold_row(image.row(y), &self.levels, words);
            if pass.border == BorderColour::White {
                invert_live(words, &self.levels, image.width());
            }
        }
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.words_in_row)
    }
}

/// Turns the bits of the first `width` pixels over where their tiles have a level.
fn invert_live(words: &mut [u64], levels: &[u8], width: usize) {
    const TILE_BITS: u64 = (1 << TILE) - 1;
    for (i, (word, levels)) in words
        .iter_mut()
        .zip(levels.chunks(TILES_IN_WORD))
        .enumerate()
    {
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
