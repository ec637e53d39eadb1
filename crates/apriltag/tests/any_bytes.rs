//! Whatever bytes make of options and pictures, the detector says nothing that it must not say, and does not panic.

#![allow(clippy::expect_used)]

#[path = "../fuzz/any_picture.rs"]
mod any_picture;

use proptest::prelude::*;
use sextant_apriltag::{Detector, Family, Image, Options};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_bytes_make_a_picture_that_is_taken(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        any_picture::detect(&bytes);
    }
}

/// Checks of one pixel have the most runs that there can be, checks of eight the most candidates.
#[test]
fn extreme_sizes_and_patterns_are_taken() {
    let (widest, highest) = (Image::MAX_WIDTH, Image::MAX_HEIGHT);
    let pixels = |period: usize| -> Vec<u8> {
        let check = |i: usize| (i % widest / period + i / widest / period) % 2;
        (0..widest * highest)
            .map(|i| 255 * check(i) as u8)
            .collect()
    };
    let all = Options {
        families: Family::ALL.to_vec(),
        ..Options::default()
    };
    let mut detector = Detector::new(all).expect("the defaults are within their ranges");
    for pixels in [pixels(1), pixels(2), pixels(8)] {
        for (width, height) in [(16, 16), (widest, 16), (16, highest), (widest, highest)] {
            let image = Image::new(&pixels, width, height, widest).expect("it is an image");
            assert_eq!(detector.detect(&image), [], "{width}x{height}");
        }
    }
}
