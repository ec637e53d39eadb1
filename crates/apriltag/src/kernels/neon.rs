//! The kernels with 128-bit vectors of 64-bit ARM, which every such processor has.

use super::{Kernels, TILE, TILES_IN_WORD, WORD};
use std::arch::aarch64::*;

/// Pixels in a vector.
const LANES: usize = 16;

pub(super) const KERNELS: Kernels = Kernels {
    threshold: threshold_words,
    // The sampling's arithmetic vectorises as it is; there is no instruction for the rest.
    ..Kernels::SCALAR
};

fn threshold_words(row: &[u8], levels: &[u8], words: &mut [u64]) {
    // SAFETY: this module is compiled only where every processor has NEON.
    unsafe { threshold_words_neon(row, levels, words) }
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
        let [a, b, c, d] = std::array::from_fn(|k| {
            let tiles = vaddq_u8(first, vdupq_n_u8((k * LANES / TILE) as u8));
            let levels = vqtbl1q_u8(levels, tiles);
            vandq_u8(vcltq_u8(load(&pixels[k * LANES..]), levels), bits)
        });
        let pairs = vpaddq_u8(vpaddq_u8(a, b), vpaddq_u8(c, d));
        *word = vgetq_lane_u64::<0>(vreinterpretq_u64_u8(vpaddq_u8(pairs, pairs)));
    }
}

#[target_feature(enable = "neon")]
fn load(bytes: &[u8]) -> uint8x16_t {
    let bytes = &bytes[..LANES];
    // SAFETY: the slice holds the 16 bytes that are read; no alignment is asked for.
    unsafe { vld1q_u8(bytes.as_ptr()) }
}
