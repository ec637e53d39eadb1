//! Tiles of 4x4 pixels: what is dark and bright around each, whether that is more than noise, and the level that
//! separates black from white there.
//!
//! In: an image. Out: a level for each tile, 0 where nothing stands out from the noise. As in AprilTag 2 (Wang & Olson,
//! IROS 2016, section III-A) the extrema are taken over the 3x3 tiles around each; the gate is measured here, so that
//! noise costs no time further on.

use crate::Image;
use crate::border_shape::BorderShape;
use crate::components::Components;
use crate::kernels::{TILE, TILES_IN_WORD, WORD, vectorised};
use sextant_tag_families::BorderColour;
use std::ops::Range;

/// Where between the darkest and the brightest value around a tile the level lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Half way: where black and white are all there is.
    Middle,
    /// Nearer to the dark end: where something brighter than a tag's white stands beside the tag.
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
    /// Extrema of each tile, row after row, each of whole words: what the last tile has holds for the pixels beyond it.
    darkest: Vec<u8>,
    brightest: Vec<u8>,
    /// The brightest of each tile that shows shade, 0 of others.
    shade: Vec<u8>,
    /// All bits set where something is looked for, none elsewhere.
    sought: Vec<u8>,
    /// Pixels below are black, 0 in tiles below the gate.
    levels: Vec<u8>,
    /// The words of each row between which its live tiles lie; before levels are set, those that are sought.
    live_words: Vec<Range<usize>>,
    /// Extrema of three tiles above each other, with one more at either end.
    dark_column: Vec<u8>,
    bright_column: Vec<u8>,
    shade_column: Vec<u8>,
}

impl Tiles {
    /// Takes the memory that an image of a size needs.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        (self.columns, self.rows) = (width / TILE, height / TILE);
        self.words_in_row = (self.columns + 1).div_ceil(TILES_IN_WORD);
        let in_row = self.words_in_row * TILES_IN_WORD;
        for tiles in [
            &mut self.darkest,
            &mut self.brightest,
            &mut self.shade,
            &mut self.sought,
            &mut self.levels,
        ] {
            tiles.clear();
            tiles.resize(in_row * self.rows, 0);
        }
        self.live_words.resize(self.rows, 0..0);
        self.dark_column.resize(in_row + 2, 0);
        self.bright_column.resize(in_row + 2, 0);
        self.shade_column.resize(in_row + 2, 0);
    }

    /// Where the tiles of a row lie among all, to the end of its last word.
    fn row(&self, row: usize) -> Range<usize> {
        let in_row = self.words_in_row * TILES_IN_WORD;
        row * in_row..(row + 1) * in_row
    }

    /// Where the tiles of a row lie that show pixels.
    fn whole_tiles(&self, row: usize) -> Range<usize> {
        let start = self.row(row).start;
        start..start + self.columns
    }

    pub(crate) fn measure(&mut self, image: &Image<'_>) {
        vectorised(
            #[inline(always)]
            || {
                for row in 0..self.rows {
                    let rows = [0, 1, 2, 3].map(|i| image.row(row * TILE + i));
                    let tiles = self.whole_tiles(row);
                    let darkest = &mut self.darkest[tiles.clone()];
                    find_extrema(rows, darkest, &mut self.brightest[tiles]);
                }
            },
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
            let tiles = self.whole_tiles(row);
            let brightest = &self.brightest[tiles.clone()];
            for (&dark, &bright) in self.darkest[tiles].iter().zip(brightest) {
                let is_clipped = dark == 0 || bright == u8::MAX;
                counts[usize::from(bright - dark)] += u32::from(!is_clipped);
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
    pub(crate) fn seek_in_shade(&mut self, components: &mut Components, shape: &BorderShape) {
        vectorised(
            #[inline(always)]
            || self.find_shade(),
        );
        self.mark_shaded(components, shape);
        self.sought.fill(0);
        self.live_words.fill(0..0);
        for component in components.all().iter().filter(|found| found.doubtful) {
            for (pair, [start, end]) in components.extents_of(component) {
                let row = (2 * pair / TILE).min(self.rows - 1);
                let [first, last] = [start, end - 1].map(|x| usize::from(x) / TILE);
                let tiles = self.row(row).start;
                self.sought[tiles + first..tiles + last + 1].fill(u8::MAX);
                self.live_words[row] = 0..self.words_in_row;
            }
        }
    }

    /// Seeks the tiles that show shade: there is contrast in them though all of them is dark compared to what is around.
    #[inline(always)]
    fn find_shade(&mut self) {
        let gate = self.gate;
        let extrema = self.darkest.iter().zip(&self.brightest);
        let tiles = self.shade.iter_mut().zip(extrema.zip(&self.levels));
        for (shade, ((dark, bright), level)) in tiles {
            let shows_shade = u8::from(bright - dark >= gate) & u8::from(bright < level);
            *shade = bright * shows_shade;
        }
    }

    /// Marks the components of the tiles that show shade: all of such a tile's pixels went into one, and with them the border
    /// of a tag that lies in that shade.
    fn mark_shaded(&self, components: &mut Components, shape: &BorderShape) {
        for row in 0..self.rows {
            let words = self.shade[self.row(row)].as_chunks::<TILES_IN_WORD>().0;
            let some = words
                .iter()
                .enumerate()
                .filter(|(_, word)| **word != [0; TILES_IN_WORD]);
            let tiles = some.flat_map(|(i, word)| (i * TILES_IN_WORD..).zip(word));
            let mut next = 0;
            for (tile, _) in tiles.filter(|(_, shade)| **shade != 0) {
                if tile < next {
                    continue;
                }
                if let Some((label, end)) = components.at([tile * TILE, row * TILE]) {
                    if shape.has_size(&components.all()[label]) {
                        components.doubt(label);
                    }
                    next = end / TILE;
                }
            }
        }
    }

    /// Sets the levels, near the dark end only where something is sought; says whether there is a live tile.
    pub(crate) fn set_levels(&mut self, level: Level) -> bool {
        if level == Level::Middle {
            self.live_words.fill(0..self.words_in_row);
        }
        vectorised(
            #[inline(always)]
            || {
                for row in 0..self.rows {
                    if !self.live_words[row].is_empty() {
                        self.set_row(row, level);
                        self.live_words[row] = self.find_live_words(row);
                    }
                }
            },
        );
        self.live_words.iter().any(|words| !words.is_empty())
    }

    /// Levels of a row between the extrema of the 3x3 tiles around each, word after word: compilers make vectors of loops
    /// whose length they know.
    #[inline(always)]
    fn set_row(&mut self, row: usize, level: Level) {
        let (tiles, last) = (self.row(row), self.columns - 1);
        let (gate, least) = (self.gate, self.gate / 4 * 3);
        let rows =
            [row.saturating_sub(1), row, (row + 1).min(self.rows - 1)].map(|row| self.row(row));
        let dark = rows.clone().map(|row| &self.darkest[row]);
        spread_down(u8::min, dark, last, &mut self.dark_column);
        let bright = rows.clone().map(|row| &self.brightest[row]);
        spread_down(u8::max, bright, last, &mut self.bright_column);
        if level == Level::Shaded {
            let shade = rows.map(|row| &self.shade[row]);
            spread_down(u8::max, shade, last, &mut self.shade_column);
        }
        let levels = &mut self.levels[tiles.clone()];
        let words = levels.as_chunks_mut::<TILES_IN_WORD>().0.iter_mut();
        let sought = self.sought[tiles].as_chunks::<TILES_IN_WORD>().0;
        for (i, (levels, sought)) in words.zip(sought).enumerate() {
            let dark = spread_across(u8::min, &self.dark_column, i);
            let bright = spread_across(u8::max, &self.bright_column, i);
            let range: [u8; TILES_IN_WORD] = std::array::from_fn(|i| bright[i] - dark[i]);
            *levels = match level {
                Level::Middle => std::array::from_fn(|i| dark[i] + range[i] / 2),
                // A tag's white is no brighter than what shows shade; where nothing does, than all there is.
                Level::Shaded => {
                    let shade = spread_across(u8::max, &self.shade_column, i);
                    std::array::from_fn(|i| {
                        let in_shade = shade[i].saturating_sub(dark[i]);
                        let most = if in_shade >= gate { in_shade } else { range[i] };
                        (dark[i] + (most / 3).max(least)) & sought[i]
                    })
                }
            };
            *levels = std::array::from_fn(|i| if range[i] >= gate { levels[i] } else { 0 });
        }
        // The last tile's level holds for the pixels beyond it.
        levels[last + 1] = levels[last];
        levels[last + 2..].fill(0);
    }

    fn find_live_words(&self, row: usize) -> Range<usize> {
        let words = self.levels[self.row(row)].as_chunks::<TILES_IN_WORD>().0;
        let live = |word: &[u8; TILES_IN_WORD]| u128::from_ne_bytes(*word) != 0;
        match words.iter().position(live) {
            Some(first) => first..words.iter().rposition(live).unwrap_or(first) + 1,
            None => 0..0,
        }
    }

    /// The levels of a row of tiles, the last of which holds for the pixels below it, and the words between which there are
    /// live ones.
    pub(crate) fn levels(&self, row: usize) -> (&[u8], Range<usize>) {
        let row = row.min(self.rows - 1);
        (&self.levels[self.row(row)], self.live_words[row].clone())
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

/// The extremum of three tiles above each other, with that of the first and the last one once more beside them.
#[inline(always)]
fn spread_down(pick: impl Fn(u8, u8) -> u8, rows: [&[u8]; 3], last: usize, column: &mut [u8]) {
    let [above, here, below] = rows.map(|row| row.as_chunks::<TILES_IN_WORD>().0);
    let words = column[1..].as_chunks_mut::<TILES_IN_WORD>().0;
    for (((out, a), b), c) in words.iter_mut().zip(above).zip(here).zip(below) {
        *out = std::array::from_fn(|i| pick(pick(a[i], b[i]), c[i]));
    }
    (column[0], column[last + 2]) = (column[1], column[last + 1]);
}

/// The extremum of each tile of a word and its neighbours.
#[inline(always)]
fn spread_across(pick: impl Fn(u8, u8) -> u8, column: &[u8], word: usize) -> [u8; TILES_IN_WORD] {
    let near = &column[word * TILES_IN_WORD..][..TILES_IN_WORD + 2];
    std::array::from_fn(|i| pick(pick(near[i], near[i + 1]), near[i + 2]))
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
            for best in [false, true] {
                let (mut darkest, mut brightest) = (vec![0; n_tiles], vec![0; n_tiles]);
                let pixels = [0, 1, 2, 3].map(|i| &rows[i][..]);
                let mut find = || find_extrema(pixels, &mut darkest, &mut brightest);
                if best { vectorised(&mut find) } else { find() }
                for tile in 0..n_tiles {
                    let pixels = rows.iter().flat_map(|row| &row[tile * TILE..][..TILE]);
                    prop_assert_eq!(pixels.clone().min(), Some(&darkest[tile]));
                    prop_assert_eq!(pixels.max(), Some(&brightest[tile]));
                }
            }
        }
    }
}
