//! Tiles of 4x4 pixels: what is dark and bright around each, whether that is more than noise, and the level that
//! separates black from white there.
//!
//! In: an image. Out: a level for each tile, 0 where nothing stands out from the noise. As in AprilTag 2 (Wang & Olson,
//! IROS 2016, section III-A) the extrema are taken over the 3x3 tiles around each; the gate is measured here, so that
//! noise costs no time further on.

use crate::Image;
use crate::components::make_room;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD};

/// Where between the darkest and the brightest value around a tile the level lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    /// Half way: where black and white are all there is.
    Middle,
    /// Near the dark end: where something brighter than a tag's white stands beside the tag.
    Shaded,
}

#[derive(Debug, Default)]
pub(crate) struct Tiles {
    columns: usize,
    rows: usize,
    /// Extrema of each tile, row after row.
    darkest: Vec<u8>,
    brightest: Vec<u8>,
    /// Extrema of the 3x3 tiles around each.
    dark_around: Vec<u8>,
    bright_around: Vec<u8>,
    /// Extrema of three tiles above each other, with one more at either end.
    column_darkest: Vec<u8>,
    column_brightest: Vec<u8>,
    /// 1 for tiles that the second chance looks at.
    shaded: Vec<u8>,
    to_visit: Vec<u32>,
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
        self.shaded.resize(columns * rows, 0);
        make_room(&mut self.to_visit, columns * rows);
        self.column_darkest.resize(columns + 2, 0);
        self.column_brightest.resize(columns + 2, 0);
    }

    fn look_around(&mut self, row: usize) {
        let (above, below) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let tiles = |row: usize| row * self.columns..(row + 1) * self.columns;
        let extremum = |of: &[u8], column: &mut [u8], around: &mut [u8], pick: fn(u8, u8) -> u8| {
            let (a, b, c) = (&of[tiles(above)], &of[tiles(row)], &of[tiles(below)]);
            spread(pick, [a, b, c], column, &mut around[tiles(row)]);
        };
        extremum(
            &self.darkest,
            &mut self.column_darkest,
            &mut self.dark_around,
            u8::min,
        );
        extremum(
            &self.brightest,
            &mut self.column_brightest,
            &mut self.bright_around,
            u8::max,
        );
    }

    /// Standard deviation of the noise in grey levels, from the ranges of the flattest tiles.
    ///
    /// The range of 16 normal values has its tenth percentile at 2.6 sigma. One tile row in four is asked; clipped
    /// tiles, which show too little noise, are not.
    pub(crate) fn noise_sigma(&self) -> f32 {
        const PERCENTILE: u32 = 10;
        const RANGE_IN_SIGMA: f32 = 2.6;
        let mut counts = [0_u32; 256];
        for row in (0..self.rows).step_by(4) {
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

    /// Marks the live tiles that hang together with one in which there is contrast though all of it is dark compared to
    /// what is around: black and white in the shade of something brighter. Says whether there are any.
    pub(crate) fn find_shade(&mut self, gate: u8) -> bool {
        self.shaded.fill(0);
        self.to_visit.clear();
        for tile in 0..self.darkest.len() {
            let (dark, bright) = (self.darkest[tile], self.brightest[tile]);
            let middle = u8::midpoint(self.dark_around[tile], self.bright_around[tile]);
            if bright - dark >= gate && bright < middle {
                self.visit(tile, gate);
            }
        }
        let found = !self.to_visit.is_empty();
        while let Some(tile) = self.to_visit.pop() {
            let (row, column) = (tile as usize / self.columns, tile as usize % self.columns);
            for row in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
                for column in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                    self.visit(row * self.columns + column, gate);
                }
            }
        }
        found
    }

    fn visit(&mut self, tile: usize, gate: u8) {
        let live = self.bright_around[tile] - self.dark_around[tile] >= gate;
        if live && self.shaded[tile] == 0 {
            self.shaded[tile] = 1;
            self.to_visit.push(tile as u32);
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// The levels of a row of tiles: pixels below are black; 0 in tiles below the gate.
    /// Fills whole words; the last tile's level holds for the pixels beyond it.
    pub(crate) fn levels(&self, row: usize, gate: u8, level: Level, levels: &mut Vec<u8>) {
        levels.clear();
        levels.resize((self.columns + 1).next_multiple_of(TILES_IN_WORD), 0);
        let tiles = row * self.columns..(row + 1) * self.columns;
        let around = self.dark_around[tiles.clone()]
            .iter()
            .zip(&self.bright_around[tiles.clone()]);
        match level {
            Level::Middle => fill(levels, around, gate, u8::midpoint),
            Level::Shaded => {
                fill(levels, around, gate, |dark, bright| {
                    dark + ((bright - dark) / 8).max(gate / 4 * 3)
                });
                for (level, &shaded) in levels.iter_mut().zip(&self.shaded[tiles]) {
                    *level *= shaded;
                }
            }
        }
        levels[self.columns] = levels[self.columns - 1];
    }
}

fn spread(pick: fn(u8, u8) -> u8, rows: [&[u8]; 3], column: &mut [u8], around: &mut [u8]) {
    let n = around.len();
    for (i, out) in column[1..=n].iter_mut().enumerate() {
        *out = pick(pick(rows[0][i], rows[1][i]), rows[2][i]);
    }
    (column[0], column[n + 1]) = (column[1], column[n]);
    for (i, out) in around.iter_mut().enumerate() {
        *out = pick(pick(column[i], column[i + 1]), column[i + 2]);
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
