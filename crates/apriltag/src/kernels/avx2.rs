//! The kernels with 256-bit integer vectors.

use super::{
    COLUMNS, Column, Kernels, MAX_GROUPS, Points, ROWS, Sums, TILES_IN_WORD, Vectors, WORD, scalar,
};
use crate::Image;
use crate::homography::Homography;
use std::arch::x86_64::*;

/// Pixels in a vector.
const LANES: usize = 32;

/// These kernels, where the processor has AVX2 and what came with it.
pub(super) fn kernels() -> Option<Kernels> {
    (std::arch::is_x86_feature_detected!("avx2")
        && std::arch::is_x86_feature_detected!("fma")
        && std::arch::is_x86_feature_detected!("bmi1")
        && std::arch::is_x86_feature_detected!("bmi2")
        && std::arch::is_x86_feature_detected!("lzcnt")
        && std::arch::is_x86_feature_detected!("popcnt"))
    .then_some(Kernels {
        threshold: threshold_words,
        sample,
        products,
        vectors: Vectors::Avx2(Detected(())),
    })
}

/// Exists only where AVX2, FMA, BMI, LZCNT and POPCNT were detected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detected(());

impl Detected {
    pub(super) fn run<T>(self, work: impl FnOnce() -> T) -> T {
        // SAFETY: `kernels` makes a `Detected` only where they were detected.
        unsafe { run_avx2(work) }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<T>(work: impl FnOnce() -> T) -> T {
    work()
}

fn threshold_words(row: &[u8], levels: &[u8], words: &mut [u64]) {
    // SAFETY: `kernels` gives this function out only where AVX2 was detected.
    unsafe { threshold_words_avx2(row, levels, words) }
}

fn products(columns: &[Column; COLUMNS], n_groups: usize, sums: &mut Sums) {
    // SAFETY: `kernels` gives this function out only where AVX2 was detected.
    unsafe { products_avx2(columns, n_groups, sums) }
}

/// Columns whose products with another are summed together.
const TOGETHER: usize = 4;

#[target_feature(enable = "avx2")]
fn products_avx2(columns: &[Column; COLUMNS], n_groups: usize, sums: &mut Sums) {
    for (i, column) in columns.iter().enumerate() {
        for first in (0..=i).step_by(TOGETHER) {
            let first = first.min(COLUMNS - TOGETHER);
            let others = std::array::from_fn(|k| &columns[first + k]);
            let products = products_with(column, others, n_groups.min(MAX_GROUPS));
            sums[i][first..first + TOGETHER].copy_from_slice(&products);
        }
    }
}

#[target_feature(enable = "avx2")]
fn products_with(column: &Column, others: [&Column; TOGETHER], n_groups: usize) -> [i32; TOGETHER] {
    // SAFETY: groups are as long as vectors, which need not be aligned.
    let load = |group: &[i16; ROWS]| unsafe { _mm256_loadu_si256(group.as_ptr().cast()) };
    let mut sums = [_mm256_setzero_si256(); TOGETHER];
    let mut add = |group: usize| {
        let numbers = load(&column[group]);
        for (sum, other) in sums.iter_mut().zip(others) {
            *sum = _mm256_add_epi32(*sum, _mm256_madd_epi16(numbers, load(&other[group])));
        }
    };
    // Two at a time, for a loop so short.
    for pair in 0..n_groups / 2 {
        add(2 * pair);
        add(2 * pair + 1);
    }
    if n_groups % 2 == 1 {
        add(n_groups - 1);
    }
    // The four vectors' lanes are added up side by side.
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

fn sample(image: &Image<'_>, map: &Homography, places: &[[Points; 2]], greys: &mut [Points]) {
    let (bytes, stride) = image.bytes();
    if stride + 4 > bytes.len() || i32::try_from(bytes.len()).is_err() {
        return scalar::sample(image, map, places, greys);
    }
    // SAFETY: `kernels` gives this function out only where AVX2 was detected.
    unsafe { sample_avx2(image, map, places, greys) }
}

/// In the order of operations of the scalar one, without fused ones, for the same bits.
#[target_feature(enable = "avx2")]
fn sample_avx2(image: &Image<'_>, map: &Homography, places: &[[Points; 2]], greys: &mut [Points]) {
    let m = map.m.map(|value| _mm256_set1_ps(value));
    let origin = map.origin.map(|value| _mm256_set1_ps(value));
    let one = _mm256_set1_ps(1.0);
    let linear = |[a, b, c]: [__m256; 3], u, v| {
        _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a, u), _mm256_mul_ps(b, v)), c)
    };
    for ([u, v], greys) in places.iter().zip(greys) {
        let (u, v) = (load_floats(u), load_floats(v));
        let w = _mm256_div_ps(one, linear([m[6], m[7], one], u, v));
        let x = _mm256_mul_ps(linear([m[0], m[1], m[2]], u, v), w);
        let y = _mm256_mul_ps(linear([m[3], m[4], m[5]], u, v), w);
        let point = [_mm256_add_ps(origin[0], x), _mm256_add_ps(origin[1], y)];
        store_floats(bilinear(image, point), greys);
    }
}

/// Grey at eight points, NaN outside the image.
#[target_feature(enable = "avx2")]
fn bilinear(image: &Image<'_>, point: [__m256; 2]) -> __m256 {
    let sizes = [image.width(), image.height()];
    let zero = _mm256_setzero_ps();
    let mut inside = _mm256_cmp_ps::<_CMP_EQ_OQ>(zero, zero);
    for (at, size) in point.into_iter().zip(sizes) {
        let last = _mm256_set1_ps((size - 1) as f32);
        inside = _mm256_and_ps(inside, _mm256_cmp_ps::<_CMP_GE_OQ>(at, zero));
        inside = _mm256_and_ps(inside, _mm256_cmp_ps::<_CMP_LE_OQ>(at, last));
    }
    let mut whole = [_mm256_setzero_si256(); 2];
    let mut part = [zero; 2];
    for axis in [0, 1] {
        let at = _mm256_and_ps(point[axis], inside);
        let most = _mm256_set1_epi32(sizes[axis] as i32 - 2);
        whole[axis] = _mm256_min_epi32(_mm256_cvttps_epi32(at), most);
        part[axis] = _mm256_sub_ps(at, _mm256_cvtepi32_ps(whole[axis]));
    }
    let (bytes, stride) = image.bytes();
    let row = _mm256_mullo_epi32(whole[1], _mm256_set1_epi32(stride as i32));
    let at = _mm256_add_epi32(row, whole[0]);
    let [top, bottom] = [bytes, &bytes[stride..]].map(|bytes| {
        let [left, right] = pairs(bytes, at);
        let across = _mm256_mul_ps(part[0], _mm256_sub_ps(right, left));
        _mm256_add_ps(left, across)
    });
    let down = _mm256_mul_ps(part[1], _mm256_sub_ps(bottom, top));
    let outside = _mm256_set1_ps(f32::NAN);
    _mm256_blendv_ps(outside, _mm256_add_ps(top, down), inside)
}

/// The bytes at eight places and those after them, as floats. There must be four bytes and no more than fit an index.
#[target_feature(enable = "avx2")]
fn pairs(bytes: &[u8], at: __m256i) -> [__m256; 2] {
    let last = _mm256_set1_epi32(bytes.len() as i32 - 4);
    let from = _mm256_max_epi32(_mm256_min_epi32(at, last), _mm256_setzero_si256());
    // SAFETY: four bytes are read from places that were limited to 0..=len - 4.
    let words = unsafe { _mm256_i32gather_epi32::<1>(bytes.as_ptr().cast(), from) };
    let beyond = _mm256_slli_epi32::<3>(_mm256_sub_epi32(at, from));
    let words = _mm256_srlv_epi32(words, beyond);
    let byte = _mm256_set1_epi32(0xff);
    let left = _mm256_and_si256(words, byte);
    let right = _mm256_and_si256(_mm256_srli_epi32::<8>(words), byte);
    [_mm256_cvtepi32_ps(left), _mm256_cvtepi32_ps(right)]
}

#[target_feature(enable = "avx2")]
fn store_floats(values: __m256, to: &mut [f32; 8]) {
    // SAFETY: the array holds the eight values that are written; no alignment is asked for.
    unsafe { _mm256_storeu_ps(to.as_mut_ptr(), values) }
}

#[target_feature(enable = "avx2")]
fn load_floats(values: &[f32]) -> __m256 {
    let values = &values[..8];
    // SAFETY: the slice holds the eight values that are read; no alignment is asked for.
    unsafe { _mm256_loadu_ps(values.as_ptr()) }
}

#[target_feature(enable = "avx2")]
fn threshold_words_avx2(row: &[u8], levels: &[u8], words: &mut [u64]) {
    let left_half = _mm256_setr_epi32(
        0,
        0x0101_0101,
        0x0202_0202,
        0x0303_0303,
        0x0404_0404,
        0x0505_0505,
        0x0606_0606,
        0x0707_0707,
    );
    let right_half = _mm256_add_epi8(left_half, _mm256_set1_epi8(8));
    let pixels = row
        .chunks_exact(WORD)
        .zip(levels.chunks_exact(TILES_IN_WORD));
    for ((pixels, levels), word) in pixels.zip(words) {
        let levels = load_twice(levels);
        if _mm256_testz_si256(levels, levels) == 1 {
            *word = 0;
            continue;
        }
        let left = below(load(pixels), _mm256_shuffle_epi8(levels, left_half));
        let right = below(
            load(&pixels[LANES..]),
            _mm256_shuffle_epi8(levels, right_half),
        );
        *word = u64::from(right) << LANES | u64::from(left);
    }
}

/// A bit for each byte of `values` that is below that of `levels`.
#[target_feature(enable = "avx2")]
fn below(values: __m256i, levels: __m256i) -> u32 {
    let not_below = _mm256_cmpeq_epi8(_mm256_max_epu8(values, levels), values);
    !_mm256_movemask_epi8(not_below) as u32
}

#[target_feature(enable = "avx2")]
fn load(bytes: &[u8]) -> __m256i {
    let bytes = &bytes[..LANES];
    // SAFETY: the slice holds the 32 bytes that are read; no alignment is asked for.
    unsafe { _mm256_loadu_si256(bytes.as_ptr().cast()) }
}

/// Sixteen bytes in both halves of the vector.
#[target_feature(enable = "avx2")]
fn load_twice(bytes: &[u8]) -> __m256i {
    let bytes = &bytes[..TILES_IN_WORD];
    // SAFETY: the slice holds the 16 bytes that are read; no alignment is asked for.
    _mm256_broadcastsi128_si256(unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) })
}
