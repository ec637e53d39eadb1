//! The kernels with 128-bit vectors of 64-bit ARM, which every such processor has.

use super::{Kernels, TILE, TILES_IN_WORD, WORD, scalar};
use std::arch::aarch64::*;

/// Pixels in a vector.
const LANES: usize = 16;

pub(super) const KERNELS: Kernels = Kernels {
    extrema: tile_extrema,
    threshold: threshold_words,
    // The sampling's arithmetic vectorises as it is; there is no instruction for the rest.
    ..Kernels::SCALAR
};

fn tile_extrema(rows: [&[u8]; TILE], darkest: &mut [u8], brightest: &mut [u8]) {
    // SAFETY: this module is compiled only where every processor has NEON.
    unsafe { tile_extrema_neon(rows, darkest, brightest) }
}

fn threshold_words(row: &[u8], levels: &[u8], words: &mut [u64]) {
    // SAFETY: this module is compiled only where every processor has NEON.
    unsafe { threshold_words_neon(row, levels, words) }
}

#[target_feature(enable = "neon")]
fn tile_extrema_neon(rows: [&[u8]; TILE], darkest: &mut [u8], brightest: &mut [u8]) {
    let n_words = rows[0].len() / WORD;
    for i in 0..n_words {
        let columns = |k: usize| rows.map(|row| load(&row[i * WORD + k * LANES..]));
        let low = std::array::from_fn(|k| {
            let [a, b, c, d] = columns(k);
            vminq_u8(vminq_u8(a, b), vminq_u8(c, d))
        });
        let high = std::array::from_fn(|k| {
            let [a, b, c, d] = columns(k);
            vmaxq_u8(vmaxq_u8(a, b), vmaxq_u8(c, d))
        });
        let tiles = i * TILES_IN_WORD;
        store(by_fours(low, |a, b| vpminq_u8(a, b)), &mut darkest[tiles..]);
        store(
            by_fours(high, |a, b| vpmaxq_u8(a, b)),
            &mut brightest[tiles..],
        );
    }
    let rest = rows.map(|row| &row[n_words * WORD..]);
    let tiles = n_words * TILES_IN_WORD;
    scalar::tile_extrema(rest, &mut darkest[tiles..], &mut brightest[tiles..]);
}

/// Each four neighbours made one.
#[inline(always)]
fn by_fours(
    [a, b, c, d]: [uint8x16_t; 4],
    pairs: impl Fn(uint8x16_t, uint8x16_t) -> uint8x16_t,
) -> uint8x16_t {
    pairs(pairs(a, b), pairs(c, d))
}

#[target_feature(enable = "neon")]
fn threshold_words_neon(row: &[u8], levels: &[u8], words: &mut [u64]) {
    /// Places of the tiles of the first sixteen pixels.
    const TILE_OF_PIXEL: [u8; LANES] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];
    const BIT_OF_PIXEL: [u8; LANES] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];
    let (first, bits) = (load(&TILE_OF_PIXEL), load(&BIT_OF_PIXEL));
    let pixels = row
        .chunks_exact(WORD)
        .zip(levels.chunks_exact(TILES_IN_WORD));
    for ((pixels, levels), word) in pixels.zip(words) {
        let levels = load(levels);
        if vmaxvq_u8(levels) == 0 {
            *word = 0;
            continue;
        }
        let below = std::array::from_fn(|k| {
            let tiles = vaddq_u8(first, vdupq_n_u8((k * LANES / TILE) as u8));
            let levels = vqtbl1q_u8(levels, tiles);
            vandq_u8(vcltq_u8(load(&pixels[k * LANES..]), levels), bits)
        });
        let halves = by_fours(below, |a, b| vpaddq_u8(a, b));
        *word = vgetq_lane_u64::<0>(vreinterpretq_u64_u8(vpaddq_u8(halves, halves)));
    }
}

#[target_feature(enable = "neon")]
fn load(bytes: &[u8]) -> uint8x16_t {
    let bytes = &bytes[..LANES];
    // SAFETY: the slice holds the 16 bytes that are read; no alignment is asked for.
    unsafe { vld1q_u8(bytes.as_ptr()) }
}

#[target_feature(enable = "neon")]
fn store(vector: uint8x16_t, bytes: &mut [u8]) {
    let bytes = &mut bytes[..LANES];
    // SAFETY: the slice holds the 16 bytes that are written; no alignment is asked for.
    unsafe { vst1q_u8(bytes.as_mut_ptr(), vector) }
}
