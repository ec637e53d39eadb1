//! Which of a tag's pixels are looked at: those where the image is steep, which hold nearly all that it tells of the tag's
//! place, and a few all over the tag, for black and white.

use super::equations::GROUP;
use super::straightened::Straightened;
use crate::Image;
use crate::kernels::{MAX_GROUPS, all_or_nothing, top_bits};
use crate::quad::{Line, Quad};
use std::array::from_fn;

/// Pixels that are looked at, at most.
const MOST: u32 = (MAX_GROUPS * GROUP) as u32;

/// Distance between the pixels of a grid that are looked at, steep or not.
const GRID: usize = 4;

/// Least difference between the neighbours on either side that makes a pixel steep, as a part of the contrast.
const STEEP: f32 = 0.35;

/// A bit for each pixel of a block that is on the grid.
const EACH_OF_GRID: u32 = 0x1111_1111;

/// Rows at the lower rim, from which blocks reach beyond the pixels of an image.
const RIM: usize = 4;

/// Pixels beside each other that are asked at once.
const BLOCK: usize = 32;

/// Pixels: their places, straightened if there is a lens, and their greys.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Group {
    pub(super) x: [f32; GROUP],
    pub(super) y: [f32; GROUP],
    pub(super) grey: [f32; GROUP],
}

/// The place of the first of pixels beside each other, and a bit for each, the least significant leftmost, set where it is to
/// be looked at.
#[derive(Clone, Copy, Debug)]
struct Block {
    x: u16,
    y: u16,
    marks: u32,
}

#[derive(Debug)]
pub(super) struct Pixels {
    groups: Vec<Group>,
    blocks: Vec<Block>,
}

impl Default for Pixels {
    fn default() -> Self {
        const MOST_BLOCKS: usize = (Image::MAX_WIDTH / BLOCK + 1) * Image::MAX_HEIGHT;
        Self {
            groups: Vec::with_capacity(MAX_GROUPS),
            blocks: Vec::with_capacity(MOST_BLOCKS),
        }
    }
}

impl Pixels {
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Gathers the pixels to look at of a tag with this outline and contrast: all that are steep, or some of these, evenly. Each
    /// group has some from all over the tag.
    #[inline(always)]
    pub(super) fn choose(&mut self, image: &Image<'_>, outline: &Quad, contrast: f32) {
        self.mark(image, outline, (STEEP * contrast).clamp(1.0, 255.0) as u8);
        let marks = self.blocks.iter().map(|block| block.marks.count_ones());
        let n_marked: u32 = marks.sum();
        let n_groups = MOST.min(n_marked) / GROUP as u32;
        let share = f64::from(n_groups * GROUP as u32) / f64::from(n_marked);
        self.groups.clear();
        self.groups.resize(n_groups as usize, Group::default());
        let mut due = 0.0;
        for Block { x, y, mut marks } in self.blocks.iter().copied() {
            let row = image.row(usize::from(y));
            while marks != 0 {
                let x = usize::from(x) + marks.trailing_zeros() as usize;
                marks &= marks - 1;
                let number = due as u32;
                due += share;
                if number != due as u32 {
                    let group = &mut self.groups[(number % n_groups) as usize];
                    let i = (number / n_groups) as usize;
                    group.x[i] = x as f32;
                    group.y[i] = f32::from(y);
                    group.grey[i] = f32::from(row[x]);
                }
            }
        }
    }

    /// Marks the pixels within the outline that are steep or on the grid; none at the image's rim, as those there have no
    /// neighbours.
    #[inline(always)]
    fn mark(&mut self, image: &Image<'_>, outline: &Quad, least: u8) {
        let (pixels, stride) = image.bytes();
        let sides: [_; 4] = from_fn(|i| Line::through(outline[i], outline[(i + 1) % 4]));
        let rows = outline.map(|corner| corner[1]);
        let top = rows.into_iter().fold(f32::INFINITY, f32::min).max(1.0) as usize;
        let bottom = rows.into_iter().fold(0.0, f32::max) as usize;
        self.blocks.clear();
        for y in top..=bottom.min(image.height() - RIM) {
            let (mut left, mut right) = (1.0_f32, (image.width() - 2) as f32);
            for Line { normal, offset } in sides.iter().flatten() {
                let bound = (offset - normal[1] * y as f32) / normal[0];
                if normal[0] > 0.0 {
                    right = right.min(bound);
                } else if normal[0] < 0.0 {
                    left = left.max(bound);
                }
            }
            let grid = if y.is_multiple_of(GRID) {
                EACH_OF_GRID
            } else {
                0
            };
            let end = (right + 1.0) as usize;
            for x in (left as usize..end).step_by(BLOCK) {
                let steep = steep_pixels(&pixels[(y - 1) * stride + x - 1..], stride, least);
                let marks = (steep | grid) & u32::MAX >> BLOCK.saturating_sub(end - x);
                let (x, y) = (x as u16, y as u16);
                self.blocks.push(Block { x, y, marks });
            }
        }
    }

    /// Moves the pixels to where they would be without the lens.
    pub(super) fn straighten(&mut self, straightened: &Straightened) {
        for Group { x, y, .. } in &mut self.groups {
            for (x, y) in x.iter_mut().zip(y) {
                [*x, *y] = straightened.place([*x, *y]);
            }
        }
    }
}

/// A bit for each pixel of a block that is steep. Before it there is a pixel more in its row, the second of the given ones; along
/// and across edges alike: the greater difference and half the smaller one are nearly the length of both.
#[inline(always)]
fn steep_pixels(rows: &[u8], stride: usize, least: u8) -> u32 {
    let block = |from: usize| &rows[from..].as_chunks::<BLOCK>().0[0];
    let (above, below) = (block(1), block(2 * stride + 1));
    let (before, after) = (block(stride), block(stride + 2));
    let mut steep = [0; BLOCK];
    for i in 0..BLOCK {
        let across = before[i].abs_diff(after[i]);
        let down = above[i].abs_diff(below[i]);
        let length = across.max(down).saturating_add(across.min(down) / 2);
        steep[i] = all_or_nothing(length >= least);
    }
    top_bits(&steep) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_beside_a_step_are_steep() {
        let row: [u8; BLOCK + 2] = from_fn(|x| if x < 7 { 20 } else { 220 });
        // The first pixel that is told of is the row's second.
        assert_eq!(steep_pixels(&[row; 3].concat(), row.len(), 100), 0b11 << 5);
    }
}
