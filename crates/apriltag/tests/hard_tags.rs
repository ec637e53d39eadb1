//! Tags with something close beside them, over them or before them.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag, detect};
use sextant_apriltag::{Detection, Family};

const SIZE: usize = 240;

fn draw(tag: &Tag, blur_px: f64) -> Vec<u8> {
    let camera = Camera::new(SIZE, SIZE);
    let picture = Picture::draw(&camera, std::slice::from_ref(tag), 128.0);
    picture.blurred(blur_px).pixels(1.5, 7)
}

fn ids(found: &[Detection]) -> Vec<u32> {
    found.iter().map(|tag| tag.id).collect()
}

/// Paints pixels for which this holds, with their distances from the middle of a place in pixels.
fn paint(pixels: &mut [u8], [x, y]: [f64; 2], grey: u8, is_within: impl Fn(f64, f64) -> bool) {
    for (i, pixel) in pixels.iter_mut().enumerate() {
        let (dx, dy) = ((i % SIZE) as f64 - x, (i / SIZE) as f64 - y);
        if is_within(dx, dy) {
            *pixel = grey;
        }
    }
}

/// Half a module of white, and black squares beyond.
#[test]
fn a_narrow_rim_before_dark_squares_is_enough() {
    let mut random = Random(51);
    let mut n_markers = 0;
    for id in 0..30 {
        let tag = Tag {
            share: 0.85,
            margin: 12.0,
            greys: [20.0, 110.0],
            ..Tag::turned(
                Family::Charuco4x4With1000,
                33 * id,
                random.between(30.0, 60.0),
                30.0,
                &mut random,
            )
        };
        let pixels = draw(&tag, 0.9);
        let marker = detect(&pixels, SIZE, &[Family::Aruco4x4With1000]);
        n_markers += usize::from(ids(&marker) == [tag.id]);
    }
    assert!(n_markers >= 29, "{n_markers} of 30 markers");
}

#[test]
fn tags_of_any_family_are_separated_from_squares_at_their_corners() {
    let (mut random, camera) = (Random(52), Camera::new(SIZE, SIZE));
    for family in [
        Family::Tag36h10,
        Family::ArucoMip36h12,
        Family::Aruco5x5With250,
    ] {
        for id in 0..6 {
            let tag = Tag {
                touched: true,
                margin: 4.0,
                ..Tag::turned(
                    family,
                    40 * id,
                    random.between(45.0, 110.0),
                    30.0,
                    &mut random,
                )
            };
            let found = detect(&draw(&tag, 0.7), SIZE, &[family]);
            assert_eq!(ids(&found), [tag.id], "{family}");
            for (corner, truth) in found[0].corners.iter().zip(tag.corners(&camera)) {
                let off = (f64::from(corner[0]) - truth[0]).hypot(f64::from(corner[1]) - truth[1]);
                assert!(off < 0.5, "{family} {}: {off} px", tag.id);
            }
        }
    }
}

/// A line of two pixels through the middles of the modules, black or white: no point in the middle of one is right.
#[test]
fn lines_drawn_over_a_tag_hide_no_bits() {
    for family in [
        Family::Tag36h11,
        Family::Aruco4x4With50,
        Family::Aruco5x5With1000,
    ] {
        let modules = f64::from(family.data().border_width);
        for id in 0..8 {
            let tag = Tag {
                family,
                position_m: [0.0, 0.0, 0.04 * 600.0 / 150.0],
                ..Tag::new(3 + 5 * id)
            };
            let camera = Camera::new(SIZE, SIZE);
            let mut pixels = draw(&tag, 0.6);
            let module = 150.0 / modules;
            let aside = (1.5 + f64::from(id % 3) - modules / 2.0) * module;
            let reach = 75.0 - 1.2 * module;
            let (grey, is_row) = ([20, 230][id as usize % 2], id % 4 < 2);
            paint(&mut pixels, camera.centre, grey, |dx, dy| {
                let (along, across) = if is_row { (dx, dy) } else { (dy, dx) };
                along.abs() < reach && (across - aside).abs() <= 1.0
            });
            let found = detect(&pixels, SIZE, &[family]);
            assert_eq!(ids(&found), [tag.id], "{family}");
        }
    }
}

/// What hides a corner leaves it where the rest of the tag says, or uncertain by as much as it is wrong.
#[test]
fn a_hidden_corner_is_known_to_be_uncertain() {
    let (mut random, camera) = (Random(53), Camera::new(SIZE, SIZE));
    let mut n_found = 0;
    for id in 0..12 {
        let tag = Tag::turned(Family::Tag36h11, 7 + id, 130.0, 25.0, &mut random);
        let mut pixels = draw(&tag, 0.7);
        let truth = tag.corners(&camera);
        let radius = random.between(12.0, 24.0);
        paint(&mut pixels, truth[0], 128, |dx, dy| dx.hypot(dy) < radius);
        for found in detect(&pixels, SIZE, &[tag.family]) {
            n_found += 1;
            let off = [0, 1].map(|axis| f64::from(found.corners[0][axis]) - truth[0][axis]);
            let [xx, _, yy] = found.corner_covariance[0].map(f64::from);
            let sigma = ((xx + yy) / 2.0).sqrt();
            let off = off[0].hypot(off[1]);
            assert!(off < 3.0 || sigma > 1.0, "{off} px at {sigma}");
        }
    }
    assert!(n_found > 8, "{n_found}");
}

/// A sheet over a part of a marker leaves something like a smaller one. Now and then that has a word of its own.
#[test]
fn a_part_of_a_marker_is_hardly_ever_a_marker() {
    let camera = Camera::new(SIZE, SIZE);
    let mut n_found = 0;
    for (id, covered) in (0..120).flat_map(|id| [(id, 1.3), (id, 2.2), (id, 3.1)]) {
        let tag = Tag {
            family: Family::Aruco4x4With1000,
            position_m: [0.0, 0.0, 0.04 * 600.0 / 72.0],
            ..Tag::new(id)
        };
        let mut pixels = draw(&tag, 0.8);
        let end = (covered - 3.0) * 12.0;
        paint(&mut pixels, camera.centre, 220, |_, dy| dy < end);
        n_found += detect(&pixels, SIZE, &[tag.family]).len();
    }
    assert!(n_found <= 7, "{n_found} of 360");
}
