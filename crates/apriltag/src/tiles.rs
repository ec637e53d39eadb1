//! Tiles of 4x4 pixels: what is dark and bright around each, whether that is more than noise, and the level that
//! separates black from white there.
//!
//! In: an image. Out: a level for each tile, 0 where nothing stands out from the noise. As in AprilTag 2 (Wang & Olson,
//! IROS 2016, section III-A) the extrema are taken over the 3x3 tiles around each; the gate is measured here, so that
//! noise costs no time further on.

use crate::Image;
use crate::components::{Component, Components};
use crate::kernels::{Kernels, TILE, TILES_IN_WORD};
use sextant_tag_families::BorderColour;
use std::ops::Range;

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
    /// Pixels below are black, 0 in tiles below the gate: rows of whole words.
    levels: Vec<u8>,
    /// The words of each row between which its live tiles lie.
    live_words: Vec<Range<usize>>,
    /// One row of what is worked on.
    scratch: Scratch,
    /// 1 for tiles that get a second chance, 0 for others.
    second_chance: Vec<u8>,
}

/// Extrema of three tiles above each other, with one more at either end, and of the 3x3 tiles around each.
#[derive(Debug, Default)]
struct Scratch {
    column: Vec<u8>,
    dark_around: Vec<u8>,
    bright_around: Vec<u8>,
}

impl Tiles {
    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        (self.columns, self.rows) = (width / TILE, height / TILE);
        self.darkest.resize(self.columns * self.rows, 0);
        self.brightest.resize(self.columns * self.rows, 0);
        self.levels.clear();
        self.levels
            .resize(self.words_in_row() * TILES_IN_WORD * self.rows, 0);
        self.live_words.resize(self.rows, 0..0);
        self.second_chance.resize(self.columns * self.rows, 0);
        let column = (self.columns + 2).next_multiple_of(8);
        self.scratch.column.resize(column, 0);
        self.scratch.dark_around.resize(self.columns, 0);
        self.scratch.bright_around.resize(self.columns, 0);
    }

    /// Words of the bit plane in a row; the last tile's level holds for the pixels beyond it.
    fn words_in_row(&self) -> usize {
        (self.columns + 1).div_ceil(TILES_IN_WORD)
    }

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

    /// Sets every tile's level half way between dark and bright; says whether there is a live tile.
    pub(crate) fn set_levels(&mut self, kernels: &Kernels) -> bool {
        for row in 0..self.rows {
            kernels.run(|| self.set_row(row, u8::midpoint));
            self.live_words[row] = self.find_live_words(row);
        }
        self.any_live()
    }

    /// Sets levels near the dark end where components, found with the usual levels, are to have a second chance; none
    /// elsewhere. Says whether there is a live tile.
    pub(crate) fn set_shaded_levels<'a>(
        &mut self,
        components: impl Iterator<Item = &'a Component>,
        kernels: &Kernels,
    ) -> bool {
        self.second_chance.fill(0);
        for component in components {
            let [columns, rows] = self.tiles_of(component);
            for row in rows {
                self.second_chance[row * self.columns..][columns.clone()].fill(1);
            }
        }
        let least = self.gate / 4 * 3;
        let near_dark = move |dark: u8, bright: u8| dark + ((bright - dark) / 8).max(least);
        for row in 0..self.rows {
            let tiles = row * self.columns..(row + 1) * self.columns;
            if !self.second_chance[tiles.clone()].contains(&1) {
                self.live_words[row] = 0..0;
                continue;
            }
            kernels.run(|| self.set_row(row, near_dark));
            let levels = row * self.words_in_row() * TILES_IN_WORD;
            let levels = &mut self.levels[levels..][..=self.columns];
            for (level, chance) in levels.iter_mut().zip(&self.second_chance[tiles]) {
                *level *= chance;
            }
            levels[self.columns] = levels[self.columns - 1];
            self.live_words[row] = self.find_live_words(row);
        }
        self.any_live()
    }

    /// Columns and rows of the tiles that a component's box touches.
    fn tiles_of(&self, component: &Component) -> [Range<usize>; 2] {
        let range =
            |low: u32, high: u32, n: usize| low as usize / TILE..(high as usize / TILE + 1).min(n);
        [
            range(component.left, component.right - 1, self.columns),
            range(component.top, component.bottom, self.rows),
        ]
    }

    fn any_live(&self) -> bool {
        self.live_words.iter().any(|words| !words.is_empty())
    }

    /// Levels of a row between the extrema of the 3x3 tiles around each.
    #[inline(always)]
    fn set_row(&mut self, row: usize, between: impl Fn(u8, u8) -> u8) {
        let (columns, gate) = (self.columns, self.gate);
        let Scratch {
            column,
            dark_around,
            bright_around,
        } = &mut self.scratch;
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.rows - 1)];
        let dark = rows.map(|row| &self.darkest[row * columns..][..columns]);
        spread(u8::min, dark, column, dark_around);
        let bright = rows.map(|row| &self.brightest[row * columns..][..columns]);
        spread(u8::max, bright, column, bright_around);
        let first = row * (columns + 1).next_multiple_of(TILES_IN_WORD);
        let levels = &mut self.levels[first..][..=columns];
        let around = dark_around.iter().zip(bright_around.iter());
        for (out, (&dark, &bright)) in levels.iter_mut().zip(around) {
            let live = bright - dark >= gate;
            *out = if live { between(dark, bright) } else { 0 };
        }
        levels[columns] = levels[columns - 1];
    }

    fn find_live_words(&self, row: usize) -> Range<usize> {
        let words = self.levels(row).as_chunks::<TILES_IN_WORD>().0;
        let live = |word: &[u8; TILES_IN_WORD]| u128::from_ne_bytes(*word) != 0;
        match words.iter().position(live) {
            Some(first) => first..words.iter().rposition(live).unwrap_or(first) + 1,
            None => 0..0,
        }
    }

    /// Marks the components, found with the usual levels, that reach into shade.
    ///
    /// A tile shows shade when there is contrast in it though all of it is dark compared to what is around. All of its
    /// pixels went into one component then, and with them the border of a tag that lies in that shade.
    pub(crate) fn mark_shade(
        &mut self,
        image: &Image<'_>,
        components: &mut Components,
        kernels: &Kernels,
    ) {
        for row in 0..self.rows {
            if self.live_words[row].is_empty() {
                continue;
            }
            kernels.run(|| self.find_shade(row));
            self.scratch.column[self.columns..].fill(0);
            let tiles = &self.scratch.column;
            for (first, eight) in (0..).step_by(8).zip(tiles.as_chunks::<8>().0) {
                let mut shaded = u64::from_le_bytes(*eight);
                while shaded != 0 {
                    let tile = [first + shaded.trailing_zeros() as usize / 8, row];
                    shaded &= shaded - 1;
                    if self.has_bright_side(image, tile) {
                        components.mark(tile.map(|at| at * TILE));
                    }
                }
            }
        }
    }

    /// Whether enough of a tile is bright for its own range: the foot of a blurred edge is dark but for its last pixels.
    fn has_bright_side(&self, image: &Image<'_>, [column, row]: [usize; 2]) -> bool {
        const ENOUGH: usize = TILE * TILE * 3 / 8;
        let tile = row * self.columns + column;
        let middle = u8::midpoint(self.darkest[tile], self.brightest[tile]);
        let rows = row * TILE..(row + 1) * TILE;
        let pixels = rows.flat_map(|y| &image.row(y)[column * TILE..][..TILE]);
        pixels.filter(|&&pixel| pixel > middle).count() >= ENOUGH
    }

    /// 1 in the scratch column for each tile of a row that shows shade.
    #[inline(always)]
    fn find_shade(&mut self, row: usize) {
        let (columns, gate) = (self.columns, self.gate);
        let dark = &self.darkest[row * columns..][..columns];
        let bright = &self.brightest[row * columns..][..columns];
        let levels = &self.levels[row * self.words_in_row() * TILES_IN_WORD..][..columns];
        let shade = &mut self.scratch.column[..columns];
        for (((dark, bright), level), shade) in dark.iter().zip(bright).zip(levels).zip(shade) {
            *shade = u8::from(bright - dark >= gate) & u8::from(bright < level);
        }
    }

    /// The levels of the tiles around a row of pixels, and the words between which there are live ones.
    pub(crate) fn levels_at(&self, y: usize) -> (&[u8], Range<usize>) {
        let row = (y / TILE).min(self.rows - 1);
        (self.levels(row), self.live_words[row].clone())
    }

    fn levels(&self, row: usize) -> &[u8] {
        let width = self.words_in_row() * TILES_IN_WORD;
        &self.levels[row * width..][..width]
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
