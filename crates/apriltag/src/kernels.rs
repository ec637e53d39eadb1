//! The hot loops, each once, in plain Rust that the compiler vectorises.
//!
//! On x86-64 they are compiled twice: for the baseline and for AVX2; both give the same bytes. Only this module selects
//! which one runs. On 32-bit and 64-bit ARM and for WebAssembly the target determines the vector instructions.

use crate::Image;
use crate::homography::{Homography, POINTS, Points};
use std::array;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod simd128;

/// Edge of a tile in pixels. Four is the largest for which the nine tiles around a pixel span no more than a small
/// tag (11 px), so that its black border and its white ring are always among them.
pub(crate) const TILE: usize = 4;

/// Pixels in a word of the bit plane.
pub(crate) const WORD: usize = 64;

/// Tiles in a word of the bit plane.
pub(crate) const TILES_IN_WORD: usize = WORD / TILE;

/// Largest distance from a pixel of a dark line to the end of the line, in pixels.
pub(crate) const LINE_REACH: usize = 3;

/// Width of a line's neighbourhood: a pixel and its reach on both sides.
pub(crate) const LINE_SPAN: usize = 2 * LINE_REACH + 1;

/// Rows per group of a column, and the most groups of a column.
pub(crate) const ROWS: usize = 16;
pub(crate) const MAX_GROUPS: usize = 80;

/// Columns whose products are summed.
pub(crate) const COLUMNS: usize = 19;

pub(crate) type Column = [[i16; ROWS]; MAX_GROUPS];

/// Entries in a row of the sums, padded to whole vectors.
pub(crate) const WIDTH: usize = 24;

/// Sums of the products of each column with itself and the ones before it; entries above the diagonal are unused.
pub(crate) type Sums = [[i32; WIDTH]; COLUMNS];

/// Runs `work`, which must be inlined, compiled for the best vector instructions of the processor.
#[inline(always)]
pub(crate) fn vectorised<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_there() {
        // SAFETY: the processor has AVX2 and what came with it.
        return unsafe { avx2::run(work) };
    }
    work()
}

/// [`vectorised`] for an expression, which is inlined.
macro_rules! vectorise {
    ($work:expr) => {
        $crate::kernels::vectorised(
            #[inline(always)]
            || $work,
        )
    };
}
pub(crate) use vectorise;

/// A row padded by the reach of a line on both sides, never with the colour of a border outside the image. Its pixels
/// begin after the padding.
pub(crate) type PaddedRow = [u8];

/// Length of a padded row, for whole words and the reach of a line beyond them.
pub(crate) const fn padded_length(width: usize) -> usize {
    width.next_multiple_of(WORD) + WORD
}

/// A value for each tile of a word.
pub(crate) type TilesOfWord = [u8; TILES_IN_WORD];

/// Thresholds between black and white in the tiles of a word; 0 where nothing exceeds the noise.
#[derive(Clone, Debug, Default)]
pub(crate) struct Levels {
    pub(crate) low: TilesOfWord,
    pub(crate) middle: TilesOfWord,
    /// Least contrast of a dark line with both of its sides.
    pub(crate) depth: TilesOfWord,
}

/// The pixel rows of a row of tiles, padded by the reach of a line above and below.
pub(crate) type PaddedRows<'a> = [&'a PaddedRow; TILE + 2 * LINE_REACH];

/// The same for the pixels of a word, which begin after the padding.
pub(crate) type WordRows<'a> = [&'a [u8; LINE_SPAN - 1 + WORD]; TILE + 2 * LINE_REACH];

/// Sets the words of a row of tiles, pixel row by pixel row, one bit per pixel with the least significant bit leftmost.
/// `levels` are those of the words from `first` on. `is_set` computes the bits of a word from its rows, which begin the
/// reach of a line before it, a pixel row, and the low levels, middle levels and line depths of its pixels.
#[inline(always)]
pub(crate) fn threshold(
    rows: &PaddedRows<'_>,
    levels: &[Levels],
    first: usize,
    words: &mut [u64],
    is_set: impl Fn(&WordRows<'_>, usize, &[Pixels; 3]) -> Pixels,
) {
    let words_in_row = words.len() / TILE;
    let length = rows.iter().map(|row| row.len()).min().unwrap_or(0);
    for (word, levels) in (first..).zip(levels) {
        let x = word * WORD;
        assert!(x + LINE_SPAN - 1 + WORD <= length);
        // SAFETY: rows are that long, at least. Checking each of them for each word takes a third of the time.
        let rows = rows.map(|row| unsafe { &*row.as_ptr().add(x).cast() });
        let levels = [
            for_each_pixel(&levels.low),
            for_each_pixel(&levels.middle),
            for_each_pixel(&levels.depth),
        ];
        for y in 0..TILE {
            words[y * words_in_row + word] = top_bits(&is_set(&rows, y, &levels));
        }
    }
}

/// The pixels of a word from a position on.
#[inline(always)]
fn pixels<'a>(rows: &WordRows<'a>, [x, y]: [usize; 2]) -> &'a Pixels {
    &rows[y][x..].as_chunks().0[0]
}

/// Whether pixels are on one side of the middle level, where there is one.
#[inline(always)]
pub(crate) fn is_beyond<const DARK: bool>(
    rows: &WordRows<'_>,
    y: usize,
    [_, middle, _]: &[Pixels; 3],
) -> Pixels {
    let pixels = pixels(rows, [LINE_REACH, y + LINE_REACH]);
    array::from_fn(|i| all_or_nothing((middle[i] > 0) & ((pixels[i] < middle[i]) == DARK)))
}

/// Whether pixels are below the low level, or below the middle level and part of a dark line: darker by its depth than
/// pixels within reach on both sides, left and right or above and below.
#[inline(always)]
pub(crate) fn is_black_or_line(
    rows: &WordRows<'_>,
    y: usize,
    [low, middle, depths]: &[Pixels; 3],
) -> Pixels {
    let across = nearer_side(|i| pixels(rows, [i, y + LINE_REACH]));
    let down = nearer_side(|i| pixels(rows, [LINE_REACH, y + i]));
    let pixels = pixels(rows, [LINE_REACH, y + LINE_REACH]);
    let mut black = [0; WORD];
    for i in 0..WORD {
        let depth = across[i].max(down[i]).saturating_sub(pixels[i]);
        let line = all_or_nothing(pixels[i] < middle[i]) & all_or_nothing(depth >= depths[i]);
        black[i] = line | all_or_nothing(pixels[i] < low[i]);
    }
    black
}

/// A value for each pixel of a word.
pub(crate) type Pixels = [u8; WORD];

/// Repeats the value of each tile for its pixels.
#[inline(always)]
fn for_each_pixel(tiles: &TilesOfWord) -> Pixels {
    /// A byte for each pixel of a tile.
    const EACH_PIXEL: u32 = 0x0101_0101;
    let mut wide = [0; WORD];
    for (wide, &tile) in wide.as_chunks_mut::<TILE>().0.iter_mut().zip(tiles) {
        *wide = (u32::from(tile) * EACH_PIXEL).to_ne_bytes();
    }
    wide
}

#[inline(always)]
fn all_or_nothing(is_set: bool) -> u8 {
    if is_set { u8::MAX } else { 0 }
}

/// The darker one of the brightest pixels on both sides.
#[inline(always)]
fn nearer_side<'a>(pixels: impl Fn(usize) -> &'a Pixels) -> Pixels {
    let [a, b, c, _, d, e, f]: [_; LINE_SPAN] = array::from_fn(pixels);
    let mut sides = [0; WORD];
    for i in 0..WORD {
        sides[i] = a[i].max(b[i]).max(c[i]).min(d[i].max(e[i]).max(f[i]));
    }
    sides
}

/// The top bit of each byte; the bytes are 0 or 255.
#[inline(always)]
#[cfg(target_arch = "x86_64")]
fn top_bits(bytes: &Pixels) -> u64 {
    use std::arch::x86_64::{_mm_loadu_si128, _mm_movemask_epi8};
    let quarters = bytes.as_chunks::<16>().0.iter().rev();
    quarters.fold(0, |bits, quarter| {
        // SAFETY: every such processor has SSE2; the quarter holds the 16 bytes that are read, which need not be
        // aligned.
        let here = unsafe { _mm_movemask_epi8(_mm_loadu_si128(quarter.as_ptr().cast())) };
        bits << 16 | u64::from(here as u16)
    })
}

#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use simd128::top_bits;

/// The top bit of each byte; the bytes are 0 or 255. Gathers the bits of each tile in vectors, then joins the tiles.
#[inline(always)]
#[cfg(not(any(
    target_arch = "x86_64",
    all(target_arch = "wasm32", target_feature = "simd128")
)))]
fn top_bits(bytes: &Pixels) -> u64 {
    const BIT_OF_PIXEL: u32 = u32::from_ne_bytes([1, 2, 4, 8]);
    let tiles: [u8; TILES_IN_WORD] = array::from_fn(|i| {
        let tile = u32::from_ne_bytes(bytes.as_chunks::<TILE>().0[i]) & BIT_OF_PIXEL;
        let pairs = tile | tile >> 16;
        (pairs | pairs >> 8) as u8 & 0xf
    });
    let tiles = tiles.iter().rev();
    tiles.fold(0, |word, &bits| word << TILE | u64::from(bits))
}

/// Grey values by bilinear interpolation at mapped points (u, v); NaN outside the image.
pub(crate) fn sample(
    image: &Image<'_>,
    map: &Homography,
    places: &[[Points; 2]],
    greys: &mut [f32],
) {
    let points = places.iter().map(|places| map.apply_to_points(places));
    let points = points.zip(greys.as_chunks_mut().0);
    #[cfg(target_arch = "x86_64")]
    if avx2::is_there() && i32::try_from(image.bytes().0.len()).is_ok() {
        // SAFETY: the processor has AVX2, the pairs are within the image, and that has fewer bytes than 2^31.
        let pairs = |pixels: &_, stride, at: &_| unsafe { avx2::pairs(pixels, stride, at) };
        let work = || points.for_each(|(at, grey)| *grey = bilinear(image, at, pairs));
        // SAFETY: the processor has AVX2 and what came with it.
        return unsafe { avx2::run(work) };
    }
    // SAFETY: the pairs are within the image.
    let pairs = |pixels: &_, stride, at: &_| unsafe { pairs(pixels, stride, at) };
    points.for_each(|(at, grey)| *grey = bilinear(image, at, pairs));
}

#[inline(always)]
fn bilinear(
    image: &Image<'_>,
    [x, y]: [Points; 2],
    pairs: impl Fn(&[u8], usize, &[u32; POINTS]) -> [Pairs; 2],
) -> Points {
    let (column, right) = split(&x, image.width());
    let (row, down) = split(&y, image.height());
    let (pixels, stride) = image.bytes();
    let last = pixels.len() - stride - 2;
    let at: [u32; POINTS] = array::from_fn(|i| {
        row[i]
            .wrapping_mul(stride as u32)
            .wrapping_add(column[i])
            .min(last as u32)
    });
    let [above, below] = pairs(pixels, stride, &at);
    let (above, below) = (interpolate(&above, &right), interpolate(&below, &right));
    let [width, height] = [image.width(), image.height()].map(|size| (size - 1) as f32);
    array::from_fn(|i| {
        let inside = (x[i] >= 0.0) & (x[i] <= width) & (y[i] >= 0.0) & (y[i] <= height);
        let grey = above[i] + down[i] * (below[i] - above[i]);
        if inside { grey } else { f32::NAN }
    })
}

/// Two horizontal neighbours per point, the left one in the lowest byte; the other bytes are ignored.
type Pairs = [u32; POINTS];

/// Pairs that begin at some places, and those a row below.
///
/// # Safety
/// The pairs a row below must be among the pixels.
#[inline(always)]
unsafe fn pairs(pixels: &[u8], stride: usize, at: &[u32; POINTS]) -> [Pairs; 2] {
    let pair = |begin| {
        // SAFETY: both bytes are among the pixels, by the caller's word.
        let pair = unsafe { pixels.as_ptr().add(begin).cast::<[u8; 2]>().read() };
        u32::from(u16::from_le_bytes(pair))
    };
    [0, stride].map(|below| at.map(|at| pair(at as usize + below)))
}

/// Grey between the two pixels of each pair.
#[inline(always)]
fn interpolate(pairs: &Pairs, part: &Points) -> Points {
    array::from_fn(|i| {
        let (left, right) = (pairs[i] as u8, (pairs[i] >> 8) as u8);
        let (left, right) = (f32::from(left), f32::from(right));
        left + part[i] * (right - left)
    })
}

/// Splits coordinates into the pixel before, which has a next one in the image, and the fraction beyond it.
#[inline(always)]
fn split(at: &Points, size: usize) -> ([u32; POINTS], Points) {
    let at = at.map(|at| at.max(0.0).min((size - 1) as f32));
    let whole: [i32; POINTS] = array::from_fn(|i| {
        // SAFETY: from 0 to the size of an image, NaN made 0. A checked conversion keeps compilers from making vectors.
        let whole: i32 = unsafe { at[i].to_int_unchecked() };
        whole.min(size as i32 - 2)
    });
    let part = array::from_fn(|i| at[i] - whole[i] as f32);
    (whole.map(|at| at as u32), part)
}

/// Sums of products of the first so many groups of the columns, wrapping.
pub(crate) fn products(columns: &[Column], n_groups: usize, sums: &mut Sums) {
    #[cfg(target_arch = "x86_64")]
    if avx2::is_there() {
        // SAFETY: the processor has AVX2 and what came with it.
        return unsafe { avx2::products(columns, n_groups, sums) };
    }
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return simd128::products(columns, n_groups, sums);
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    plain_products(columns, n_groups, sums);
}

#[cfg(any(test, not(all(target_arch = "wasm32", target_feature = "simd128"))))]
fn plain_products(columns: &[Column], n_groups: usize, sums: &mut Sums) {
    for (i, column) in columns.iter().enumerate() {
        for (sum, other) in sums[i].iter_mut().zip(&columns[..=i]) {
            *sum = dot(&column[..n_groups], &other[..n_groups]);
        }
    }
}

/// Sum of products, wrapping.
#[inline(always)]
pub(crate) fn dot(a: &[[i16; ROWS]], b: &[[i16; ROWS]]) -> i32 {
    /// In a vector, or two: those of 32-bit ARM are not found where there is but one sum.
    const LANES: usize = 8;
    let mut sums = [0_i32; LANES];
    for (a, b) in a.iter().zip(b) {
        for i in 0..ROWS {
            let product = i32::from(a[i]) * i32::from(b[i]);
            sums[i % LANES] = sums[i % LANES].wrapping_add(product);
        }
    }
    sums.into_iter().fold(0, i32::wrapping_add)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::ops::Range;

    fn levels(value: impl Strategy<Value = u8> + Clone) -> impl Strategy<Value = Levels> {
        let tiles = prop::array::uniform16(value);
        (tiles.clone(), tiles.clone(), tiles).prop_map(|(low, middle, depth)| Levels {
            low,
            middle,
            depth,
        })
    }

    fn bit(words: &[u64], x: usize) -> bool {
        words[x / WORD] >> (x % WORD) & 1 == 1
    }

    /// The words of a row of tiles, three in each row of pixels.
    #[inline(always)]
    fn words(
        rows: &PaddedRows<'_>,
        levels: &[Levels],
        first: usize,
        is_set: impl Fn(&WordRows<'_>, usize, &[Pixels; 3]) -> Pixels,
    ) -> Vec<u64> {
        let mut words = vec![0; 3 * TILE];
        threshold(rows, levels, first, &mut words, is_set);
        words
    }

    /// What work gives with the usual vectors, and with the best.
    fn both<T>(work: impl Fn() -> T) -> [T; 2] {
        [work(), vectorised(&work)]
    }

    proptest! {
        #[test]
        fn a_bit_follows_from_the_pixels_and_the_levels_of_their_tile(
            rows in prop::collection::vec(
                prop::collection::vec(0_u8..40, 3 * WORD + 2 * LINE_REACH),
                TILE + 2 * LINE_REACH,
            ),
            levels in prop::collection::vec(levels(0_u8..40), 2),
            first in 0_usize..2,
        ) {
            let padded: PaddedRows<'_> = array::from_fn(|i| &rows[i][..]);
            let [dark, bright, black] = [
                both(#[inline(always)] || words(&padded, &levels, first, is_beyond::<true>)),
                both(#[inline(always)] || words(&padded, &levels, first, is_beyond::<false>)),
                both(#[inline(always)] || words(&padded, &levels, first, is_black_or_line)),
            ];
            for (x, y) in (0..3 * WORD).flat_map(|x| (0..TILE).map(move |y| (x, y))) {
                let (here, tile) = (rows[y + LINE_REACH][x + LINE_REACH], x % WORD / TILE);
                let brightest = |pixel: &dyn Fn(usize) -> u8, side: Range<usize>| side.map(pixel).max().unwrap();
                let sides: [&dyn Fn(usize) -> u8; 2] =
                    [&|i| rows[y + LINE_REACH][x + i], &|i| rows[y + i][x + LINE_REACH]];
                let depth = sides.map(|pixel| {
                    let nearer = brightest(pixel, 0..LINE_REACH).min(brightest(pixel, LINE_REACH + 1..LINE_SPAN));
                    nearer.saturating_sub(here)
                });
                let is_line = |least: u8| depth.into_iter().any(|depth| depth >= least);
                let levels = (x / WORD).checked_sub(first).and_then(|word| levels.get(word));
                let [low, middle, least] = levels.map_or([0; 3], |levels| {
                    [levels.low, levels.middle, levels.depth].map(|tiles| tiles[tile])
                });
                let expected = [
                    (&dark, here < middle),
                    (&bright, middle > 0 && here >= middle),
                    (&black, here < low || here < middle && is_line(least)),
                ];
                for (words, is_set) in expected {
                    for words in words {
                        prop_assert_eq!(bit(&words[3 * y..], x), is_set, "pixel {} {}", x, y);
                    }
                }
            }
        }

        #[test]
        fn samples_lie_between_pixels(
            seed in any::<u8>(),
            stride in 17_usize..80,
            cut in 0_usize..8,
            quad in prop::array::uniform4([-30.0_f32..110.0, -30.0_f32..110.0]),
            places in prop::collection::vec(prop::array::uniform2(prop::array::uniform8(-0.2_f32..1.2)), 1..5),
        ) {
            let (width, height) = (stride - cut.min(stride - 16), 50);
            let bytes: Vec<u8> = (0..(height - 1) * stride + width).map(|i| (i * 97 + i / 7) as u8 ^ seed).collect();
            let image = Image::new(&bytes, width, height, stride).unwrap();
            if let Some(map) = Homography::square_to_quad(&quad) {
                let mut best = vec![0.0; POINTS * places.len()];
                sample(&image, &map, &places, &mut best);
                // SAFETY: the pairs are within the image.
                let pairs = |pixels: &_, stride, at: &_| unsafe { pairs(pixels, stride, at) };
                let points = places.iter().map(|places| map.apply_to_points(places));
                let usual: Vec<_> = points.flat_map(|at| bilinear(&image, at, pairs)).collect();
                let points = places.iter().flat_map(|[u, v]| (0..POINTS).map(|i| map.apply(u[i], v[i])));
                for ((point, usual), best) in points.zip(usual).zip(best) {
                    prop_assert_eq!(usual.to_bits(), best.to_bits());
                    let [x, y] = point.map(f64::from);
                    let inside = (0.0..=(width - 1) as f64).contains(&x) && (0.0..=(height - 1) as f64).contains(&y);
                    prop_assert_eq!(usual.is_nan(), !inside);
                    if inside {
                        let (column, row) = ((x as usize).min(width - 2), (y as usize).min(height - 2));
                        let pixel = |i: usize, k: usize| f64::from(image.row(row + k)[column + i]);
                        let across = |k: usize| pixel(0, k) + (x - column as f64) * (pixel(1, k) - pixel(0, k));
                        let expected = across(0) + (y - row as f64) * (across(1) - across(0));
                        prop_assert!((f64::from(usual) - expected).abs() < 1e-3);
                    }
                }
            }
        }

        #[test]
        fn products_are_those_of_each_two_columns(
            seed in any::<u32>(),
            n_groups in 0..=MAX_GROUPS,
        ) {
            let mut columns = Box::new([[[0_i16; ROWS]; MAX_GROUPS]; COLUMNS]);
            for (i, number) in columns.as_flattened_mut().as_flattened_mut().iter_mut().enumerate() {
                *number = (seed.wrapping_mul(i as u32 ^ 0x9e37) >> 20) as i16 - 2048;
            }
            let sums = [plain_products, products].map(|products| {
                let mut sums = [[0; WIDTH]; COLUMNS];
                products(&columns[..], n_groups, &mut sums);
                sums
            });
            let column = |i: usize| columns[i][..n_groups].as_flattened().iter().map(|number| i32::from(*number));
            for (i, k) in (0..COLUMNS).flat_map(|i| (0..=i).map(move |k| (i, k))) {
                let expected = column(i).zip(column(k)).map(|(a, b)| a * b).fold(0, i32::wrapping_add);
                prop_assert_eq!(sums.map(|sums| sums[i][k]), [expected; 2]);
            }
        }
    }
}
