//! Tiles of 4x4 pixels: what is dark and bright around each, whether that is more than noise, and the level that
//! separates black from white there.
//!
//! In: an image. Out: a level for each tile, 0 where nothing stands out from the noise. As in AprilTag 2 (Wang & Olson,
//! IROS 2016, section III-A) the extrema are taken over the 3x3 tiles around each; the gate is measured here, so that
//! noise costs no time further on.

use crate::Image;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD};
use crate::shade::Shade;
use sextant_tag_families::BorderColour;

/// Where between the darkest and the brightest value around a tile the level lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Half way: where black and white are all there is.
    Middle,
    /// Near the dark end: where something brighter than a tag's white stands beside the tag.
    Shaded,
}

/// One way to tell the pixels of a border from others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Colour of the borders that are looked for.
    pub border: BorderColour,
    /// Where black is parted from white.
    pub level: Level,
}

#[derive(Debug, Default)]
pub(crate) struct Tiles {
    /// Least contrast of a live tile, in grey levels.
    gate: u8,
    columns: usize,
    rows: usize,
    /// Extrema of each tile, row after row.
    darkest: Vec<u8>,
    brightest: Vec<u8>,
    /// Extrema of the 3x3 tiles around each.
    dark_around: Vec<u8>,
    bright_around: Vec<u8>,
    /// One row of what is worked on: extrema of three tiles above each other, with one more at either end; flags.
    column_darkest: Vec<u8>,
    column_brightest: Vec<u8>,
    shade: Shade,
}

impl Tiles {
    pub(crate) fn measure(&mut self, image: &Image<'_>, kernels: &Kernels) {
        for row in 0..self.rows {
            let rows = [0, 1, 2, 3].map(|i| image.row(row * TILE + i));
            let tiles = row * self.columns..(row + 1) * self.columns;
            kernels.tile_extrema(
                rows,
                &mut self.darkest[tiles.clone()],
                &mut self.brightest[tiles],
            );
        }
        for row in 0..self.rows {
            self.look_around(row);
        }
    }

    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        let (columns, rows) = (width / TILE, height / TILE);
        (self.columns, self.rows) = (columns, rows);
        for tiles in [
            &mut self.darkest,
            &mut self.brightest,
            &mut self.dark_around,
            &mut self.bright_around,
        ] {
            tiles.resize(columns * rows, 0);
        }
        self.shade.make_room(columns, rows);
        self.column_darkest.resize(columns + 2, 0);
        self.column_brightest.resize(columns + 2, 0);
    }

    fn look_around(&mut self, row: usize) {
        let (above, below) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let tiles = |row: usize| row * self.columns..(row + 1) * self.columns;
        let three = |of: &'_ [u8]| {
            [above, row, below]
                .map(|row| tiles(row).start)
                .map(|start| start..start + of.len() / self.rows)
        };
        let [a, b, c] = three(&self.darkest).map(|range| &self.darkest[range]);
        spread(
            u8::min,
            [a, b, c],
            &mut self.column_darkest,
            &mut self.dark_around[tiles(row)],
        );
        let [a, b, c] = three(&self.brightest).map(|range| &self.brightest[range]);
        spread(
            u8::max,
            [a, b, c],
            &mut self.column_brightest,
            &mut self.bright_around[tiles(row)],
        );
    }

    pub(crate) fn set_gate(&mut self, gate: u8) {
        self.gate = gate;
    }

    /// Standard deviation of the noise in grey levels, from the ranges of the flattest tiles.
    ///
    /// The range of 16 normal values has its tenth percentile at 2.6 sigma. Sixteen rows of tiles are asked; clipped
    /// tiles, which show too little noise, are not.
    pub(crate) fn noise_sigma(&self) -> f32 {
        const PERCENTILE: u32 = 10;
        const RANGE_IN_SIGMA: f32 = 2.6;
        const ASKED_ROWS: usize = 16;
        let mut counts = [0_u32; 256];
        for row in (0..self.rows).step_by(self.rows.div_ceil(ASKED_ROWS)) {
            let tiles = row * self.columns..(row + 1) * self.columns;
            for (&dark, &bright) in self.darkest[tiles.clone()]
                .iter()
                .zip(&self.brightest[tiles])
            {
                if dark > 0 && bright < u8::MAX {
                    counts[usize::from(bright - dark)] += 1;
                }
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

    /// Finds the tiles for the second chance; says whether there are any.
    ///
    /// A tile shows shade when there is contrast in it though all of it is dark compared to what is around.
    pub(crate) fn find_shade(&mut self) -> bool {
        let gate = self.gate;
        let mut any = 0;
        for row in 0..self.rows {
            let tiles = row * self.columns..(row + 1) * self.columns;
            let own = self.darkest[tiles.clone()]
                .iter()
                .zip(&self.brightest[tiles.clone()]);
            let around = self.dark_around[tiles.clone()]
                .iter()
                .zip(&self.bright_around[tiles]);
            let flags = self
                .column_darkest
                .iter_mut()
                .zip(&mut self.column_brightest);
            for (((dark, bright), (low, high)), (live, shade)) in own.zip(around).zip(flags) {
                *live = u8::from(high - low >= gate);
                *shade =
                    u8::from(bright - dark >= gate) & u8::from(*bright < u8::midpoint(*low, *high));
                any |= *shade;
            }
            self.shade.set_row(
                row,
                &self.column_darkest[..self.columns],
                &self.column_brightest[..self.columns],
            );
        }
        if any != 0 {
            self.shade.spread();
        }
        any != 0
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// The levels of a row of tiles: pixels below are black; 0 in tiles below the gate.
    /// Fills whole words; the last tile's level holds for the pixels beyond it.
    pub(crate) fn levels(&self, row: usize, level: Level, levels: &mut Vec<u8>) {
        let gate = self.gate;
        levels.clear();
        levels.resize((self.columns + 1).next_multiple_of(TILES_IN_WORD), 0);
        let tiles = row * self.columns..(row + 1) * self.columns;
        let around = self.dark_around[tiles.clone()]
            .iter()
            .zip(&self.bright_around[tiles]);
        match level {
            Level::Middle => fill(levels, around, gate, u8::midpoint),
            Level::Shaded => {
                fill(levels, around, gate, |dark, bright| {
                    dark + ((bright - dark) / 8).max(gate / 4 * 3)
                });
                self.shade.mask_row(row, &mut levels[..self.columns]);
            }
        }
        levels[self.columns] = levels[self.columns - 1];
    }
}

/// The extremum of three rows of tiles and of each tile's neighbours in them.
#[inline(always)]
fn spread(
    pick: impl Fn(u8, u8) -> u8,
    [above, here, below]: [&[u8]; 3],
    column: &mut [u8],
    around: &mut [u8],
) {
    let n = around.len();
    let tiles = above.iter().zip(here).zip(below);
    for (out, ((&a, &b), &c)) in column[1..=n].iter_mut().zip(tiles) {
        *out = pick(pick(a, b), c);
    }
    (column[0], column[n + 1]) = (column[1], column[n]);
    let neighbours = column[..n].iter().zip(&column[1..=n]).zip(&column[2..]);
    for (out, ((&a, &b), &c)) in around.iter_mut().zip(neighbours) {
        *out = pick(pick(a, b), c);
    }
}

#[inline(always)]
fn fill<'a>(
    levels: &mut [u8],
    around: impl Iterator<Item = (&'a u8, &'a u8)>,
    gate: u8,
    between: impl Fn(u8, u8) -> u8,
) {
    for (out, (&dark, &bright)) in levels.iter_mut().zip(around) {
        *out = if bright - dark >= gate {
            between(dark, bright)
        } else {
            0
        };
    }
}
