//! Selection of the pixels that are fitted: those with a steep gradient, which carry nearly all information about the
//! position of the tag, and a few flat ones beside them for black and white.

use super::pattern::GROUP;
use super::undistortion::Undistortion;
use crate::Image;
use crate::kernels::MAX_GROUPS;
use crate::quad::{Line, Quad};
use std::array::from_fn;

/// Edge of a tile in pixels. Tiles are processed in order, so that groups contain neighbours.
const TILE: usize = 4;

/// Pixels in a tile.
const AREA: usize = TILE * TILE;

/// The flat pixel that is selected in every tile with steep ones, for black and white.
const SAMPLE: u32 = 1 << 5;

/// Least difference between the neighbours of a steep pixel, as a share of the contrast: in a sharp image, and in a
/// blurred one.
const STEEP: [f32; 2] = [0.6, 0.2];

/// Neighbouring pixels: their positions, undistorted if a lens is known, and their grey values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) x: [f32; GROUP],
    pub(super) y: [f32; GROUP],
    pub(super) grey: [f32; GROUP],
}

/// A pixel packed into an integer: column from that of the first tile in the lowest bits, row likewise from bit
/// [`ROW`], grey value from bit [`GREY`].
type PackedPixel = u32;
const ROW: u32 = 12;
const GREY: u32 = 2 * ROW;

/// Extent of a tag in pixels up to which its pixels can be packed.
const MOST_EXTENT_PX: f32 = ((1 << ROW) - 2 * TILE) as f32;

/// Offset of each pixel of a tile from its first one, column by column.
const ASIDE: [PackedPixel; AREA] = {
    let mut aside = [0; AREA];
    let mut at = 0;
    while at < AREA {
        aside[at] = (at / TILE + ((at % TILE) << ROW)) as PackedPixel;
        at += 1;
    }
    aside
};

/// A tile with steep pixels: its first pixel, without grey value, and a bit per pixel, column by column, set if it is
/// steep.
#[derive(Clone, Copy, Debug, Default)]
struct Tile {
    first: PackedPixel,
    steep: u32,
}

#[derive(Debug)]
pub(super) struct Pixels {
    groups: Vec<Group>,
    /// Column and row from which packed ones count.
    origin: [usize; 2],
    /// The selected pixels.
    packed: Box<[PackedPixel; MOST + AREA]>,
    /// As many as the largest image so far can have.
    tiles: Vec<Tile>,
    n_tiles: usize,
    /// Steep pixels of a row of tiles: a byte per column, a bit per row.
    steep: Vec<[u8; TILE]>,
}

/// Most selected pixels.
const MOST: usize = MAX_GROUPS * GROUP;

impl Default for Pixels {
    fn default() -> Self {
        Self {
            groups: Vec::with_capacity(MAX_GROUPS),
            origin: [0; 2],
            packed: Box::new([0; MOST + AREA]),
            tiles: Vec::new(),
            n_tiles: 0,
            steep: Vec::new(),
        }
    }
}

impl Pixels {
    /// Allocates the memory that an image of this size can need.
    pub(super) fn make_room(&mut self, width: usize, height: usize) {
        let most = width.div_ceil(TILE) * height.div_ceil(TILE);
        self.tiles
            .resize(self.tiles.len().max(most), Tile::default());
        let columns = self.steep.len().max(width.div_ceil(TILE));
        self.steep.resize(columns, [0; TILE]);
    }

    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Selects the pixels of a tag with this outline, contrast and total length of edges. In a sharp image, more pixels
    /// than that length are steep. `None` for a tag that is too large.
    #[inline(always)]
    pub(super) fn choose(
        &mut self,
        image: &Image<'_>,
        outline: &Quad,
        contrast: f32,
        edges_px: f32,
    ) -> Option<()> {
        self.origin = origin(image, outline)?;
        let from = self.origin.map(|at| at as f32);
        let mut n_steep = 0;
        for steep in STEEP {
            if n_steep as f32 <= edges_px {
                self.mark(image, outline, (steep * contrast).clamp(1.0, 255.0) as u8);
                let tiles = &self.tiles[..self.n_tiles];
                n_steep = tiles.iter().map(|tile| tile.steep.count_ones()).sum();
            }
        }
        let n = self.list(image, n_steep + self.n_tiles as u32);
        self.groups.clear();
        for packed in self.packed[..n].as_chunks::<GROUP>().0 {
            let mut group = Group {
                x: [0.0; GROUP],
                y: [0.0; GROUP],
                grey: [0.0; GROUP],
            };
            for i in 0..GROUP {
                let bits = |from: u32, n: u32| (packed[i] >> from & ((1 << n) - 1)) as i32 as f32;
                group.x[i] = from[0] + bits(0, ROW);
                group.y[i] = from[1] + bits(ROW, ROW);
                group.grey[i] = bits(GREY, u8::BITS);
            }
            self.groups.push(group);
        }
        Some(())
    }

    /// Lists the pixels of the marked tiles, or of a subset of these. Returns how many pixels are listed.
    #[inline(always)]
    fn list(&mut self, image: &Image<'_>, n_marked: u32) -> usize {
        let share = (MOST as f32 / n_marked as f32).min(1.0);
        let (pixels, stride) = image.bytes();
        let beyond: [u32; AREA] = from_fn(|at| (at % TILE * stride + at / TILE) as u32);
        let packed = &mut *self.packed;
        let (mut n, mut due) = (0, 0.5);
        for Tile { first, steep } in &self.tiles[..self.n_tiles] {
            due += share;
            if due < 1.0 || n >= MOST {
                continue;
            }
            due -= 1.0;
            let [x, y] = [first % (1 << ROW), first >> ROW].map(|at| at as usize);
            let pixels = &pixels[(self.origin[1] + y) * stride + self.origin[0] + x..];
            let mut steep = steep | SAMPLE;
            while steep != 0 {
                let at = steep.trailing_zeros() as usize % AREA;
                let grey = PackedPixel::from(pixels[beyond[at] as usize]);
                packed[n] = (first + ASIDE[at]) | grey << GREY;
                steep &= steep - 1;
                n += 1;
            }
        }
        n.min(MOST)
    }

    /// Finds the tiles with steep pixels among those within the outline, or nearly so, except those at the rim of the
    /// image, where pixels lack neighbours.
    #[inline(always)]
    fn mark(&mut self, image: &Image<'_>, outline: &Quad, least: u8) {
        const MIDDLE: f32 = (TILE - 1) as f32 / 2.0;
        const NEARLY_PX: f32 = TILE as f32 / 2.0;
        let sides: [_; 4] = from_fn(|i| Line::through(outline[i], outline[(i + 1) % 4]));
        let [first, end] = [image.width(), image.height()].map(|size| size - 1 - TILE);
        let rows = outline.map(|corner| corner[1]);
        let top = rows.into_iter().fold(f32::INFINITY, f32::min).max(1.0) as usize;
        let bottom = rows.into_iter().fold(0.0, f32::max) as usize;
        self.n_tiles = 0;
        for y in (top..=bottom.min(end)).step_by(TILE) {
            // Columns at which tiles begin.
            let (mut left, mut right) = (self.origin[0] as f32, first as f32);
            for Line { normal, offset } in sides.iter().flatten() {
                let beyond = offset + NEARLY_PX - normal[1] * (y as f32 + MIDDLE);
                let bound = beyond / normal[0] - MIDDLE;
                if normal[0] > 0.0 {
                    right = right.min(bound);
                } else if normal[0] < 0.0 {
                    left = left.max(bound);
                }
            }
            if left <= right {
                let columns = ((right - left) / TILE as f32) as usize + 1;
                self.mark_row(image, [left as usize, y], columns, least);
            }
        }
    }

    /// The same for this many tiles of a row.
    #[inline(always)]
    fn mark_row(&mut self, image: &Image<'_>, [left, y]: [usize; 2], columns: usize, least: u8) {
        /// Pixels per vector; processing more pixels than needed is faster than single ones.
        const VECTOR: usize = 32;
        let n = (columns * TILE).next_multiple_of(VECTOR);
        let n = n.min((image.width() - 1 - left) / TILE * TILE);
        let steep = &mut self.steep[..n / TILE];
        steep.fill([0; TILE]);
        for k in 0..TILE {
            let [above, here, below] = [y + k - 1, y + k, y + k + 1].map(|y| image.row(y));
            let rows = [&above[left - 1..], &here[left - 1..], &below[left - 1..]];
            mark_steep(rows, least, 1 << k, steep.as_flattened_mut());
        }
        let [x, row] = [left - self.origin[0], y - self.origin[1]];
        let mut first = (x | row << ROW) as PackedPixel;
        let tiles = &mut self.tiles[self.n_tiles..][..columns];
        let mut n = 0;
        for &steep in &steep[..columns] {
            tiles[n] = Tile {
                first,
                steep: bits(steep),
            };
            n += usize::from(steep != [0; TILE]);
            first += TILE as PackedPixel;
        }
        self.n_tiles += n;
    }

    /// Moves the pixels to their undistorted positions.
    pub(super) fn straighten(&mut self, undistortion: &Undistortion) {
        for Group { x, y, .. } in &mut self.groups {
            for (x, y) in x.iter_mut().zip(y) {
                [*x, *y] = undistortion.place([*x, *y]);
            }
        }
    }
}

/// A column and row from which the pixels within an outline, or nearly so, can be packed; `None` if it extends too far.
fn origin(image: &Image<'_>, outline: &Quad) -> Option<[usize; 2]> {
    let ends = [image.width(), image.height()].map(|size| (size - 1) as f32);
    let mut origin = [1; 2];
    for (axis, end) in ends.into_iter().enumerate() {
        let at = outline.map(|corner| corner[axis].clamp(0.0, end));
        let first = at.into_iter().fold(end, f32::min);
        let last = at.into_iter().fold(0.0, f32::max);
        if last - first > MOST_EXTENT_PX {
            return None;
        }
        origin[axis] = (first as usize).saturating_sub(TILE).max(1);
    }
    Some(origin)
}

/// A bit for each pixel of a tile, column by column.
#[inline(always)]
fn bits(steep: [u8; TILE]) -> u32 {
    let columns = u32::from_le_bytes(steep);
    let pairs = (columns | columns >> 4) & 0x00ff_00ff;
    (pairs | pairs >> 8) & 0xffff
}

/// Sets a bit for the steep pixels of a row, given with the rows above and below and one more pixel on either side. For
/// any direction, the larger difference plus half the smaller one is nearly the length of the gradient.
#[inline(always)]
fn mark_steep([above, here, below]: [&[u8]; 3], least: u8, bit: u8, steep: &mut [u8]) {
    let n = steep.len();
    let (before, after) = (&here[..n], &here[2..][..n]);
    let (above, below) = (&above[1..][..n], &below[1..][..n]);
    for i in 0..n {
        let across = before[i].abs_diff(after[i]);
        let down = above[i].abs_diff(below[i]);
        let length = across.max(down).saturating_add(across.min(down) / 2);
        steep[i] |= if length >= least { bit } else { 0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tiles_bits_are_its_steep_pixels_column_after_column() {
        assert_eq!(bits([0b1111, 0b0010, 0, 0b1001]), 0b1001_0000_0010_1111);
    }

    #[test]
    fn pixels_beside_a_step_are_steep() {
        let row: Vec<u8> = (0..42).map(|x| if x < 21 { 20 } else { 220 }).collect();
        let mut steep = [1; 40];
        mark_steep([&row, &row, &row], 100, 4, &mut steep);
        // The first marked pixel is the row's second.
        let expected = (0..40).map(|x| if x + 1 == 20 || x + 1 == 21 { 5 } else { 1 });
        assert!(steep.iter().copied().eq(expected));
    }
}
