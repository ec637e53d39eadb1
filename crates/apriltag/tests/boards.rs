//! Tags of calibration boards: their corners are the saddle points of the boards.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Detection, Family};
use sextant_geometry::{Intrinsics, Lens};

const SIZE: usize = 120;

fn draw(camera: &Camera, tags: &[Tag], blur_px: f64) -> Vec<u8> {
    let picture = Picture::draw(camera, tags, 128.0);
    picture.blurred(blur_px).pixels(1.0, 3)
}

fn detect(pixels: &[u8], families: &[Family]) -> Vec<Detection> {
    crate::drawing::detect(pixels, SIZE, families)
}

/// A tag so many pixels wide, turned at random, and its board around it.
fn tag(family: Family, id: u32, edge_px: f64, random: &mut Random) -> Tag {
    Tag {
        margin: 12.0,
        ..Tag::turned(family, id, edge_px, 35.0, random)
    }
}

/// Distances of the corners from where they are.
fn errors(tag: &Tag, camera: &Camera, found: &Detection) -> [f64; 4] {
    let truth = tag.corners(camera);
    std::array::from_fn(|i| {
        let [x, y] = found.corners[i].map(f64::from);
        (x - truth[i][0]).hypot(y - truth[i][1])
    })
}

fn sigma_px(found: &Detection, corner: usize) -> f64 {
    let [xx, _, yy] = found.corner_covariance[corner].map(f64::from);
    ((xx + yy) / 2.0).sqrt()
}

/// White so bright that it is clipped grows over its edges, but not over saddle points.
#[test]
fn glare_does_not_move_the_corners_of_an_aprilgrids_tags() {
    let (mut random, camera) = (Random(31), Camera::new(SIZE, SIZE));
    for id in 0..5 {
        let tag = Tag {
            greys: [30.0, 420.0],
            ..tag(
                Family::Tag36h11b2,
                70 * id,
                random.between(24.0, 50.0),
                &mut random,
            )
        };
        let found = detect(
            &draw(&camera, std::slice::from_ref(&tag), 0.8),
            &[tag.family],
        );
        assert_eq!((found.len(), found[0].id), (1, tag.id));
        let worst = errors(&tag, &camera, &found[0])
            .into_iter()
            .fold(0.0, f64::max);
        assert!(worst < 0.06, "{id}: {worst}");
    }
}

#[test]
fn the_squares_of_a_charuco_board_are_found_by_their_markers_whatever_share_those_have() {
    let mut random = Random(32);
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 60.2,
        cy: 59.6,
    };
    let lens = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.001, 0.0, 0.0]).unwrap();
    let camera = Camera {
        lens: Some(lens),
        ..Camera::new(SIZE, SIZE)
    };
    let families = [
        (Family::Charuco4x4With50, 0.5),
        (Family::Charuco5x5With100, 0.72),
        (Family::Charuco6x6With250, 0.8),
        (Family::Charuco7x7With50, 0.75),
    ];
    for (i, (family, share)) in (0..8).zip(families.into_iter().cycle()) {
        let tag = Tag {
            share,
            ..tag(
                family,
                4 * i,
                random.between(26.0, 38.0) / share,
                &mut random,
            )
        };
        let found = detect(&draw(&camera, std::slice::from_ref(&tag), 0.7), &[family]);
        assert_eq!(found.len(), 1, "{family} {}", tag.id);
        assert_eq!(found[0].id, tag.id);
        let errors = errors(&tag, &camera, &found[0]);
        assert!(
            errors.iter().all(|error| *error < 0.04),
            "{family}: {errors:?}"
        );
    }
}

#[test]
fn a_marker_without_a_chessboard_is_no_square_of_one() {
    let (mut random, camera) = (Random(33), Camera::new(SIZE, SIZE));
    let families = [Family::Aruco5x5With100, Family::Charuco5x5With100];
    let mut lone = tag(families[0], 7, 50.0, &mut random);
    lone.margin = 1.0;
    let pixels = draw(&camera, &[lone], 0.7);
    let found = families.map(|family| detect(&pixels, &[family]).len());
    assert_eq!(found, [1, 0]);
}

/// Tilted by 50 degrees, so that edges cross at an angle and errors along x and y are correlated.
#[test]
fn covariances_of_saddle_points_are_those_of_their_errors() {
    let (mut random, camera) = (Random(35), Camera::new(SIZE, SIZE));
    let (mut squared, mut n, mut correlated) = (0.0, 0.0, 0);
    for i in 0..24 {
        let family = [Family::Tag36h11b2, Family::Charuco5x5With100][i % 2];
        let tag = Tag {
            turn_deg: [40.0, 25.0, random.between(10.0, 80.0)],
            ..tag(family, 2, 56.0, &mut random)
        };
        let tag = Tag {
            share: [0.3, 0.6][i % 2],
            ..tag
        };
        let picture = Picture::draw(&camera, std::slice::from_ref(&tag), 128.0).blurred(0.7);
        let found = detect(&picture.pixels(8.0, i as u64), &[family]);
        assert_eq!(found.len(), 1, "{family}");
        for (corner, truth) in tag.corners(&camera).iter().enumerate() {
            let [xx, xy, yy] = found[0].corner_covariance[corner].map(f64::from);
            let [x, y] = [0, 1].map(|axis| f64::from(found[0].corners[corner][axis]) - truth[axis]);
            squared += (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy);
            n += 2.0;
            correlated += usize::from(xy.abs() > 0.1 * (xx * yy).sqrt());
        }
    }
    let mean = squared / n;
    assert!((0.6..1.6).contains(&mean), "{mean}");
    assert!(correlated > 48, "{correlated}");
}

/// A slip of paper before one of its corners.
#[test]
fn a_hidden_corner_is_known_to_be_less_sure_and_leaves_the_others_as_they_are() {
    let (mut random, camera) = (Random(34), Camera::new(SIZE, SIZE));
    for (family, share) in [(Family::Tag36h11b2, 0.3), (Family::Charuco4x4With50, 0.6)] {
        let tag = Tag {
            share,
            turn_deg: [15.0, -10.0, 20.0],
            ..tag(family, 3, 48.0, &mut random)
        };
        let [x, y] = tag.corners(&camera)[1];
        let slip = Tag {
            id: u32::MAX,
            position_m: [
                (x - camera.centre[0]) / 6000.0,
                (y - camera.centre[1]) / 6000.0,
                0.1,
            ],
            size_m: 0.002,
            margin: 0.0,
            ..Tag::new(0)
        };
        let found = detect(&draw(&camera, &[slip, tag.clone()], 0.7), &[family]);
        assert_eq!(found.len(), 1, "{family}");
        let errors = errors(&tag, &camera, &found[0]);
        for corner in [0, 2, 3] {
            assert!(errors[corner] < 0.04 && sigma_px(&found[0], corner) < 0.05);
        }
        let sigma_px = sigma_px(&found[0], 1);
        assert!(
            sigma_px > 0.2 && errors[1] < 3.0 * sigma_px,
            "{family}: {errors:?}"
        );
    }
}

/// As print, glare or sharpening leave them: white lines of 2 to 10 % of a square between all squares.
#[test]
fn squares_that_do_not_touch_have_their_corners_in_the_middle_between_them() {
    let (mut random, camera) = (Random(37), Camera::new(SIZE, SIZE));
    for gap in [0.01, 0.02, 0.03, 0.05] {
        let tag = Tag {
            gap,
            share: 0.75,
            ..tag(Family::Charuco5x5With100, 7, 44.0, &mut random)
        };
        let found = detect(
            &draw(&camera, std::slice::from_ref(&tag), 0.7),
            &[tag.family],
        );
        assert_eq!(found.len(), 1, "{gap}");
        let errors = errors(&tag, &camera, &found[0]);
        for (corner, error) in errors.into_iter().enumerate() {
            let sigma_px = sigma_px(&found[0], corner);
            assert!(sigma_px < 0.1 && error < 0.06, "{gap}: {error} {sigma_px}");
        }
    }
}
