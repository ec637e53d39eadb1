//! Which of a tag's pixels are looked at: those where the image is steep, which hold nearly all that it tells of the tag's
//! place, and a few of the flat ones beside them, for black and white.

use super::equations::{GROUP, MAX_PIXELS};
use super::straightened::Straightened;
use crate::Image;
use crate::quad::{Line, Point, Quad};

/// Pixels along a tile's edge. Tiles are taken one after the other, so that groups hold neighbours.
const TILE: usize = 4;

/// Pixels in a tile.
const AREA: usize = TILE * TILE;

/// A byte for each pixel of a tile's row.
type TileRow = [u8; TILE];

/// Tiles of a row whose steepness is looked at together: as many as fill a vector of the widest kind.
const CHUNK: usize = 8;

/// Pixels that are taken of every tile with steep ones, for black and white.
const SAMPLES: u32 = 1 << 5;

/// Least sum of the differences between the neighbours on either side, in both directions, that makes a pixel steep, as a
/// part of the contrast: in a sharp picture, and in a blurred one, whose edges are flatter.
const STEEP: [f32; 2] = [0.6, 0.2];

/// Pixels that are taken for each pixel of an edge's length: usually, and at least where the picture is sharp.
const PIXELS_PER_LENGTH: f32 = 2.2;
const LEAST_PER_LENGTH: f32 = 1.2;

/// Neighbouring pixels: their places, straightened if there is a lens, and their greys.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<'a> {
    pub(super) x: &'a [f32; GROUP],
    pub(super) y: &'a [f32; GROUP],
    pub(super) grey: &'a [f32; GROUP],
}

/// A tag in an image as it seems to lie.
pub(super) struct Tag<'a> {
    pub(super) image: &'a Image<'a>,
    /// Of all that shows the pattern, in the image.
    pub(super) outline: Quad,
    /// White less black.
    pub(super) contrast: f32,
    /// Length of all edges between black and white.
    pub(super) edges_px: f32,
    pub(super) straightened: Option<&'a Straightened>,
}

#[derive(Debug)]
struct Chosen {
    x: Vec<f32>,
    y: Vec<f32>,
    grey: Vec<f32>,
    /// Pixels in use.
    n: usize,
}

#[derive(Debug)]
pub(super) struct Pixels {
    chosen: Chosen,
    /// Which are steep in a row of tiles.
    steep: [Vec<TileRow>; TILE],
}

impl Default for Pixels {
    fn default() -> Self {
        let room = || vec![0.0; MAX_PIXELS];
        Self {
            chosen: Chosen {
                x: room(),
                y: room(),
                grey: room(),
                n: 0,
            },
            steep: std::array::from_fn(|_| vec![[0; TILE]; Image::MAX_WIDTH / TILE]),
        }
    }
}

impl Pixels {
    pub(super) fn groups(&self) -> impl ExactSizeIterator<Item = Group<'_>> {
        let Chosen { x, y, grey, n } = &self.chosen;
        let places = x[..*n].as_chunks().0.iter().zip(y[..*n].as_chunks().0);
        let pixels = places.zip(grey[..*n].as_chunks().0);
        pixels.map(|((x, y), grey)| Group { x, y, grey })
    }

    /// Gathers the pixels to look at.
    #[inline(always)]
    pub(super) fn choose(&mut self, tag: &Tag<'_>) {
        let share = (MAX_PIXELS as f32 / (PIXELS_PER_LENGTH * tag.edges_px)).min(1.0);
        for steep in STEEP {
            let least = (steep * tag.contrast).clamp(1.0, 255.0) as u8;
            self.take_steep(tag, least, share);
            if self.chosen.n as f32 > LEAST_PER_LENGTH * share * tag.edges_px {
                break;
            }
        }
        self.chosen.fill_up();
    }

    /// Gathers pixels of a share of the tiles with steep ones.
    #[inline(always)]
    fn take_steep(&mut self, tag: &Tag<'_>, least: u8, share: f32) {
        self.chosen.n = 0;
        let Some(sides) = sides(&tag.outline) else {
            return;
        };
        let [(left, columns), (top, rows)] = tiles(tag);
        let mut due = 0.5;
        for y in (top..).step_by(TILE).take(rows) {
            // With a pixel more on all sides.
            let rows: [&[u8]; TILE + 2] = std::array::from_fn(|k| {
                &tag.image.row(y + k - 1)[left - 1..][..columns * TILE + 2]
            });
            for (k, steep) in self.steep.iter_mut().enumerate() {
                mark_steep(
                    [rows[k], rows[k + 1], rows[k + 2]],
                    least,
                    &mut steep[..columns],
                );
            }
            let greys: [&[TileRow]; TILE] = std::array::from_fn(|k| rows[k + 1][1..].as_chunks().0);
            let steep: [&[TileRow]; TILE] = std::array::from_fn(|k| &self.steep[k][..columns]);
            for column in 0..columns {
                let of_tile = |rows: &[&[TileRow]; TILE]| {
                    [
                        rows[0][column],
                        rows[1][column],
                        rows[2][column],
                        rows[3][column],
                    ]
                };
                let steep = of_tile(&steep);
                let tile = [(left + column * TILE) as f32, y as f32];
                if steep.map(u32::from_le_bytes) == [0; TILE] || !is_within(&sides, tile) {
                    continue;
                }
                due += share;
                if due >= 1.0 {
                    due -= 1.0;
                    let (bits, greys) = (bits(steep) | SAMPLES, of_tile(&greys));
                    self.chosen
                        .take(bits, tag.places(tile), greys.as_flattened());
                }
            }
        }
    }
}

impl Chosen {
    /// Takes the pixels of a tile whose bits are set.
    #[inline(always)]
    fn take(&mut self, mut bits: u32, [x, y]: [[f32; AREA]; 2], greys: &[u8]) {
        let room = self.n..self.n + AREA;
        let (Some(to_x), Some(to_y), Some(to_grey)) = (
            self.x.get_mut(room.clone()),
            self.y.get_mut(room.clone()),
            self.grey.get_mut(room),
        ) else {
            return;
        };
        let mut to = 0;
        while bits != 0 {
            let i = bits.trailing_zeros() as usize % AREA;
            (to_x[to], to_y[to], to_grey[to]) = (x[i], y[i], f32::from(greys[i]));
            bits &= bits - 1;
            to += 1;
        }
        self.n += to;
    }

    /// Completes the last group with pixels that count nothing, as they stray too far.
    fn fill_up(&mut self) {
        const NO_GREY: f32 = 1e6;
        let (Some(last), end) = (self.n.checked_sub(1), self.n.next_multiple_of(GROUP)) else {
            return;
        };
        let (x, y) = (self.x[last], self.y[last]);
        self.x[self.n..end].fill(x);
        self.y[self.n..end].fill(y);
        self.grey[self.n..end].fill(NO_GREY);
        self.n = end;
    }
}

impl Tag<'_> {
    /// Of a tile's pixels.
    #[inline(always)]
    fn places(&self, tile: Point) -> [[f32; AREA]; 2] {
        let local = self
            .straightened
            .and_then(|straightened| straightened.near(tile));
        let (first, by_pixel) = local.unwrap_or((tile, [[1.0, 0.0], [0.0, 1.0]]));
        let mut places = [[0.0; AREA]; 2];
        for (axis, along) in places.iter_mut().enumerate() {
            for (i, place) in along.iter_mut().enumerate() {
                let (x, y) = ((i % TILE) as f32, (i / TILE) as f32);
                *place = first[axis] + by_pixel[axis][0] * x + by_pixel[axis][1] * y;
            }
        }
        places
    }
}

/// First pixel and number of the tiles around a tag, along either axis: all but the image's rim, as pixels there have no
/// neighbours.
fn tiles(tag: &Tag<'_>) -> [(usize, usize); 2] {
    let size = [tag.image.width(), tag.image.height()];
    [0, 1].map(|axis| {
        let along = tag.outline.map(|corner| corner[axis]);
        let end = size[axis] - 1;
        let low = along.into_iter().fold(f32::INFINITY, f32::min).max(1.0) as usize;
        let high = along.into_iter().fold(0.0, f32::max) as usize;
        let (low, high) = (low.min(end), high.min(end));
        let n = (high.saturating_sub(low) / TILE + 1).next_multiple_of([CHUNK, 1][axis]);
        (low, n.min((end - low) / TILE))
    })
}

fn sides(outline: &Quad) -> Option<[Line; 4]> {
    let side = |i: usize| Line::through(outline[i], outline[(i + 1) % 4]);
    Some([side(0)?, side(1)?, side(2)?, side(3)?])
}

/// Whether a tile's middle is within, or nearly.
#[inline(always)]
fn is_within(sides: &[Line; 4], [x, y]: Point) -> bool {
    const MIDDLE: f32 = (TILE - 1) as f32 / 2.0;
    let middle = [x + MIDDLE, y + MIDDLE];
    sides
        .iter()
        .all(|side| side.distance(middle) < TILE as f32 / 2.0)
}

/// A bit for each pixel of a tile that is steep.
#[inline(always)]
fn bits(steep: [TileRow; TILE]) -> u32 {
    /// Brings the lowest bits of four bytes together in the highest byte.
    const GATHER: u32 = 0x0102_0408;
    let [a, b, c, d] = steep;
    let bits = |row| u32::from_le_bytes(row).wrapping_mul(GATHER) >> 24;
    bits(a) | bits(b) << 4 | bits(c) << 8 | bits(d) << 12
}

/// Marks the steep pixels of a row, given with the rows above and below and a pixel more on either side.
#[inline(always)]
fn mark_steep(rows: [&[u8]; 3], least: u8, steep: &mut [TileRow]) {
    let (chunks, rest) = steep.as_chunks_mut::<CHUNK>();
    let mut first = 0;
    for chunk in chunks {
        mark(
            rows.map(|row| &row[first..]),
            least,
            chunk.as_flattened_mut(),
        );
        first += CHUNK * TILE;
    }
    mark(
        rows.map(|row| &row[first..]),
        least,
        rest.as_flattened_mut(),
    );
}

#[inline(always)]
fn mark([above, here, below]: [&[u8]; 3], least: u8, steep: &mut [u8]) {
    let n = steep.len();
    let (before, after) = (&here[..n], &here[2..][..n]);
    let (above, below) = (&above[1..][..n], &below[1..][..n]);
    for i in 0..n {
        let across = before[i].abs_diff(after[i]);
        let down = above[i].abs_diff(below[i]);
        steep[i] = u8::from(across.saturating_add(down) >= least);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tiles_bits_are_its_steep_pixels_row_after_row() {
        let steep = [[1, 0, 0, 1], [0; 4], [0, 1, 0, 0], [1; 4]];
        assert_eq!(bits(steep), 0b1111_0010_0000_1001);
    }

    #[test]
    fn pixels_beside_a_step_are_steep() {
        let row: Vec<u8> = (0..42).map(|x| if x < 21 { 20 } else { 220 }).collect();
        let mut steep = [[9; TILE]; 10];
        mark_steep([&row, &row, &row], 100, &mut steep);
        // The first pixel that is marked is the row's second.
        let expected = (0..40).map(|x| u8::from(x + 1 == 20 || x + 1 == 21));
        assert!(steep.as_flattened().iter().copied().eq(expected));
    }
}
