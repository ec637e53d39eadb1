//! What compilers need to be told to make use of AVX2.

use super::{Lanes, POINTS, Pairs, ROWS};
use std::arch::x86_64::*;
use std::mem::transmute;
use std::sync::LazyLock;

/// Whether the processor has AVX2 and what came with it.
pub(super) fn is_there() -> bool {
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    });
    *IS_THERE
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn run<T>(work: impl FnOnce() -> T) -> T {
    work()
}

/// Pairs that begin at some places, and those a row below.
///
/// # Safety
/// The places must be below 2^31 and the pairs a row below among the pixels; a row has four bytes at least.
#[target_feature(enable = "avx2")]
pub(super) unsafe fn pairs(pixels: &[u8], stride: usize, at: &[u32; POINTS]) -> [Pairs; 2] {
    // SAFETY: four bytes from each place are before the end of the pair below, as are those that end with that pair.
    unsafe {
        let at = transmute::<[u32; POINTS], __m256i>(*at);
        let four = |begin| _mm256_i32gather_epi32::<1>(pixels.as_ptr().add(begin).cast(), at);
        let pairs = [four(0), _mm256_srli_epi32::<16>(four(stride - 2))];
        transmute::<[__m256i; 2], [Pairs; 2]>(pairs)
    }
}

/// Adds the products of as many numbers to their sums, by an instruction that compilers do not find.
#[target_feature(enable = "avx2")]
pub(super) fn add_products(sums: Lanes, a: &[i16; ROWS], b: &[i16; ROWS]) -> Lanes {
    // SAFETY: numbers of 16 bits and of 32, as many as vectors hold.
    unsafe {
        let [a, b] = [a, b].map(|numbers| transmute::<[i16; ROWS], __m256i>(*numbers));
        let sums = transmute::<Lanes, __m256i>(sums);
        transmute::<__m256i, Lanes>(_mm256_add_epi32(sums, _mm256_madd_epi16(a, b)))
    }
}
