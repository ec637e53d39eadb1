//! WebAssembly's 128-bit vectors, for loops that compilers do not vectorise well.

use super::{Column, MAX_GROUPS, Pixels, ROWS, Sums};
use std::arch::wasm32::*;

/// Numbers in a vector.
const LANES: usize = 8;

fn load<T, const N: usize>(numbers: &[T; N]) -> v128 {
    const { assert!(size_of::<[T; N]>() == 16) };
    // SAFETY: the array is as long as a vector, which need not be aligned.
    unsafe { v128_load(numbers.as_ptr().cast()) }
}

/// Sums of products of neighbours have an instruction of their own, which compilers do not select.
pub(super) fn products(columns: &[Column], n_groups: usize, sums: &mut Sums) {
    let n_groups = n_groups.min(MAX_GROUPS);
    for (i, (column, sums)) in columns.iter().zip(sums).enumerate() {
        for (sum, other) in sums.iter_mut().zip(&columns[..=i]) {
            *sum = dot(&column[..n_groups], &other[..n_groups]);
        }
    }
}

fn dot(a: &[[i16; ROWS]], b: &[[i16; ROWS]]) -> i32 {
    let mut sums = [i32x4_splat(0); ROWS / LANES];
    for (a, b) in a.iter().zip(b) {
        let halves = a
            .as_chunks::<LANES>()
            .0
            .iter()
            .zip(b.as_chunks::<LANES>().0);
        for (sum, (a, b)) in sums.iter_mut().zip(halves) {
            *sum = i32x4_add(*sum, i32x4_dot_i16x8(load(a), load(b)));
        }
    }
    let [first, second] = sums;
    let sum = i32x4_add(first, second);
    [
        i32x4_extract_lane::<0>(sum),
        i32x4_extract_lane::<1>(sum),
        i32x4_extract_lane::<2>(sum),
        i32x4_extract_lane::<3>(sum),
    ]
    .into_iter()
    .fold(0, i32::wrapping_add)
}

/// The top bit of each byte.
#[inline(always)]
pub(super) fn top_bits(bytes: &Pixels) -> u64 {
    let quarters = bytes.as_chunks::<16>().0.iter().rev();
    quarters.fold(0, |bits, quarter| {
        bits << 16 | u64::from(i8x16_bitmask(load(quarter)))
    })
}
