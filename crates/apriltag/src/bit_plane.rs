//! Black or not, one bit a pixel.

use crate::Image;
use crate::kernels::{Kernels, TILE, WORD};
use crate::tiles::{Level, Tiles};

#[derive(Debug, Default)]
pub(crate) struct BitPlane {
    words_in_row: usize,
    words: Vec<u64>,
    levels: Vec<u8>,
}

impl BitPlane {
    /// Sets the bits of pixels below the level of their tile.
    pub(crate) fn threshold(
        &mut self,
        image: &Image<'_>,
        tiles: &Tiles,
        gate: u8,
        level: Level,
        kernels: &Kernels,
    ) {
        self.words_in_row = image.width().div_ceil(WORD);
        self.words.resize(self.words_in_row * image.height(), 0);
        for y in 0..image.height() {
            let tile_row = (y / TILE).min(tiles.rows() - 1);
            if y % TILE == 0 && y / TILE == tile_row {
                tiles.levels(tile_row, gate, level, &mut self.levels);
            }
            let words = &mut self.words[y * self.words_in_row..][..self.words_in_row];
            kernels.threshold_row(image.row(y), &self.levels, words);
        }
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = &[u64]> {
        self.words.chunks_exact(self.words_in_row)
    }
}
