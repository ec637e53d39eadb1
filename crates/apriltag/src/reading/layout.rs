//! The modules of a family that are looked at: border, ring around it, bits.

use crate::kernels::{POINTS, Points};
use sextant_tag_families::FamilyData;
use std::ops::Range;

/// Most modules that are looked at: as many as a byte counts.
pub(super) const MAX_MODULES: usize = 256;

#[derive(Debug)]
pub(super) struct Layout {
    /// Modules along the border.
    pub(super) border_width: f32,
    /// Middles of the modules on the square -1..1 of the border. Border and ring fill whole blocks, and so do the bits; what
    /// pads them counts for nothing.
    pub(super) places: Vec<[Points; 2]>,
    /// The bits once more, at four places around each middle.
    pub(super) around: [Vec<[Points; 2]>; 4],
    pub(super) border: Range<usize>,
    pub(super) ring: Range<usize>,
    pub(super) bits: Range<usize>,
    /// Of each bit the modules to the left and right, above and below; itself where one is missing.
    pub(super) beside: Vec<[u8; 4]>,
}

impl Layout {
    pub(super) fn new(data: &FamilyData) -> Self {
        let width = i16::from(data.border_width);
        let mut modules = ring_modules(0, width - 1);
        let border = 0..modules.len();
        modules.extend(ring_modules(-1, width));
        let ring = border.end..modules.len();
        modules.resize(ring.end.next_multiple_of(POINTS), [0, 0]);
        let bits = modules.len()..modules.len() + data.bits.len();
        modules.extend(data.bits.iter().map(|&(x, y)| [i16::from(x), i16::from(y)]));
        let around = [[-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]];
        Self {
            border_width: f32::from(data.border_width),
            places: blocks(&modules, [0.0; 2], width),
            around: around.map(|aside| blocks(&modules[bits.clone()], aside, width)),
            beside: bits
                .clone()
                .map(|i| beside(modules[i], &modules).unwrap_or([i as u8; 4]))
                .collect(),
            border,
            ring,
            bits,
        }
    }

    /// Blocks of border and ring.
    pub(super) fn ring_blocks(&self) -> usize {
        self.bits.start / POINTS
    }
}

/// The middles of modules, of so many along the border, moved aside.
fn blocks(modules: &[[i16; 2]], aside: [f32; 2], width: i16) -> Vec<[Points; 2]> {
    let block = |block: &[[i16; 2]]| {
        let coordinate = |i: usize, axis: usize| {
            let module = block.get(i).unwrap_or(&block[0]);
            (f32::from(2 * module[axis] + 1 - width) + 2.0 * aside[axis]) / f32::from(width)
        };
        [0, 1].map(|axis| std::array::from_fn(|i| coordinate(i, axis)))
    };
    modules.chunks(POINTS).map(block).collect()
}

/// Where the four modules beside one stand, if all do.
fn beside([x, y]: [i16; 2], modules: &[[i16; 2]]) -> Option<[u8; 4]> {
    let place = |module| modules.iter().position(|&other| other == module);
    let [left, right] = [place([x - 1, y])?, place([x + 1, y])?];
    let [above, below] = [place([x, y - 1])?, place([x, y + 1])?];
    Some([left, right, above, below].map(|at| at as u8))
}

/// Column and row of each module of a square ring: one of the top side, then those that quarter turns make of it, and so on.
fn ring_modules(first: i16, last: i16) -> Vec<[i16; 2]> {
    let corner_to_corner = (first..last).map(|i| (i, first + last - i));
    let four = |(i, back)| [[i, first], [last, i], [back, last], [first, back]];
    corner_to_corner.flat_map(four).collect()
}
