//! Black or not, one bit a pixel.

use crate::Image;
use crate::components::make_room;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD, WORD};
use crate::tiles::{Level, Tiles};

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

    /// Sets the bits of pixels below the level of their tile.
    pub(crate) fn threshold(
        &mut self,
        image: &Image<'_>,
        tiles: &Tiles,
        gate: u8,
        level: Level,
        kernels: &Kernels,
    ) {
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
