//! The tracker on sequences of which everything is known.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use proptest::prelude::*;
use sextant_apriltag::{Detection, Detector, Image, Options, Tracker};
use std::sync::LazyLock;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

/// A part of a picture with one tag in it, to be pasted where it is wanted.
struct Sticker {
    width: usize,
    pixels: Vec<u8>,
}

impl Sticker {
    fn draw(id: u32, edge_px: f64) -> Self {
        let width = (edge_px * 1.8) as usize + 4;
        let camera = Camera::new(width, width);
        let tag = Tag {
            position_m: [0.0, 0.0, 0.04 * camera.focal / edge_px],
            turn_deg: [10.0, -15.0, 20.0],
            ..Tag::new(id)
        };
        Self {
            width,
            pixels: Picture::draw(&camera, &[tag], 128.0)
                .blurred(0.5)
                .pixels(0.0, 1),
        }
    }
}

/// Tags of 14, 30 and 120 px.
static STICKERS: LazyLock<[Sticker; 3]> =
    LazyLock::new(|| [(7, 14.0), (8, 30.0), (9, 120.0)].map(|(id, edge)| Sticker::draw(id, edge)));

/// A plain ground with noise and stickers on it, as far as they are within the image.
fn image_of(stickers: &[(&Sticker, [isize; 2])], random: &mut Random) -> Vec<u8> {
    let mut pixels = vec![128; WIDTH * HEIGHT];
    for (sticker, [left, top]) in stickers {
        for (y, row) in (*top..).zip(sticker.pixels.chunks(sticker.width)) {
            for (x, &grey) in (*left..).zip(row) {
                if (0..WIDTH as isize).contains(&x) && (0..HEIGHT as isize).contains(&y) {
                    pixels[y as usize * WIDTH + x as usize] = grey;
                }
            }
        }
    }
    for greys in pixels.chunks_mut(32) {
        // Two bits a pixel: -1, 0, 1 or 2 grey levels.
        let mut bits = random.uniform().to_bits() << 12 | random.uniform().to_bits() >> 20;
        for grey in greys {
            *grey = grey.saturating_add_signed((bits & 3) as i8 - 1);
            bits >>= 2;
        }
    }
    pixels
}

fn image(pixels: &[u8]) -> Image<'_> {
    Image::new(pixels, WIDTH, HEIGHT, WIDTH).unwrap()
}

fn tracker() -> Tracker {
    Tracker::new(Options::default()).unwrap()
}

fn ids(found: &[Detection]) -> Vec<u32> {
    found.iter().map(|detection| detection.id).collect()
}

fn farthest_corner(a: &Detection, b: &Detection) -> f32 {
    let distances = a.corners.iter().zip(&b.corners);
    distances
        .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
        .fold(0.0, f32::max)
}

#[test]
fn the_first_image_and_one_of_another_size_are_searched_whole() {
    let mut random = Random(3);
    let pixels = image_of(&[(&STICKERS[1], [200, 150])], &mut random);
    let mut tracker = tracker();
    assert_eq!(ids(tracker.detect(&image(&pixels))), [8]);
    assert_eq!(tracker.tracking_report().share, 1.0);
    tracker.detect(&image(&pixels));
    assert!(tracker.tracking_report().share < 0.6);
    let upper = Image::new(&pixels, WIDTH, HEIGHT - 8, WIDTH).unwrap();
    tracker.detect(&upper);
    assert_eq!(tracker.tracking_report().share, 1.0);
}

#[test]
fn a_tag_that_is_gone_is_awaited_for_three_images_and_never_reported() {
    let mut random = Random(4);
    let shown = image_of(&[(&STICKERS[1], [100, 90])], &mut random);
    let empty = image_of(&[], &mut random);
    let mut tracker = tracker();
    for _ in 0..4 {
        assert_eq!(ids(tracker.detect(&image(&shown))), [8]);
        assert_eq!(tracker.tracking_report().awaited, 0);
    }
    for _ in 0..3 {
        assert_eq!(tracker.detect(&image(&empty)), []);
        assert_eq!(tracker.tracking_report().awaited, 1);
    }
    assert_eq!(tracker.detect(&image(&empty)), []);
    assert_eq!(tracker.tracking_report().awaited, 0);
}

#[test]
fn tags_that_move_by_up_to_24_pixels_an_image_are_in_every_image() {
    for step in [[24, 0], [-17, 17], [0, -24], [3, 1]] {
        let mut random = Random(5);
        let mut tracker = tracker();
        for n in 0..9_isize {
            // From one side of the image to the other, through its middle.
            let at = [0, 1].map(|axis| [136, 96][axis] + (n - 4) * step[axis]);
            let pixels = image_of(&[(&STICKERS[0], at)], &mut random);
            assert_eq!(
                ids(tracker.detect(&image(&pixels))),
                [7],
                "{step:?}, image {n}"
            );
        }
    }
}

#[test]
fn two_tags_of_one_id_are_both_followed() {
    let mut random = Random(6);
    let mut tracker = tracker();
    for n in 0..12 {
        let stickers = [
            (&STICKERS[1], [20 + 9 * n, 30]),
            (&STICKERS[1], [230 - 9 * n, 160]),
        ];
        let pixels = image_of(&stickers, &mut random);
        assert_eq!(ids(tracker.detect(&image(&pixels))), [8, 8], "image {n}");
        let report = tracker.tracking_report();
        assert_eq!(
            (report.followed, report.discovered),
            if n == 0 { (0, 2) } else { (2, 0) }
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_new_tag_is_found_within_ten_images(
        which in 0_usize..3,
        place in [0.0_f64..1.0, 0.0..1.0],
        step in [-3_isize..=3, -3_isize..=3],
        before in 0_usize..10,
        seed in 1_u64..1000,
    ) {
        let (sticker, mut random, mut tracker) = (&STICKERS[which], Random(seed), tracker());
        let empty = image_of(&[], &mut random);
        for _ in 0..=before {
            prop_assert_eq!(tracker.detect(&image(&empty)), []);
        }
        let free = [WIDTH, HEIGHT].map(|size| size - sticker.width);
        let found_after = (0..10).position(|n| {
            // It stays within the image.
            let at = [0, 1].map(|axis| (free[axis] as f64 * place[axis]) as isize + n * step[axis]);
            let at = [0, 1].map(|axis| at[axis].clamp(0, free[axis] as isize));
            let pixels = image_of(&[(sticker, at)], &mut random);
            !tracker.detect(&image(&pixels)).is_empty()
        });
        prop_assert!(found_after.is_some());
    }

    #[test]
    fn what_is_tracked_is_what_a_search_of_the_whole_image_finds(
        starts in [[0_isize..280, 0_isize..200], [0_isize..260, 0_isize..180]],
        steps in [[-12_isize..=12, -12_isize..=12], [-12_isize..=12, -12_isize..=12]],
        seed in 1_u64..1000,
    ) {
        let (mut random, mut tracker) = (Random(seed), tracker());
        let mut detector = Detector::new(Options::default()).unwrap();
        for n in 0..6 {
            let at = |k: usize| [0, 1].map(|axis: usize| starts[k][axis] + n * steps[k][axis]);
            let pixels = image_of(&[(&STICKERS[0], at(0)), (&STICKERS[1], at(1))], &mut random);
            let all = detector.detect(&image(&pixels));
            for tracked in tracker.detect(&image(&pixels)) {
                let same = |whole: &&Detection| {
                    (whole.id, whole.hamming) == (tracked.id, tracked.hamming)
                        && farthest_corner(whole, tracked) < 0.02
                };
                prop_assert!(all.iter().any(|whole| same(&whole)), "image {}: {:?} of {:?}", n, tracked, all);
            }
        }
    }

    #[test]
    fn any_sequence_of_sizes_is_taken(
        sizes in prop::collection::vec((16_usize..320, 16_usize..240), 1..8),
        seed in 1_u64..1000,
    ) {
        let (mut random, mut tracker) = (Random(seed), tracker());
        let pixels = image_of(&[(&STICKERS[0], [10, 10]), (&STICKERS[1], [40, 60])], &mut random);
        for (width, height) in sizes {
            let image = Image::new(&pixels, width, height, WIDTH).unwrap();
            for _ in 0..3 {
                tracker.detect(&image);
                prop_assert!(tracker.tracking_report().share <= 1.0);
            }
        }
    }
}
