//! Arithmetic on many pixels at once: loops that compilers turn into vector instructions.

use crate::kernels::FLOATS;

/// Pixels that are worked on together: a few vectors of any instruction set.
pub(super) const LANES: usize = FLOATS;

/// A value for each of them.
pub(super) type Lanes = [f32; LANES];

/// Pixels beside each other whose residuals are looked at together.
pub(super) const GROUP: usize = 16;

/// Such groups in a block.
pub(super) const GROUPS: usize = LANES / GROUP;

/// Where the next pixel goes, given how many came before: those of a group lie a whole number of groups apart, so that
/// sums over groups are sums of vectors.
pub(super) fn lane(n: usize) -> usize {
    n % GROUP * GROUPS + n / GROUP % GROUPS
}

/// Several results for each pixel.
#[inline(always)]
pub(super) fn map<const N: usize>(result: impl Fn(usize) -> [f32; N]) -> [Lanes; N] {
    let mut results = [[0.0; LANES]; N];
    map_into(&mut results, result);
    results
}

/// The same, without a copy.
#[inline(always)]
pub(super) fn map_into<const N: usize>(
    results: &mut [Lanes; N],
    result: impl Fn(usize) -> [f32; N],
) {
    for i in 0..LANES {
        let values = result(i);
        for k in 0..N {
            results[k][i] = values[k];
        }
    }
}

/// The whole number nearest to a value from 0 to 2^22, without a branch: adding 1.5 * 2^23 leaves it in the lowest bits.
#[inline(always)]
pub(super) fn nearest(value: f32) -> u32 {
    const SHIFT: f32 = 12_582_912.0;
    (value + SHIFT).to_bits() & 0x3f_ffff
}
