//! AVX2 intrinsics for loops that compilers do not vectorise well.

use super::{Column, MAX_GROUPS, Pairs, ROWS, Sums};
use crate::homography::POINTS;
use std::arch::x86_64::*;
use std::mem::transmute;
use std::sync::LazyLock;

/// Whether the processor has AVX2 and the extensions that accompany it.
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

/// Pairs of neighbours at some positions, and those a row below.
///
/// # Safety
/// The positions must be below 2^31 and the pairs a row below within the pixels; a row has at least four bytes.
#[target_feature(enable = "avx2")]
pub(super) unsafe fn pairs(pixels: &[u8], stride: usize, at: &[u32; POINTS]) -> [Pairs; 2] {
    // SAFETY: four bytes from each position are before the end of the pair below, as are those that end with that pair.
    unsafe {
        let at = transmute::<[u32; POINTS], __m256i>(*at);
        let four = |begin| _mm256_i32gather_epi32::<1>(pixels.as_ptr().add(begin).cast(), at);
        let pairs = [four(0), _mm256_srli_epi32::<16>(four(stride - 2))];
        transmute::<[__m256i; 2], [Pairs; 2]>(pairs)
    }
}

/// Columns whose products with another are summed together; fewer at the diagonal.
const TOGETHER: usize = 4;

/// Sums of products of neighbours have an instruction of their own, which compilers do not select.
#[target_feature(enable = "avx2")]
pub(super) fn products(columns: &[Column], n_groups: usize, sums: &mut Sums) {
    for (i, (column, sums)) in columns.iter().zip(sums).enumerate() {
        let sums = sums.as_chunks_mut().0;
        for (others, sums) in columns[..=i].chunks(TOGETHER).zip(sums) {
            *sums = match others {
                [a] => products_with(column, [a], n_groups),
                [a, b] => products_with(column, [a, b], n_groups),
                [a, b, c] => products_with(column, [a, b, c], n_groups),
                [a, b, c, d, ..] => products_with(column, [a, b, c, d], n_groups),
                [] => continue,
            };
        }
    }
}

#[target_feature(enable = "avx2")]
fn products_with<const N: usize>(
    column: &Column,
    others: [&Column; N],
    n_groups: usize,
) -> [i32; TOGETHER] {
    // SAFETY: groups are as long as vectors, which need not be aligned.
    let load = |group: &[i16; ROWS]| unsafe { _mm256_loadu_si256(group.as_ptr().cast()) };
    let mut sums = [_mm256_setzero_si256(); TOGETHER];
    let mut add = |group: usize| {
        let numbers = load(&column[group]);
        for (sum, other) in sums.iter_mut().zip(others) {
            *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(numbers, load(&other[group])));
        }
    };
    // Several at a time, for a loop so short.
    const AT_A_TIME: usize = 4;
    let n_groups = n_groups.min(MAX_GROUPS);
    let many = n_groups / AT_A_TIME * AT_A_TIME;
    for first in (0..many).step_by(AT_A_TIME) {
        (first..first + AT_A_TIME).for_each(&mut add);
    }
    (many..n_groups).for_each(&mut add);
    // Adds the lanes of the four vectors in parallel.
    let pairs = _mm256_hadd_epi32(
        _mm256_hadd_epi32(sums[0], sums[1]),
        _mm256_hadd_epi32(sums[2], sums[3]),
    );
    let halves = (
        _mm256_castsi256_si128(pairs),
        _mm256_extracti128_si256::<1>(pairs),
    );
    let sums = _mm_add_epi32(halves.0, halves.1);
    let mut products = [0_i32; TOGETHER];
    // SAFETY: there is room for four numbers, which need not be aligned.
    unsafe { _mm_storeu_si128(products.as_mut_ptr().cast(), sums) };
    products
}
