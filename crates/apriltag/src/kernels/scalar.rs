//! The kernels in plain Rust: the reference for the others, written so that compilers can vectorise them.

use super::{COLUMNS, Column, Points, ROWS, Sums, TILE, TILES_IN_WORD, WORD};
use crate::Image;
use crate::homography::Homography;

pub(super) fn products(columns: &[Column; COLUMNS], n_groups: usize, sums: &mut Sums) {
    for (i, column) in columns.iter().enumerate() {
        for (sum, other) in sums[i].iter_mut().zip(&columns[..=i]) {
            *sum = product(&column[..n_groups], other);
        }
    }
}

#[inline(always)]
fn product(column: &[[i16; ROWS]], other: &Column) -> i32 {
    /// In a vector, or two.
    const LANES: usize = 8;
    let mut sums = [0_i32; LANES];
    for (a, b) in column.iter().zip(other) {
        for i in 0..ROWS {
            let product = i32::from(a[i]) * i32::from(b[i]);
            sums[i % LANES] = sums[i % LANES].wrapping_add(product);
        }
    }
    sums.into_iter().fold(0, i32::wrapping_add)
}

/// Words that are worked on together: few, since most of an image is dead and passed by.
const BLOCK: usize = 2;

pub(super) fn threshold_words(row: &[u8], levels: &[u8], words: &mut [u64]) {
    let pixels = row.chunks(BLOCK * WORD);
    let levels = levels.chunks(BLOCK * TILES_IN_WORD);
    for ((pixels, levels), words) in pixels.zip(levels).zip(words.chunks_mut(BLOCK)) {
        let fours = levels.as_chunks::<4>().0.iter();
        if fours.fold(0, |any, four| any | u32::from_ne_bytes(*four)) == 0 {
            words.fill(0);
        } else {
            threshold_block(pixels, levels, words);
        }
    }
}

/// In steps that compilers can each keep in vectors, those of 32-bit ARM too: levels widened to tiles, pixels compared, the
/// four bits of each tile gathered; then tiles put beside each other.
#[inline(never)]
fn threshold_block(pixels: &[u8], levels: &[u8], words: &mut [u64]) {
    /// A byte for each pixel of a tile.
    const EACH_PIXEL: u32 = 0x0101_0101;
    const BIT_OF_PIXEL: u32 = u32::from_ne_bytes([1, 2, 4, 8]);
    let mut wide = [[0; TILE]; BLOCK * TILES_IN_WORD];
    for (wide, &level) in wide.iter_mut().zip(levels) {
        *wide = (u32::from(level) * EACH_PIXEL).to_ne_bytes();
    }
    let mut below = [[0; TILE]; BLOCK * TILES_IN_WORD];
    let compared = pixels.iter().zip(wide.as_flattened());
    for (below, (&pixel, &level)) in below.as_flattened_mut().iter_mut().zip(compared) {
        *below = if pixel < level { u8::MAX } else { 0 };
    }
    let mut bits = [0_u8; BLOCK * TILES_IN_WORD];
    for (bits, &below) in bits.iter_mut().zip(&below) {
        let tile = u32::from_ne_bytes(below) & BIT_OF_PIXEL;
        let pairs = tile | tile >> 16;
        *bits = (pairs | pairs >> 8) as u8 & 0xf;
    }
    for (word, bits) in words.iter_mut().zip(bits.as_chunks::<TILES_IN_WORD>().0) {
        let half = |tiles: &[u8]| {
            let tiles = tiles.iter().rev();
            tiles.fold(0, |half, &bits| half << TILE | u32::from(bits))
        };
        let (left, right) = bits.split_at(TILES_IN_WORD / 2);
        *word = u64::from(half(right)) << 32 | u64::from(half(left));
    }
}

pub(super) fn sample(
    image: &Image<'_>,
    map: &Homography,
    places: &[[Points; 2]],
    greys: &mut [Points],
) {
    for ([u, v], greys) in places.iter().zip(greys) {
        for (grey, (&u, &v)) in greys.iter_mut().zip(u.iter().zip(v)) {
            *grey = image.sample(map.apply(u, v));
        }
    }
}
