//! Which of a tag's pixels are looked at: those where the image is steep, which hold nearly all that it tells of the tag's
//! place, and a few of the flat ones beside them, for black and white.

use super::equations::{GROUP, MAX_PIXELS};
use super::model::Model;
use super::straightened::Straightened;
use crate::Image;
use crate::quad::{Line, Point, Quad};
use std::ops::Range;

/// Pixels along a tile's edge. Tiles are taken one after the other, so that groups hold neighbours.
const TILE: usize = 4;

/// Pixels in a tile.
const AREA: usize = TILE * TILE;

/// A byte for each column of a tile, a bit for each of its rows: set where the pixel is steep.
type Steep = [u8; TILE];

/// The pixel that is taken of every tile with steep ones, for black and white.
const SAMPLE: Steep = [0, 0b0010, 0, 0];

/// Least difference between the neighbours on either side that makes a pixel steep, as a part of the contrast: in a sharp
/// picture, and in a blurred one, whose edges are flatter.
const STEEP: [f32; 2] = [0.6, 0.2];

/// Steep pixels for each pixel of an edge's length, at least, in a sharp picture.
const LEAST_PER_LENGTH: f32 = 1.0;

/// Neighbouring pixels: their places, straightened if there is a lens, and their greys.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<'a> {
    pub(super) x: &'a [f32; GROUP],
    pub(super) y: &'a [f32; GROUP],
    pub(super) grey: &'a [f32; GROUP],
    /// Greys a little beyond the ring's outer edge, from pixels near it; before it was looked for, and elsewhere, their own.
    pub(super) beyond: &'a [f32; GROUP],
}

/// A tag in an image as it seems to lie.
pub(super) struct Tag<'a> {
    pub(super) image: &'a Image<'a>,
    /// Of all that shows the pattern, straightened.
    pub(super) outline: Quad,
    /// White less black.
    pub(super) contrast: f32,
    /// Length of all edges between black and white.
    pub(super) edges_px: f32,
    pub(super) straightened: Option<&'a Straightened>,
}

impl Tag<'_> {
    /// Where the image shows a place.
    fn pixel(&self, place: Point) -> Point {
        let pixel = self.straightened.map(|lens| lens.pixel(place));
        pixel.flatten().unwrap_or(place)
    }

    /// Grey of the pixel nearest to a place.
    fn nearest(&self, place: Point) -> u8 {
        let [x, y] = self.pixel(place).map(|at| (at + 0.5).max(0.0) as usize);
        let (width, height) = (self.image.width(), self.image.height());
        self.image.row(y.min(height - 1))[x.min(width - 1)]
    }
}

#[derive(Debug)]
pub(super) struct Pixels {
    x: Vec<f32>,
    y: Vec<f32>,
    grey: Vec<f32>,
    beyond: Vec<f32>,
    taken: Taken,
    /// Of the tiles around a tag, row after row.
    steep: Vec<Steep>,
}

impl Default for Pixels {
    fn default() -> Self {
        let room = || vec![0.0; MAX_PIXELS];
        Self {
            x: room(),
            y: room(),
            grey: room(),
            beyond: room(),
            taken: Taken {
                pixels: vec![0; MAX_PIXELS],
                n: 0,
            },
            steep: vec![[0; TILE]; Image::MAX_WIDTH * Image::MAX_HEIGHT / AREA],
        }
    }
}

impl Pixels {
    pub(super) fn groups(&self) -> impl ExactSizeIterator<Item = Group<'_>> {
        let n = self.taken.n.next_multiple_of(GROUP);
        let places = (self.x[..n].as_chunks().0.iter()).zip(self.y[..n].as_chunks().0);
        let greys = (self.grey[..n].as_chunks().0.iter()).zip(self.beyond[..n].as_chunks().0);
        let pixels = places.zip(greys);
        pixels.map(|((x, y), (grey, beyond))| Group { x, y, grey, beyond })
    }

    /// Looks at the greys beyond the ring.
    pub(super) fn look_beyond(&mut self, tag: &Tag<'_>, model: &Model<'_>) {
        let n = self.taken.n.next_multiple_of(GROUP);
        let places = (self.x[..n].as_chunks().0.iter()).zip(self.y[..n].as_chunks().0);
        for ((x, y), greys) in places.zip(self.beyond[..n].as_chunks_mut::<GROUP>().0) {
            for (place, grey) in model.beyond([x, y]).into_iter().zip(greys) {
                *grey = f32::from(tag.nearest(place));
            }
        }
    }

    /// Gathers the pixels to look at.
    #[inline(always)]
    pub(super) fn choose(&mut self, tag: &Tag<'_>) {
        let tiles = Tiles::around(tag);
        let mut share = 1.0;
        for steep in STEEP {
            let least = (steep * tag.contrast).clamp(1.0, 255.0) as u8;
            let (n_pixels, n_tiles) = self.mark(tag, &tiles, least);
            share = MAX_PIXELS as f32 / (n_pixels + n_tiles) as f32;
            if n_pixels as f32 > LEAST_PER_LENGTH * tag.edges_px {
                break;
            }
        }
        self.take(tag, &tiles, share);
        self.straighten(tag);
    }

    /// Marks the steep pixels of the tiles within the tag; how many there are, and tiles with any.
    #[inline(always)]
    fn mark(&mut self, tag: &Tag<'_>, tiles: &Tiles, least: u8) -> (u32, u32) {
        let (mut n_pixels, mut n_tiles) = (0, 0);
        for row in 0..tiles.rows {
            let steep = &mut self.steep[row * tiles.columns..][..tiles.columns];
            steep.fill([0; TILE]);
            let rows = tiles.pixels(tag.image, row);
            for k in 0..TILE {
                let rows = [rows[k], rows[k + 1], rows[k + 2]];
                mark_steep(rows, least, 1 << k, steep.as_flattened_mut());
            }
            let within = tiles.within(row);
            for (column, steep) in steep.iter_mut().enumerate() {
                if !within.contains(&column) {
                    *steep = [0; TILE];
                }
                n_tiles += u32::from(*steep != [0; TILE]);
                n_pixels += u32::from_le_bytes(*steep).count_ones();
            }
        }
        (n_pixels, n_tiles)
    }

    /// Takes the pixels of a share of the tiles with steep ones.
    #[inline(always)]
    fn take(&mut self, tag: &Tag<'_>, tiles: &Tiles, share: f32) {
        self.taken.n = 0;
        let mut due = 0.5;
        for row in 0..tiles.rows {
            let steep = &self.steep[row * tiles.columns..][..tiles.columns];
            let [_, a, b, c, d, _] = tiles.pixels(tag.image, row);
            let [a, b, c, d]: [&[[u8; TILE]]; TILE] = [
                a[1..].as_chunks().0,
                b[1..].as_chunks().0,
                c[1..].as_chunks().0,
                d[1..].as_chunks().0,
            ];
            for (column, &steep) in steep.iter().enumerate() {
                if steep == [0; TILE] {
                    continue;
                }
                due += share.min(1.0);
                if due >= 1.0 {
                    due -= 1.0;
                    let greys = [a[column], b[column], c[column], d[column]];
                    let [x, y] = tiles.first_pixel(column, row);
                    self.taken
                        .add(bits(steep) | bits(SAMPLE), pack(x, y, 0), &greys);
                }
            }
        }
    }

    /// Spreads what was taken, and completes the last group with pixels that count nothing, as they stray too far.
    #[inline(always)]
    fn straighten(&mut self, tag: &Tag<'_>) {
        const NO_GREY: f32 = 1e6;
        let Taken { pixels, n } = &self.taken;
        let places = self.x.iter_mut().zip(&mut self.y);
        for ((pixel, (x, y)), grey) in pixels[..*n].iter().zip(places).zip(&mut self.grey) {
            (*x, *y) = (
                (pixel & COORDINATE) as f32,
                (pixel >> Y & COORDINATE) as f32,
            );
            *grey = (pixel >> GREY) as f32;
        }
        let end = n.next_multiple_of(GROUP);
        for i in *n..end {
            (self.x[i], self.y[i], self.grey[i]) = (self.x[n - 1], self.y[n - 1], NO_GREY);
        }
        self.beyond[..end].copy_from_slice(&self.grey[..end]);
        if let Some(straightened) = tag.straightened {
            for (x, y) in self.x.iter_mut().zip(&mut self.y).take(*n) {
                [*x, *y] = straightened.place([*x, *y]).unwrap_or([*x, *y]);
            }
        }
    }
}

/// Lowest bits of a pixel's y and of its grey where both are packed into a number with x, and the bits of x.
const Y: u32 = 12;
const GREY: u32 = 24;
const COORDINATE: u32 = (1 << Y) - 1;

#[inline(always)]
fn pack(x: usize, y: usize, grey: u8) -> u32 {
    x as u32 | (y as u32) << Y | u32::from(grey) << GREY
}

/// Pixels, packed.
#[derive(Debug)]
struct Taken {
    pixels: Vec<u32>,
    /// In use.
    n: usize,
}

impl Taken {
    /// Adds the pixels of a tile whose bits are set, column after column.
    #[inline(always)]
    fn add(&mut self, mut bits: u32, first: u32, greys: &[[u8; TILE]; TILE]) {
        let Some(to) = self.pixels.get_mut(self.n..self.n + AREA) else {
            return;
        };
        let all: [u32; AREA] = std::array::from_fn(|i| {
            let (column, row) = (i / TILE, i % TILE);
            first + pack(column, row, greys[row][column])
        });
        let n = bits.count_ones() as usize;
        for pixel in &mut to[..n.min(AREA)] {
            *pixel = all[bits.trailing_zeros() as usize % AREA];
            bits &= bits - 1;
        }
        self.n += n;
    }
}

/// The tiles around a tag: all but the image's rim, as pixels there have no neighbours.
struct Tiles {
    left: usize,
    top: usize,
    columns: usize,
    rows: usize,
    /// Of the tag's outline.
    sides: [Option<Line>; 4],
}

impl Tiles {
    fn around(tag: &Tag<'_>) -> Self {
        let image = tag.image;
        let outline = tag.outline.map(|place| tag.pixel(place));
        let [(left, columns), (top, rows)] =
            [(0, image.width()), (1, image.height())].map(|(axis, size)| {
                let along = outline.map(|corner| corner[axis]);
                let end = size - 1;
                let low = along.into_iter().fold(f32::INFINITY, f32::min).max(1.0) as usize;
                let high = along.into_iter().fold(0.0, f32::max) as usize;
                let (low, high) = (low.min(end), high.min(end));
                (
                    low,
                    (high.saturating_sub(low) / TILE + 1).min((end - low) / TILE),
                )
            });
        Self {
            left,
            top,
            columns,
            rows,
            sides: std::array::from_fn(|i| Line::through(outline[i], outline[(i + 1) % 4])),
        }
    }

    /// The pixels of a row of tiles, with one more on all sides.
    #[inline(always)]
    fn pixels<'a>(&self, image: &Image<'a>, row: usize) -> [&'a [u8]; TILE + 2] {
        let along = self.left - 1..self.left + 1 + self.columns * TILE;
        let pixels = |k: usize| &image.row(self.top + row * TILE + k - 1)[along.clone()];
        [
            pixels(0),
            pixels(1),
            pixels(2),
            pixels(3),
            pixels(4),
            pixels(5),
        ]
    }

    #[inline(always)]
    fn first_pixel(&self, column: usize, row: usize) -> [usize; 2] {
        [self.left + column * TILE, self.top + row * TILE]
    }

    /// Columns of the tiles in a row whose middles are within the outline, or nearly.
    fn within(&self, row: usize) -> Range<usize> {
        const MIDDLE: f32 = (TILE - 1) as f32 / 2.0;
        let (left, y) = (
            self.left as f32 + MIDDLE,
            (self.top + row * TILE) as f32 + MIDDLE,
        );
        let (mut low, mut high) = (0.0_f32, self.columns as f32);
        for side in self.sides.iter().flatten() {
            let [slope, _] = side.normal;
            let end = (TILE as f32 / 2.0 - side.distance([left, y])) / (slope * TILE as f32);
            if slope > 0.0 {
                high = high.min(end + 1.0);
            } else if slope < 0.0 {
                low = low.max(end.ceil());
            }
        }
        low as usize..high as usize
    }
}

/// A bit for each pixel of a tile, column after column.
#[inline(always)]
fn bits(steep: Steep) -> u32 {
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
