//! The kernels in plain Rust: the reference for the others, written so that compilers can vectorise them.

use super::{Column, FLOATS, PRODUCTS, Points, TILE, TILES_IN_WORD, WORD};
use crate::Image;
use crate::homography::Homography;

pub(super) fn tile_extrema(rows: [&[u8]; TILE], darkest: &mut [u8], brightest: &mut [u8]) {
    let tiles = rows[0]
        .chunks_exact(TILE)
        .zip(rows[1].chunks_exact(TILE))
        .zip(rows[2].chunks_exact(TILE).zip(rows[3].chunks_exact(TILE)));
    for ((((a, b), (c, d)), dark), bright) in tiles.zip(darkest).zip(brightest) {
        let (mut low, mut high) = ([0; TILE], [0; TILE]);
        for i in 0..TILE {
            low[i] = a[i].min(b[i]).min(c[i]).min(d[i]);
            high[i] = a[i].max(b[i]).max(c[i]).max(d[i]);
        }
        *dark = low[0].min(low[1]).min(low[2].min(low[3]));
        *bright = high[0].max(high[1]).max(high[2].max(high[3]));
    }
}

pub(super) fn threshold_words(row: &[u8], levels: &[u8], words: &mut [u64]) {
    let pixels = row
        .chunks_exact(WORD)
        .zip(levels.chunks_exact(TILES_IN_WORD));
    for ((pixels, levels), word) in pixels.zip(words) {
        *word = threshold_word(pixels, levels);
    }
}

fn threshold_word(pixels: &[u8], levels: &[u8]) -> u64 {
    if levels.iter().all(|&level| level == 0) {
        return 0;
    }
    let tiles = pixels.chunks_exact(TILE).zip(levels).enumerate();
    tiles.fold(0, |word, (i, (tile, &level))| {
        let bits = (0..TILE).fold(0, |bits, k| bits | u64::from(tile[k] < level) << k);
        word | bits << (i * TILE)
    })
}

/// A partial sum for each place in a block, so that compilers can keep them in vectors.
pub(super) fn products(
    blocks: &[Column],
    n: usize,
    [i, j]: [usize; 2],
) -> [[f32; PRODUCTS]; PRODUCTS] {
    let product = |i: usize, j: usize| {
        let mut sums = [0.0; FLOATS];
        for block in blocks.chunks_exact(n) {
            for (sum, (a, b)) in sums.iter_mut().zip(block[i].iter().zip(&block[j])) {
                *sum += a * b;
            }
        }
        sums.iter().sum()
    };
    std::array::from_fn(|a| std::array::from_fn(|b| product(i + a, j + b)))
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
