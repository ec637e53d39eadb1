//! The loops that take most of the time, once an instruction set.
//!
//! [`scalar`] says what is meant; the others give the same bytes faster. Dispatch happens here and only here.

use crate::Image;
use crate::homography::Homography;

mod scalar;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon;

/// Edge of a tile in pixels. Four is the largest for which the nine tiles around a pixel span no more than a small
/// tag (11 px), so that its black border and its white ring are always among them.
pub(crate) const TILE: usize = 4;

/// Pixels in a word of the bit plane.
pub(crate) const WORD: usize = 64;

/// Tiles in a word of the bit plane.
pub(crate) const TILES_IN_WORD: usize = WORD / TILE;

/// Points that are sampled at a time.
pub(crate) const POINTS: usize = 8;

/// Rows of numbers that lie together, and how many times as many a column has at most.
pub(crate) const ROWS: usize = 16;
pub(crate) const MAX_GROUPS: usize = 80;

/// Columns of numbers of which sums of products are taken.
pub(crate) const COLUMNS: usize = 19;

pub(crate) type Column = [[i16; ROWS]; MAX_GROUPS];

/// Sums of the products of each column with itself and those before it; what stands after the diagonal is nothing.
pub(crate) type Sums = [[i32; COLUMNS]; COLUMNS];

/// A coordinate, or the grey, of as many points.
pub(crate) type Points = [f32; POINTS];

type Sample = fn(image: &Image<'_>, map: &Homography, places: &[[Points; 2]], greys: &mut [Points]);
type Products = fn(columns: &[Column; COLUMNS], n_groups: usize, sums: &mut Sums);
type ThresholdWords = fn(row: &[u8], levels: &[u8], words: &mut [u64]);

/// One set of kernels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernels {
    threshold: ThresholdWords,
    /// Grey by bilinear interpolation where places (u, v) are mapped to; NaN outside the image.
    pub(crate) sample: Sample,
    /// Of the first so many groups of the columns, wrapping.
    pub(crate) products: Products,
    vectors: Vectors,
}

/// Vector instructions that plain loops may be compiled to.
#[derive(Clone, Copy, Debug)]
enum Vectors {
    /// Those that every processor of the target has.
    Usual,
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Detected),
}

impl Kernels {
    pub(crate) const SCALAR: Self = Self {
        threshold: scalar::threshold_words,
        sample: scalar::sample,
        products: scalar::products,
        vectors: Vectors::Usual,
    };

    /// The fastest that this processor can run.
    pub(crate) fn fastest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = avx2::kernels() {
            return kernels;
        }
        #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
        return neon::KERNELS;
        #[cfg(not(all(target_arch = "aarch64", target_feature = "neon")))]
        Self::SCALAR
    }

    /// Runs a loop, compiled for the best vectors that there are, as far as it is inlined.
    #[inline(always)]
    pub(crate) fn run<T>(&self, work: impl FnOnce() -> T) -> T {
        match self.vectors {
            Vectors::Usual => work(),
            #[cfg(target_arch = "x86_64")]
            Vectors::Avx2(detected) => detected.run(work),
        }
    }

    /// One bit a pixel, the least significant leftmost: set where the pixel is below its tile's level.
    /// `levels` holds whole words of tiles.
    pub(crate) fn threshold_row(&self, row: &[u8], levels: &[u8], words: &mut [u64]) {
        let (whole, rest) = row.split_at(row.len() / WORD * WORD);
        let n_whole = whole.len() / WORD;
        (self.threshold)(
            whole,
            &levels[..n_whole * TILES_IN_WORD],
            &mut words[..n_whole],
        );
        if !rest.is_empty() {
            let mut padded = [u8::MAX; WORD];
            padded[..rest.len()].copy_from_slice(rest);
            let levels = &levels[n_whole * TILES_IN_WORD..][..TILES_IN_WORD];
            (self.threshold)(&padded, levels, &mut words[n_whole..=n_whole]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn threshold(kernels: Kernels, row: &[u8], levels: &[u8]) -> Vec<u64> {
        let mut words = vec![0; row.len().div_ceil(WORD)];
        kernels.threshold_row(row, levels, &mut words);
        words
    }

    proptest! {
        #[test]
        fn fast_threshold_equals_the_scalar_one(
            row in prop::collection::vec(any::<u8>(), 1..300),
            levels in prop::collection::vec(prop_oneof![Just(0), any::<u8>()], 5 * TILES_IN_WORD),
        ) {
            prop_assert_eq!(threshold(Kernels::fastest(), &row, &levels), threshold(Kernels::SCALAR, &row, &levels));
        }

        #[test]
        fn fast_samples_equal_the_scalar_ones(
            seed in any::<u8>(),
            stride in 17_usize..80,
            cut in 0_usize..8,
            quad in prop::array::uniform4([-30.0_f32..110.0, -30.0_f32..110.0]),
            places in prop::collection::vec(prop::array::uniform2(prop::array::uniform8(-0.2_f32..1.2)), 1..5),
        ) {
            let (width, height) = (stride - cut.min(stride - 16), 50);
            let bytes: Vec<u8> = (0..(height - 1) * stride + width).map(|i| (i * 97 + i / 7) as u8 ^ seed).collect();
            let image = Image::new(&bytes, width, height, stride).unwrap();
            if let Some(map) = Homography::square_to_quad(&quad, 1.0) {
                let sample = |kernels: Kernels| {
                    let mut greys = vec![[0.0; POINTS]; places.len()];
                    (kernels.sample)(&image, &map, &places, &mut greys);
                    greys.into_flattened().into_iter().map(f32::to_bits).collect::<Vec<_>>()
                };
                prop_assert_eq!(sample(Kernels::fastest()), sample(Kernels::SCALAR));
            }
        }

        #[test]
        fn fast_products_equal_the_scalar_ones(
            seed in any::<u32>(),
            n_groups in 0..=MAX_GROUPS,
        ) {
            let mut columns = Box::new([[[0_i16; ROWS]; MAX_GROUPS]; COLUMNS]);
            for (i, number) in columns.as_flattened_mut().as_flattened_mut().iter_mut().enumerate() {
                *number = (seed.wrapping_mul(i as u32 ^ 0x9e37) >> 20) as i16 - 2048;
            }
            let products = |kernels: Kernels| {
                let mut sums = [[0; COLUMNS]; COLUMNS];
                (kernels.products)(&columns, n_groups, &mut sums);
                let row = |i: usize| sums[i][..=i].to_vec();
                (0..COLUMNS).map(row).collect::<Vec<_>>()
            };
            prop_assert_eq!(products(Kernels::fastest()), products(Kernels::SCALAR));
        }

        #[test]
        fn a_bit_is_set_exactly_where_a_pixel_is_below_its_level(
            row in prop::collection::vec(any::<u8>(), 1..300),
            levels in prop::collection::vec(any::<u8>(), 5 * TILES_IN_WORD),
        ) {
            let words = threshold(Kernels::SCALAR, &row, &levels);
            for x in 0..words.len() * WORD {
                let expected = x < row.len() && row[x] < levels[x / TILE];
                prop_assert_eq!(words[x / WORD] >> (x % WORD) & 1 == 1, expected, "pixel {}", x);
            }
        }
    }
}
