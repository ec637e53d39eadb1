//! When corners come from the whole pattern, and what they are worth then.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Detection, Detector, Image, Options, Refinement};
use sextant_geometry::{Intrinsics, Lens};

fn camera() -> Camera {
    Camera::new(120, 110)
}

fn detect_one(pixels: &[u8]) -> Detection {
    let camera = camera();
    let image = Image::new(pixels, camera.width, camera.height, camera.width).unwrap();
    let mut detector = Detector::new(Options::default()).unwrap();
    let found = detector.detect(&image);
    assert_eq!(found.len(), 1);
    found[0]
}

fn draw(tag: &Tag, blur_px: f64) -> Picture {
    Picture::draw(&camera(), std::slice::from_ref(tag), 128.0).blurred(blur_px)
}

fn worst_error(detection: &Detection, tag: &Tag) -> f64 {
    let errors = detection
        .corners
        .iter()
        .zip(tag.corners(&camera()))
        .map(|(c, t)| (f64::from(c[0]) - t[0]).hypot(f64::from(c[1]) - t[1]));
    errors.fold(0.0, f64::max)
}

/// Turned a little, of about so many pixels an edge.
fn tag(edge_px: f64) -> Tag {
    let size_m = 0.04;
    Tag {
        size_m,
        position_m: [0.0, 0.0, 600.0 * size_m / edge_px],
        turn_deg: [25.0, -20.0, 31.0],
        greys: [40.0, 180.0],
        ..Tag::new(17)
    }
}

/// Greys through a curve, and noise after it.
fn through(curve: impl Fn(f64) -> f64, pixels: &[u8], noise_sigma: f64) -> Vec<u8> {
    let mut random = Random(5);
    let grey = |&grey: &u8| {
        (255.0 * curve(f64::from(grey) / 255.0) + noise_sigma * random.normal()).round() as u8
    };
    pixels.iter().map(grey).collect()
}

#[test]
fn small_blurred_tags_show_their_corners_by_the_whole_pattern() {
    for (edge_px, blur_px) in [(14.0, 0.7), (18.0, 1.0), (24.0, 1.4)] {
        let tag = tag(edge_px);
        let found = detect_one(&draw(&tag, blur_px).pixels(1.0, 3));
        assert_eq!(found.refinement, Refinement::Photometric, "{edge_px} px");
        let error = worst_error(&found, &tag);
        assert!(error < 0.06, "{edge_px} px: off by {error}");
    }
}

#[test]
fn a_bent_grey_scale_moves_no_corner() {
    for power in [0.45, 0.6, 2.2] {
        let tag = tag(45.0);
        let straight = draw(&tag, 0.8).pixels(0.0, 1);
        let found = detect_one(&through(|grey| grey.powf(power), &straight, 1.0));
        assert_eq!(found.refinement, Refinement::Photometric, "power {power}");
        let error = worst_error(&found, &tag);
        assert!(error < 0.04, "power {power}: off by {error}");
    }
}

#[test]
fn light_that_falls_off_to_one_side_moves_no_corner() {
    let tag = Tag {
        turn_deg: [0.0, 0.0, 31.0],
        ..tag(64.0)
    };
    let picture = Picture::draw(&camera(), std::slice::from_ref(&tag), 128.0);
    let found = detect_one(&picture.lit([0.005, -0.003]).blurred(2.0).pixels(0.5, 2));
    assert_eq!(found.refinement, Refinement::Photometric);
    let error = worst_error(&found, &tag);
    assert!(error < 0.015, "off by {error}");
}

#[test]
fn light_that_falls_off_to_one_side_moves_no_corner_through_a_curve_either() {
    for (power, most) in [(0.5, 0.05), (0.7, 0.025), (1.3, 0.04)] {
        let tag = tag(64.0);
        let picture = Picture::draw(&camera(), std::slice::from_ref(&tag), 128.0);
        let straight = picture.lit([0.004, -0.002]).blurred(2.0).pixels(0.0, 2);
        let found = detect_one(&through(|grey| grey.powf(power), &straight, 0.5));
        assert_eq!(found.refinement, Refinement::Photometric);
        let error = worst_error(&found, &tag);
        assert!(error < most, "power {power}: off by {error}");
    }
}

#[test]
fn corners_of_a_picture_without_blur_are_seen_by_the_shares_of_pixels() {
    for edge_px in [24.0, 40.0] {
        let tag = Tag {
            turn_deg: [0.0, 0.0, 90.0],
            ..tag(edge_px)
        };
        let picture = Picture::draw(&camera(), std::slice::from_ref(&tag), 128.0);
        let found = detect_one(&picture.pixels(1.0, 5));
        assert_eq!(found.refinement, Refinement::Photometric, "{edge_px} px");
        let error = worst_error(&found, &tag);
        assert!(error < 0.06, "{edge_px} px: off by {error}");
    }
}

#[test]
fn the_ground_that_blur_mixes_into_the_ring_moves_no_corner() {
    for (ground, edge_px, blur_px) in [(10.0, 24.0, 1.0), (10.0, 30.0, 1.6), (90.0, 18.0, 0.9)] {
        let tag = Tag {
            turn_deg: [50.0, -15.0, 31.0],
            margin: 0.0,
            ..tag(edge_px)
        };
        let picture = Picture::draw(&camera(), std::slice::from_ref(&tag), ground);
        let found = detect_one(&picture.blurred(blur_px).pixels(1.0, 6));
        assert_eq!(found.refinement, Refinement::Photometric, "{edge_px} px");
        let error = worst_error(&found, &tag);
        assert!(error < 0.08, "{edge_px} px: off by {error}");
    }
}

/// As a camera sharpens: what a small blur would take away is added.
fn sharpened(pixels: &[u8], strength: f64) -> Vec<u8> {
    const KERNEL: [f64; 3] = [0.25, 0.5, 0.25];
    let (width, height) = (camera().width, camera().height);
    let at = |x: usize, y: usize| f64::from(pixels[y.min(height - 1) * width + x.min(width - 1)]);
    let blurred = |x: usize, y: usize| -> f64 {
        let row = |y: usize| {
            (0..3)
                .map(|i| KERNEL[i] * at((x + i).saturating_sub(1), y))
                .sum::<f64>()
        };
        (0..3)
            .map(|k| KERNEL[k] * row((y + k).saturating_sub(1)))
            .sum()
    };
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        (at(x, y) + strength * (at(x, y) - blurred(x, y))).round() as u8
    };
    (0..pixels.len()).map(pixel).collect()
}

#[test]
fn halos_of_a_sharpened_picture_move_no_corner() {
    for (edge_px, strength) in [(17.0, 2.0), (21.0, 3.0), (26.0, 3.0)] {
        let tag = tag(edge_px);
        let found = detect_one(&sharpened(&draw(&tag, 0.9).pixels(0.5, 1), strength));
        assert_eq!(found.refinement, Refinement::Photometric, "{edge_px} px");
        let error = worst_error(&found, &tag);
        assert!(error < 0.09, "{edge_px} px: off by {error}");
    }
}

/// Mean of the errors squared over the reported covariance, per degree of freedom.
fn normalised_error(detection: &Detection, tag: &Tag) -> f64 {
    let corners = detection.corners.iter().zip(tag.corners(&camera()));
    let errors = corners.map(|(c, t)| [f64::from(c[0]) - t[0], f64::from(c[1]) - t[1]]);
    let normalised = errors
        .zip(detection.corner_covariance)
        .map(|([x, y], stated)| {
            let [xx, xy, yy] = stated.map(f64::from);
            (x * x * yy - 2.0 * x * y * xy + y * y * xx) / (xx * yy - xy * xy)
        });
    normalised.sum::<f64>() / 8.0
}

/// Mean normalised error of tags of many sizes, turned by so much.
fn mean_normalised_error(turn_deg: f64, blur_px: f64, change: impl Fn(&[u8]) -> Vec<u8>) -> f64 {
    const N: u32 = 16;
    let errors = (0..N).map(|i| {
        let tag = Tag {
            turn_deg: [0.0, 0.0, turn_deg],
            ..tag(26.0 + 2.3 * f64::from(i))
        };
        let found = detect_one(&change(&draw(&tag, blur_px).pixels(0.7, 7)));
        normalised_error(&found, &tag)
    });
    errors.sum::<f64>() / f64::from(N)
}

#[test]
fn covariances_know_of_pictures_that_are_not_what_is_fitted() {
    let halos = mean_normalised_error(31.0, 0.8, |pixels| sharpened(pixels, 3.0));
    assert!(halos < 2.0, "sharpened: {halos}");
    // Hardly turned, as what is drawn has a grid of its own.
    let grid = mean_normalised_error(0.3, 0.01, <[u8]>::to_vec);
    assert!(grid < 1.7, "along the grid, without blur: {grid}");
}

#[test]
fn all_corners_of_a_large_blurred_tag_are_looked_at() {
    let found = detect_one(&draw(&tag(64.0), 2.2).pixels(1.0, 4));
    assert_eq!(found.refinement, Refinement::Photometric);
    let variances = found.corner_covariance.map(|[xx, _, yy]| xx + yy);
    let least = variances.into_iter().fold(f32::INFINITY, f32::min);
    let most = variances.into_iter().fold(0.0, f32::max);
    assert!(most < 4.0 * least, "variances {variances:?}");
}

#[test]
fn a_pattern_that_is_not_where_its_border_is_has_no_say() {
    const SHIFT_PX: f64 = 0.6;
    let tag = Tag {
        turn_deg: [0.0; 3],
        ..tag(48.0)
    };
    let metres_per_px = tag.position_m[2] / camera().focal;
    let mut shifted = tag.clone();
    shifted.position_m[0] += SHIFT_PX * metres_per_px;
    let mut pixels = draw(&tag, 0.6).pixels(1.0, 1);
    let inside = draw(&shifted, 0.6).pixels(1.0, 2);
    let [top_left, _, bottom_right, _] = tag.corners(&camera());
    let within = |at: usize, axis: usize| {
        let share = (at as f64 - top_left[axis]) / (bottom_right[axis] - top_left[axis]);
        (0.07..0.93).contains(&share)
    };
    let width = camera().width;
    for (i, (pixel, inside)) in pixels.iter_mut().zip(inside).enumerate() {
        if within(i % width, 0) && within(i / width, 1) {
            *pixel = inside;
        }
    }
    let found = detect_one(&pixels);
    let error = worst_error(&found, &tag);
    assert_eq!(found.refinement, Refinement::Edges);
    assert!(error < 0.1, "off by {error}");
}

/// Greatest error of a large tag's corners towards the image's corner, seen through a strong lens.
fn error_through(lens: &Lens, known: Option<Lens>) -> f64 {
    let camera = Camera {
        lens: Some(*lens),
        ..Camera::new(190, 142)
    };
    let tag = Tag {
        position_m: [0.055, -0.03, 0.24],
        turn_deg: [8.0, -12.0, 20.0],
        greys: [40.0, 180.0],
        ..Tag::new(23)
    };
    let picture = Picture::draw(&camera, std::slice::from_ref(&tag), 128.0).blurred(0.6);
    let pixels = picture.pixels(1.0, 9);
    let image = Image::new(&pixels, camera.width, camera.height, camera.width).unwrap();
    let mut detector = Detector::new(Options::default()).unwrap();
    detector.set_lens(known);
    let found = detector.detect(&image);
    assert_eq!(found.len(), 1);
    let errors = found[0]
        .corners
        .iter()
        .zip(tag.corners(&camera))
        .map(|(c, t)| (f64::from(c[0]) - t[0]).hypot(f64::from(c[1]) - t[1]));
    errors.fold(0.0, f64::max)
}

#[test]
fn a_tag_that_a_lens_bends_is_fitted_through_it() {
    let intrinsics = Intrinsics {
        fx: 154.0,
        fy: 154.0,
        cx: 94.6,
        cy: 70.8,
    };
    let lens = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.002, -0.001, 0.0]).unwrap();
    let (with, without) = (error_through(&lens, Some(lens)), error_through(&lens, None));
    assert!(with < 0.03, "{with} px with the lens");
    assert!(
        with < without / 5.0,
        "{with} px with the lens, {without} without"
    );
}
