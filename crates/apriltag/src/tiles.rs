//! Tiles of 4x4 pixels: what is dark and bright around each, whether that is more than noise, and the level that
//! separates black from white there.
//!
//! In: an image. Out: a level for each tile, 0 where nothing stands out from the noise. As in AprilTag 2 (Wang & Olson,
//! IROS 2016, section III-A) the extrema are taken over the 3x3 tiles around each; the gate is measured here, so that
//! noise costs no time further on.

use crate::Image;
use crate::components::Components;
use crate::kernels::{Kernels, TILE, TILES_IN_WORD, WORD};
use crate::outlines::BorderShape;
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
    /// Words of the bit plane in a row.
    words_in_row: usize,
    /// Extrema of each tile, row after row, each of whole words.
    darkest: Vec<u8>,
    brightest: Vec<u8>,
    /// All bits set where something is looked for, none elsewhere.
    sought: Vec<u8>,
    /// Pixels below are black, 0 in tiles below the gate.
    levels: Vec<u8>,
    /// The words of each row between which its live tiles lie.
    live_words: Vec<Range<usize>>,
    /// One row of what is worked on.
    scratch: Scratch,
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
        self.words_in_row = (self.columns + 1).div_ceil(TILES_IN_WORD);
        let n_tiles = self.words_in_row * TILES_IN_WORD * self.rows;
        for tiles in [
            &mut self.darkest,
            &mut self.brightest,
            &mut self.sought,
            &mut self.levels,
        ] {
            tiles.clear();
            tiles.resize(n_tiles, 0);
        }
        self.live_words.resize(self.rows, 0..0);
        self.scratch.column.resize(self.columns + 2, 0);
        self.scratch.dark_around.resize(self.columns, 0);
        self.scratch.bright_around.resize(self.columns, 0);
    }

    /// Where the tiles of a row lie among all.
    fn row(&self, row: usize) -> Range<usize> {
        let first = row * self.words_in_row * TILES_IN_WORD;
        first..first + self.columns
    }

    pub(crate) fn measure(&mut self, image: &Image<'_>, kernels: &Kernels) {
        for row in 0..self.rows {
            let rows = [0, 1, 2, 3].map(|i| image.row(row * TILE + i));
            let tiles = self.row(row);
            let (darkest, brightest) =
                (&mut self.darkest[tiles.clone()], &mut self.brightest[tiles]);
            kernels.run(
                #[inline(always)]
                || find_extrema(rows, darkest, brightest),
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
            let tiles = self.row(row);
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

    /// Looks only where components, found with the usual levels, reach into shade: more may belong to them than should.
    pub(crate) fn seek_in_shade(
        &mut self,
        components: &mut Components,
        shape: &BorderShape,
        kernels: &Kernels,
    ) {
        kernels.run(
            #[inline(always)]
            || self.find_shade(),
        );
        self.mark_shaded(components, shape);
        self.sought.fill(0);
        for (pair, (spans, labels)) in components.row_pairs().enumerate() {
            let tiles = self.row((2 * pair / TILE).min(self.rows - 1));
            let tiles = &mut self.sought[tiles.start..=tiles.end];
            for (&[start, end], &label) in spans.iter().zip(labels) {
                if components.all()[label as usize].doubtful {
                    let [first, last] = [start, end - 1].map(|x| usize::from(x) / TILE);
                    for tile in &mut tiles[first..=last] {
                        *tile = u8::MAX;
                    }
                }
            }
        }
    }

    /// Seeks the tiles that show shade: there is contrast in them though all of them is dark compared to what is around.
    #[inline(always)]
    fn find_shade(&mut self) {
        let gate = self.gate;
        let extrema = self.darkest.iter().zip(&self.brightest);
        let tiles = self.sought.iter_mut().zip(extrema.zip(&self.levels));
        for (sought, ((dark, bright), level)) in tiles {
            *sought = u8::from(bright - dark >= gate) & u8::from(bright < level);
        }
    }

    /// Marks the components of the tiles that show shade: all of such a tile's pixels went into one, and with them the border
    /// of a tag that lies in that shade.
    fn mark_shaded(&self, components: &mut Components, shape: &BorderShape) {
        let words = self.sought.as_chunks::<TILES_IN_WORD>().0;
        for (i, word) in words.iter().enumerate() {
            let mut shaded = u128::from_le_bytes(*word);
            while shaded != 0 {
                let tile =
                    i % self.words_in_row * TILES_IN_WORD + shaded.trailing_zeros() as usize / 8;
                shaded &= shaded - 1;
                let pixel = [tile, i / self.words_in_row].map(|at| at * TILE);
                if let Some(component) = components.at(pixel) {
                    component.doubtful |= !component.settled && shape.has_size(component);
                }
            }
        }
    }

    /// Sets the levels, near the dark end only where something is sought; says whether there is a live tile.
    pub(crate) fn set_levels(&mut self, level: Level, kernels: &Kernels) -> bool {
        let least = self.gate / 4 * 3;
        let near_dark = move |dark: u8, bright: u8| dark + ((bright - dark) / 8).max(least);
        for row in 0..self.rows {
            match level {
                Level::Middle => kernels.run(
                    #[inline(always)]
                    || self.set_row(row, u8::midpoint),
                ),
                Level::Shaded if self.sought[self.row(row)].contains(&u8::MAX) => kernels.run(
                    #[inline(always)]
                    || {
                        self.set_row(row, near_dark);
                        self.keep_sought(row);
                    },
                ),
                Level::Shaded => {
                    self.live_words[row] = 0..0;
                    continue;
                }
            }
            self.live_words[row] = self.find_live_words(row);
        }
        self.live_words.iter().any(|words| !words.is_empty())
    }

    /// Sets the levels of a row to 0 where nothing is sought.
    #[inline(always)]
    fn keep_sought(&mut self, row: usize) {
        let row = self.row(row);
        let row = row.start..row.end + 1;
        for (level, sought) in self.levels[row.clone()].iter_mut().zip(&self.sought[row]) {
            *level &= sought;
        }
    }

    /// Levels of a row between the extrema of the 3x3 tiles around each.
    #[inline(always)]
    fn set_row(&mut self, row: usize, between: impl Fn(u8, u8) -> u8) {
        let gate = self.gate;
        let rows =
            [row.saturating_sub(1), row, (row + 1).min(self.rows - 1)].map(|row| self.row(row));
        let tiles = rows[1].clone();
        let Scratch {
            column,
            dark_around,
            bright_around,
        } = &mut self.scratch;
        let dark = rows.clone().map(|row| &self.darkest[row]);
        spread(u8::min, dark, column, dark_around);
        let bright = rows.map(|row| &self.brightest[row]);
        spread(u8::max, bright, column, bright_around);
        let levels = &mut self.levels[tiles.start..=tiles.end];
        let around = dark_around.iter().zip(bright_around.iter());
        for (level, (&dark, &bright)) in levels.iter_mut().zip(around) {
            let live = bright - dark >= gate;
            *level = if live { between(dark, bright) } else { 0 };
        }
        // The last tile's level holds for the pixels beyond it.
        levels[tiles.len()] = levels[tiles.len() - 1];
    }

    fn find_live_words(&self, row: usize) -> Range<usize> {
        let words = self.levels(row).as_chunks::<TILES_IN_WORD>().0;
        let live = |word: &[u8; TILES_IN_WORD]| u128::from_ne_bytes(*word) != 0;
        match words.iter().position(live) {
            Some(first) => first..words.iter().rposition(live).unwrap_or(first) + 1,
            None => 0..0,
        }
    }

    /// The levels of the tiles around a row of pixels, and the words between which there are live ones.
    pub(crate) fn levels_at(&self, y: usize) -> (&[u8], Range<usize>) {
        let row = (y / TILE).min(self.rows - 1);
        (self.levels(row), self.live_words[row].clone())
    }

    fn levels(&self, row: usize) -> &[u8] {
        &self.levels[self.row(row).start..][..self.words_in_row * TILES_IN_WORD]
    }
}

/// Least and greatest value of each tile of four rows, block after block: compilers make vectors of loops whose length they
/// know. Pixels beyond the last whole tile are left out.
#[inline(always)]
fn find_extrema(rows: [&[u8]; TILE], darkest: &mut [u8], brightest: &mut [u8]) {
    let n_blocks = darkest.len() / TILES_IN_WORD;
    for block in 0..n_blocks {
        let [a, b, c, d] = rows.map(|row| &row.as_chunks::<WORD>().0[block]);
        let [mut low, mut high] = [[0_u8; WORD]; 2];
        for i in 0..WORD {
            low[i] = a[i].min(b[i]).min(c[i]).min(d[i]);
            high[i] = a[i].max(b[i]).max(c[i]).max(d[i]);
        }
        let tiles = block * TILES_IN_WORD..(block + 1) * TILES_IN_WORD;
        of_fours(&low, &mut darkest[tiles.clone()], u32::min);
        of_fours(&high, &mut brightest[tiles], u32::max);
    }
    for tile in n_blocks * TILES_IN_WORD..darkest.len() {
        let pixels = rows.iter().flat_map(|row| &row[tile * TILE..][..TILE]);
        darkest[tile] = pixels
            .clone()
            .fold(u8::MAX, |least, &pixel| least.min(pixel));
        brightest[tile] = pixels.fold(0, |most, &pixel| most.max(pixel));
    }
}

/// Of each four neighbours one.
#[inline(always)]
fn of_fours(columns: &[u8; WORD], tiles: &mut [u8], pick: impl Fn(u32, u32) -> u32) {
    for (tile, four) in tiles.iter_mut().zip(columns.as_chunks::<TILE>().0) {
        let four = u32::from_le_bytes(*four);
        let [a, b, c, d] = [0, 8, 16, 24].map(|bits| four >> bits & 0xff);
        *tile = pick(pick(a, b), pick(c, d)) as u8;
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rows() -> impl Strategy<Value = Vec<Vec<u8>>> {
        (1_usize..300).prop_flat_map(|width| {
            prop::collection::vec(prop::collection::vec(any::<u8>(), width), TILE)
        })
    }

    proptest! {
        #[test]
        fn extrema_are_those_of_each_tiles_pixels(rows in rows()) {
            let n_tiles = rows[0].len() / TILE;
            for kernels in [Kernels::fastest(), Kernels::SCALAR] {
                let (mut darkest, mut brightest) = (vec![0; n_tiles], vec![0; n_tiles]);
                let pixels = [0, 1, 2, 3].map(|i| &rows[i][..]);
                kernels.run(
                    #[inline(always)]
                    || find_extrema(pixels, &mut darkest, &mut brightest),
                );
                for tile in 0..n_tiles {
                    let pixels = rows.iter().flat_map(|row| &row[tile * TILE..][..TILE]);
                    prop_assert_eq!(pixels.clone().min(), Some(&darkest[tile]));
                    prop_assert_eq!(pixels.max(), Some(&brightest[tile]));
                }
            }
        }
    }
}
