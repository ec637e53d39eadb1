//! Which of a tag's pixels are looked at: those where the image is steep, which hold nearly all that it tells of the tag's
//! place, and a few of the flat ones beside them, for black and white.

use super::equations::GROUP;
use super::straightened::Straightened;
use crate::Image;
use crate::kernels::MAX_GROUPS;
use crate::quad::{Line, Quad};
use std::array::from_fn;

/// Pixels along a tile's edge. Tiles are taken one after the other, so that groups hold neighbours.
const TILE: usize = 4;

/// Pixels in a tile.
const AREA: usize = TILE * TILE;

/// The pixel that is taken of every tile with steep ones, for black and white.
const SAMPLE: u32 = 1 << 5;

/// Least difference between the neighbours on either side that makes a pixel steep, as a part of the contrast: in a sharp
/// picture, and in a blurred one, whose edges are flatter.
const STEEP: [f32; 2] = [0.6, 0.2];

/// Neighbouring pixels: their places, straightened if there is a lens, and their greys.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) x: [f32; GROUP],
    pub(super) y: [f32; GROUP],
    pub(super) grey: [f32; GROUP],
}

/// A tile with steep pixels: its first pixel, and a bit for each, column after column, set where it is steep.
#[derive(Clone, Copy, Debug)]
struct Tile {
    x: u16,
    y: u16,
    steep: u32,
}

#[derive(Debug)]
pub(super) struct Pixels {
    groups: Vec<Group>,
    /// Of each pixel that is looked at its column, with the row above it in the higher bits, and its grey.
    places: Vec<u32>,
    greys: Vec<u8>,
    tiles: Vec<Tile>,
    /// Of a row of tiles, a byte for each column of pixels, a bit for each row: set where the pixel is steep.
    steep: Vec<[u8; TILE]>,
}

/// Pixels that are looked at, at most.
const MOST: usize = MAX_GROUPS * GROUP;

impl Default for Pixels {
    fn default() -> Self {
        Self {
            groups: Vec::with_capacity(MAX_GROUPS),
            places: vec![0; MOST + AREA],
            greys: vec![0; MOST + AREA],
            tiles: Vec::with_capacity(Image::MAX_WIDTH * Image::MAX_HEIGHT / AREA),
            steep: vec![[0; TILE]; Image::MAX_WIDTH / TILE],
        }
    }
}

impl Pixels {
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Gathers the pixels to look at of a tag with this outline, contrast and length of all edges. In a sharp picture more of
    /// them than that length are steep.
    #[inline(always)]
    pub(super) fn choose(
        &mut self,
        image: &Image<'_>,
        outline: &Quad,
        contrast: f32,
        edges_px: f32,
    ) {
        let mut n_steep = 0;
        for steep in STEEP {
            if n_steep as f32 <= edges_px {
                self.mark(image, outline, (steep * contrast).clamp(1.0, 255.0) as u8);
                n_steep = self.tiles.iter().map(|tile| tile.steep.count_ones()).sum();
            }
        }
        let share = (MOST as f32 / (n_steep + self.tiles.len() as u32) as f32).min(1.0);
        let (pixels, stride) = image.bytes();
        let beyond_first: [_; AREA] = from_fn(|at| {
            let (column, row) = (at / TILE, at % TILE);
            ((row << 16 | column) as u32, row * stride + column)
        });
        let (places, greys) = (&mut self.places[..], &mut self.greys[..]);
        let (mut n, mut due) = (0, 0.5);
        for tile in &self.tiles {
            due += share;
            if due < 1.0 || n >= MOST {
                continue;
            }
            due -= 1.0;
            let first = usize::from(tile.y) * stride + usize::from(tile.x);
            let place = u32::from(tile.x) | u32::from(tile.y) << 16;
            let mut steep = tile.steep | SAMPLE;
            while steep != 0 {
                let (aside, beyond) = beyond_first[steep.trailing_zeros() as usize % AREA];
                (places[n], greys[n]) = (place + aside, pixels[first + beyond]);
                steep &= steep - 1;
                n += 1;
            }
        }
        self.groups.clear();
        let places = places[..n.min(MOST)].as_chunks::<GROUP>().0;
        let greys = greys.as_chunks::<GROUP>().0;
        for (places, greys) in places.iter().zip(greys) {
            let [mut x, mut y, mut grey] = [[0.0; GROUP]; 3];
            for i in 0..GROUP {
                x[i] = (places[i] & 0xffff) as i32 as f32;
                y[i] = (places[i] >> 16) as i32 as f32;
                grey[i] = f32::from(greys[i]);
            }
            self.groups.push(Group { x, y, grey });
        }
    }

    /// Finds the tiles with steep pixels among those that are within the outline, or nearly; all but those at the image's rim, as
    /// pixels there have no neighbours.
    #[inline(always)]
    fn mark(&mut self, image: &Image<'_>, outline: &Quad, least: u8) {
        const MIDDLE: f32 = (TILE - 1) as f32 / 2.0;
        let sides: [_; 4] = from_fn(|i| Line::through(outline[i], outline[(i + 1) % 4]));
        let [(left, right), (top, bottom)] =
            [(0, image.width()), (1, image.height())].map(|(axis, size)| {
                let along = outline.map(|corner| corner[axis]);
                let low = along.into_iter().fold(f32::INFINITY, f32::min).max(1.0) as usize;
                let high = along.into_iter().fold(0.0, f32::max) as usize + TILE;
                (low.min(size - 1), high.min(size - 1))
            });
        let columns = right.saturating_sub(left) / TILE;
        self.tiles.clear();
        for y in (top..bottom.saturating_sub(TILE - 1)).step_by(TILE) {
            let steep = &mut self.steep[..columns];
            steep.fill([0; TILE]);
            let rows: [_; TILE + 2] =
                from_fn(|k| &image.row(y + k - 1)[left - 1..][..columns * TILE + 2]);
            for k in 0..TILE {
                mark_steep(
                    [rows[k], rows[k + 1], rows[k + 2]],
                    least,
                    1 << k,
                    steep.as_flattened_mut(),
                );
            }
            for (column, &steep) in steep.iter().enumerate() {
                let x = left + column * TILE;
                let middle = [x as f32 + MIDDLE, y as f32 + MIDDLE];
                let within = |side: &Line| side.distance(middle) < TILE as f32 / 2.0;
                if steep != [0; TILE] && sides.iter().flatten().all(within) {
                    let (x, y) = (x as u16, y as u16);
                    self.tiles.push(Tile {
                        x,
                        y,
                        steep: bits(steep),
                    });
                }
            }
        }
    }

    /// Moves the pixels to where they would be without the lens.
    pub(super) fn straighten(&mut self, straightened: &Straightened) {
        for Group { x, y, .. } in &mut self.groups {
            for (x, y) in x.iter_mut().zip(y) {
                [*x, *y] = straightened.place([*x, *y]).unwrap_or([*x, *y]);
            }
        }
    }
}

/// A bit for each pixel of a tile, column after column.
#[inline(always)]
fn bits(steep: [u8; TILE]) -> u32 {
    let columns = u32::from_le_bytes(steep);
    let pairs = (columns | columns >> 4) & 0x00ff_00ff;
    (pairs | pairs >> 8) & 0xffff
}

/// Sets a bit for the steep pixels of a row, given with the rows above and below and a pixel more on either side. Along and
/// across edges alike: the greater difference and half the smaller one are nearly the length of both.
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
        // The first pixel that is marked is the row's second.
        let expected = (0..40).map(|x| if x + 1 == 20 || x + 1 == 21 { 5 } else { 1 });
        assert!(steep.iter().copied().eq(expected));
    }
}
