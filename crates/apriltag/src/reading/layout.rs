//! The modules of a family that are looked at: border, ring around it, bits.

use crate::homography::{POINTS, Points};
use sextant_tag_families::{Board, FamilyData};
use std::ops::Range;

/// Most modules that are looked at: as many as a byte counts.
pub(super) const MAX_MODULES: usize = 256;

#[derive(Debug)]
pub(super) struct Layout {
    /// Middles of the modules on the square -1..1 of the border. Border and ring fill whole blocks, and so do the bits; what
    /// pads them counts for nothing.
    pub(super) places: Vec<[Points; 2]>,
    /// The bits once more, at four places around each middle.
    pub(super) around: [Vec<[Points; 2]>; 4],
    /// The outermost modules of the border.
    pub(super) border: Ring,
    /// Those around the border.
    pub(super) ring: Ring,
    /// All of the border that is looked at.
    pub(super) whole_border: Range<usize>,
    pub(super) bits: Range<usize>,
    /// Places that tell how far the bits reach.
    pub(super) rim: Rim,
    /// Of each bit the modules to the left and right, above and below; itself where one is missing.
    pub(super) beside: Vec<[u8; 4]>,
}

/// A square ring of modules in quarter turns of one side: those that it has, and where on the square -1..1 its top side begins, from
/// the middle of its first module to the right and down.
#[derive(Debug)]
pub(super) struct Ring {
    pub(super) modules: Range<usize>,
    pub(super) begins: [f32; 2],
    /// Width of a module.
    pub(super) step: f32,
}

/// Where the bits end and the border begins. Of tags with borders of one module and of two that are equally large the outermost bits
/// overlap, so that either show code words of the other now and then; how far white reaches tells them apart.
#[derive(Debug)]
pub(super) struct Rim {
    /// Outermost bits, once for each side on which the border lies.
    pub(super) bits: Vec<[RimBit; POINTS]>,
    /// Two sample points for each bit: its middle under the other border width, and a point halfway between its outer ends under both.
    pub(super) places: [Vec<[Points; 2]>; 2],
    pub(super) shows_white: bool,
}

/// A bit among all: its place in the order of the layout, and in the code word.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimBit {
    pub(super) place: usize,
    pub(super) significance: u32,
}

impl Layout {
    pub(super) fn new(data: &FamilyData) -> Self {
        let width = i16::from(data.border_width);
        let thickness = thickness(data);
        let mut modules = ring_modules(0, width - 1);
        let border = Ring::new(0..modules.len(), [0, 0], width);
        if thickness > 1 {
            modules.extend(ring_modules(1, width - 2));
        }
        let whole_border = 0..modules.len();
        let first = -1 + i16::from(data.board == Some(Board::Aprilgrid));
        modules.extend(ring_modules(-1, width).split_off(4 * (first + 1) as usize));
        let ring = Ring::new(whole_border.end..modules.len(), [first, -1], width);
        modules.resize(ring.modules.end.next_multiple_of(POINTS), [0, 0]);
        let bits = modules.len()..modules.len() + data.bits.len();
        modules.extend(data.bits.iter().map(|&(x, y)| [i16::from(x), i16::from(y)]));
        let around = [[-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]];
        Self {
            rim: Rim::new(&modules[bits.clone()], width, thickness),
            places: blocks(&modules, [0.0; 2], width),
            around: around.map(|aside| blocks(&modules[bits.clone()], aside, width)),
            beside: bits
                .clone()
                .map(|i| beside(modules[i], &modules).unwrap_or([i as u8; 4]))
                .collect(),
            border,
            ring,
            whole_border,
            bits,
        }
    }

    /// Blocks of border and ring.
    pub(super) fn ring_blocks(&self) -> usize {
        self.bits.start / POINTS
    }
}

impl Ring {
    /// The top side's first module, of so many along the border.
    fn new(modules: Range<usize>, first: [i16; 2], width: i16) -> Self {
        Self {
            modules,
            begins: first.map(|first| middle_of(first, width)),
            step: 2.0 / f32::from(width),
        }
    }
}

impl Rim {
    /// Bits that a rim has at most: seven on each of four sides, in whole blocks.
    pub(super) const MOST: usize = 4 * POINTS;

    fn new(bits: &[[i16; 2]], width: i16, thickness: i16) -> Self {
        // In modules from the middle, for a square of eight modules with a border of one and of ten with a border of two.
        let away = match thickness {
            1 => [-0.5, 0.2],
            _ => [0.625, 0.875],
        };
        let sides = [[-1, 0], [1, 0], [0, -1], [0, 1]];
        let is_outermost = |module: [i16; 2], side: [i16; 2]| {
            let beyond = [0, 1].map(|axis| module[axis] + side[axis]);
            let ends = [thickness - 1, width - thickness];
            [0, 1]
                .iter()
                .any(|&axis| side[axis] != 0 && ends.contains(&beyond[axis]))
        };
        let outermost = bits.iter().enumerate().flat_map(|(place, &module)| {
            let here = sides
                .into_iter()
                .filter(move |&side| is_outermost(module, side));
            let significance = (bits.len() - 1 - place) as u32;
            here.map(move |side| {
                (
                    RimBit {
                        place,
                        significance,
                    },
                    module,
                    side,
                )
            })
        });
        let outermost: Vec<_> = outermost.collect();
        let places = away.map(|away| {
            let places = outermost.iter().map(|(_, module, side)| {
                let aside = side.map(|side| 2.0 * away * f32::from(side) / f32::from(width));
                [0, 1].map(|axis| middle_of(module[axis], width) + aside[axis])
            });
            in_blocks(&places.collect::<Vec<_>>())
        });
        let bits_of = |block: &[(RimBit, [i16; 2], [i16; 2])]| {
            let none = RimBit {
                place: 0,
                significance: u64::BITS - 1,
            };
            std::array::from_fn(|i| block.get(i).map_or(none, |(bit, ..)| *bit))
        };
        Self {
            bits: outermost.chunks(POINTS).map(bits_of).collect(),
            places,
            shows_white: thickness == 1,
        }
    }
}

/// Modules between the border's edge and the bits within it.
fn thickness(data: &FamilyData) -> i16 {
    let within = |x: i8| x > 0 && x < data.border_width as i8 - 1;
    let bits = data.bits.iter().filter(|(x, y)| within(*x) && within(*y));
    i16::from(bits.map(|(x, y)| *x.min(y)).min().unwrap_or(1))
}

/// The middle of a column or row of modules on the square -1..1.
fn middle_of(module: i16, width: i16) -> f32 {
    f32::from(2 * module + 1 - width) / f32::from(width)
}

/// The middles of modules, of so many along the border, moved aside.
fn blocks(modules: &[[i16; 2]], aside: [f32; 2], width: i16) -> Vec<[Points; 2]> {
    let place = |module: &[i16; 2]| {
        [0, 1].map(|axis| middle_of(module[axis], width) + 2.0 * aside[axis] / f32::from(width))
    };
    in_blocks(&modules.iter().map(place).collect::<Vec<_>>())
}

/// Places side by side; what pads the last block is its first one again.
fn in_blocks(places: &[[f32; 2]]) -> Vec<[Points; 2]> {
    let block = |block: &[[f32; 2]]| {
        let place = |i: usize| block.get(i).unwrap_or(&block[0]);
        [0, 1].map(|axis| std::array::from_fn(|i| place(i)[axis]))
    };
    places.chunks(POINTS).map(block).collect()
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
