//! Arithmetic on many pixels at once: loops that compilers turn into vector instructions.

/// Groups of pixels that are worked on together, a pixel of each at a time: a few vectors of any instruction set.
pub(super) const LANES: usize = 16;

/// Lanes that fit in one vector of the widest kind.
pub(super) const VECTOR: usize = 8;

/// A value for each lane.
pub(super) type Lanes = [f32; LANES];

/// Several results for each lane.
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

/// Adds the products of two columns, lane by lane.
#[inline(always)]
pub(super) fn add_products(sums: &mut Lanes, a: &Lanes, b: &Lanes) {
    for i in 0..LANES {
        sums[i] += a[i] * b[i];
    }
}

/// Of all lanes.
#[inline(always)]
pub(super) fn sum(values: &Lanes) -> f32 {
    let mut values = *values;
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            values[i] += values[i + half];
        }
        half /= 2;
    }
    values[0]
}

/// The whole number nearest to a value from 0 to 2^22, without a branch: adding 1.5 * 2^23 leaves it in the lowest bits.
#[inline(always)]
pub(super) fn nearest(value: f32) -> u32 {
    const SHIFT: f32 = 12_582_912.0;
    (value + SHIFT).to_bits() & 0x3f_ffff
}
