//! Whatever bytes make of options and pictures, the detector says nothing that it must not say, and does not panic.

#![allow(clippy::expect_used)]

#[path = "any_bytes/any_picture.rs"]
mod any_picture;

use proptest::prelude::*;
use sextant_apriltag::{Detector, Family, Image, Options};
use sextant_tag_families::module_is_white;

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
    let (widest, highest) = (4096, 3072);
    let pixels = |period: usize| -> Vec<u8> {
        let check = |i: usize| (i % widest / period + i / widest / period) % 2;
        (0..widest * highest)
            .map(|i| 255 * check(i) as u8)
            .collect()
    };
    let all = Options {
        families: Family::coded().collect(),
        ..Options::default()
    };
    let mut detector = Detector::new(all).expect("the defaults are within their ranges");
    for pixels in [pixels(1), pixels(2), pixels(8)] {
        for (width, height) in [(16, 16), (32_768, 300), (300, 32_768), (widest, highest)] {
            let image = Image::new(&pixels, width, height, width).expect("it is an image");
            assert_eq!(detector.detect(&image), [], "{width}x{height}");
        }
    }
}

#[test]
fn what_a_picture_showed_is_forgotten_in_a_plain_one() {
    // A tag with checks along its left edge, dark beside the ring around it: as if in shade, but read all the same.
    const MODULE: usize = 12;
    let grey = |i: usize| {
        let (x, y) = (i % 640, i / 640);
        let on_tag = (480..600).contains(&x) && (8..128).contains(&y);
        if !on_tag || module_is_white(Family::Tag36h11, 7, (x - 480) / MODULE, (y - 8) / MODULE) {
            250
        } else {
            let checks = (492..496).contains(&x) && (x / 2 + y / 2) % 2 == 0;
            if checks { 90 } else { 20 }
        }
    };
    let crowded: Vec<u8> = (0..640 * 480).map(grey).collect();
    let plain = [128; 39 * 40];
    let mut detector =
        Detector::new(Options::default()).expect("the defaults are within their ranges");
    let crowded = Image::new(&crowded, 640, 480, 640).expect("it is an image");
    let plain = Image::new(&plain, 39, 40, 39).expect("it is an image");
    assert_eq!(detector.detect(&crowded).len(), 1);
    assert_eq!(detector.detect(&plain), []);
    assert_eq!(detector.report().components, 0);
}
