//! The detector on pictures of which everything is known.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use nalgebra::{Matrix2, SMatrix, SVector};
use sextant_apriltag::{Detection, Detector, Family, Image, Options, Refinement};
use sextant_geometry::CORNER_PAIRS;

fn camera() -> Camera {
    Camera::new(200, 150)
}

fn detect(pixels: &[u8], camera: &Camera) -> Vec<Detection> {
    detect_with(Options::default(), pixels, camera)
}

fn detect_with(options: Options, pixels: &[u8], camera: &Camera) -> Vec<Detection> {
    let image = Image::new(pixels, camera.width, camera.height, camera.width).unwrap();
    Detector::new(options).unwrap().detect(&image).to_vec()
}

fn ids(found: &[Detection]) -> Vec<u32> {
    found.iter().map(|found| found.id).collect()
}

fn draw(tag: &Tag) -> Vec<u8> {
    Picture::draw(&camera(), std::slice::from_ref(tag), 128.0)
        .blurred(0.5)
        .pixels(0.0, 1)
}

/// Greatest distance of a corner from the truth.
fn worst_error(detection: &Detection, tag: &Tag, camera: &Camera) -> f64 {
    let truth = tag.corners(camera);
    let errors = detection
        .corners
        .iter()
        .zip(truth)
        .map(|(c, t)| (f64::from(c[0]) - t[0]).hypot(f64::from(c[1]) - t[1]));
    errors.fold(0.0, f64::max)
}

#[test]
fn corners_run_clockwise_from_the_upright_tags_top_left() {
    for turn in [0.0, 31.0, 90.0, 180.0, 200.0, 270.0] {
        let tag = Tag {
            turn_deg: [12.0, -20.0, turn],
            ..Tag::new(17)
        };
        let found = detect(&draw(&tag), &camera());
        assert_eq!(found.len(), 1, "turned by {turn}");
        assert_eq!((found[0].id, found[0].hamming), (17, 0));
        let error = worst_error(&found[0], &tag, &camera());
        assert!(error < 0.02, "turned by {turn}: {error} px");
    }
}

#[test]
fn corners_are_found_from_the_edges_alone() {
    let tag = Tag {
        turn_deg: [12.0, -20.0, 31.0],
        ..Tag::new(17)
    };
    let options = Options {
        refinement: Refinement::Edges,
        ..Options::default()
    };
    let found = detect_with(options, &draw(&tag), &camera());
    assert_eq!(found[0].refinement, Refinement::Edges);
    assert!(worst_error(&found[0], &tag, &camera()) < 0.1);
}

#[test]
fn tags_are_read_however_large_sharp_and_clean_they_are() {
    let camera = Camera::new(320, 320);
    for (edge_px, turn_deg, noise) in [(150.0, 40.0, 2.0), (260.0, 0.0, 0.0)] {
        let tag = Tag::new(17);
        let tag = Tag {
            turn_deg: [5.0, 5.0, turn_deg],
            position_m: [0.0, 0.0, tag.size_m * camera.focal / edge_px],
            ..tag
        };
        let picture = Picture::draw(&camera, std::slice::from_ref(&tag), 200.0);
        let found = detect(&picture.blurred(0.3).pixels(noise, 3), &camera);
        assert_eq!(found.len(), 1, "{edge_px} px, turned by {turn_deg}");
    }
}

#[test]
fn tags_are_read_near_and_far_and_from_the_side() {
    for (distance_m, tilt_deg) in [
        (0.25, 0.0),
        (0.3, 60.0),
        (0.5, 45.0),
        (0.8, 55.0),
        (1.2, 30.0),
        (2.0, 10.0),
    ] {
        let tag = Tag {
            position_m: [0.02 * distance_m, -0.03 * distance_m, distance_m],
            turn_deg: [tilt_deg, 10.0, 25.0],
            ..Tag::new(401)
        };
        let found = detect(&draw(&tag), &camera());
        assert_eq!(found.len(), 1, "{distance_m} m, {tilt_deg} degrees");
        assert_eq!(found[0].id, 401);
        assert!(
            worst_error(&found[0], &tag, &camera()) < 0.1,
            "{distance_m} m, {tilt_deg} degrees"
        );
    }
}

#[test]
fn two_wrong_modules_are_corrected_and_three_are_not() {
    let wrong = [(3, 3), (5, 7), (7, 2)];
    for n in 0..=3 {
        let tag = Tag {
            wrong: wrong[..n].to_vec(),
            ..Tag::new(233)
        };
        let found = detect(&draw(&tag), &camera());
        assert_eq!(found.len(), usize::from(n <= 2), "{n} wrong modules");
        assert!(
            found
                .iter()
                .all(|detection| detection.id == 233 && usize::from(detection.hamming) == n)
        );
    }
}

#[test]
fn mirrored_and_inverted_tags_are_no_tags() {
    let camera = camera();
    let pixels = draw(&Tag {
        turn_deg: [0.0, 20.0, 5.0],
        ..Tag::new(5)
    });
    let mirrored: Vec<u8> = pixels
        .chunks(camera.width)
        .flat_map(|row| row.iter().rev().copied())
        .collect();
    let inverted: Vec<u8> = pixels.iter().map(|grey| 255 - grey).collect();
    assert_eq!(detect(&pixels, &camera).len(), 1);
    assert_eq!(detect(&mirrored, &camera), []);
    assert_eq!(detect(&inverted, &camera), []);
}

#[test]
fn a_shaded_tag_beside_a_lit_one_is_read() {
    let lit = Tag {
        position_m: [-0.025, 0.0, 0.6],
        turn_deg: [0.0, 0.0, 5.0],
        greys: [50.0, 250.0],
        ..Tag::new(1)
    };
    let shaded = Tag {
        position_m: [0.03, 0.0, 0.6],
        greys: [20.0, 60.0],
        margin: 0.0,
        ..lit.clone()
    };
    let shaded = Tag { id: 2, ..shaded };
    let pixels = Picture::draw(&camera(), &[shaded, lit], 230.0)
        .blurred(0.5)
        .pixels(1.0, 3);
    let ids: Vec<u32> = detect(&pixels, &camera())
        .iter()
        .map(|detection| detection.id)
        .collect();
    assert_eq!(ids, [1, 2]);
}

#[test]
fn a_small_tag_on_a_dark_body_before_a_bright_wall_is_read() {
    for turn in 0..18 {
        for tilt_deg in [0.0, 30.0, 45.0] {
            let tag = Tag {
                position_m: [0.001 * f64::from(turn), 0.0, 1.2],
                turn_deg: [tilt_deg, 0.0, 10.0 * f64::from(turn)],
                greys: [7.0, 95.0],
                margin: 0.0,
                ..Tag::new(3)
            };
            let body = Tag {
                size_m: 0.052,
                greys: [38.0; 2],
                ..tag.clone()
            };
            let pixels = Picture::draw(&camera(), &[tag, body], 190.0)
                .blurred(0.5)
                .pixels(1.5, 3);
            let ids = detect(&pixels, &camera()).len();
            assert_eq!(ids, 1, "turned by {turn}0, tilted by {tilt_deg} degrees");
        }
    }
}

#[test]
fn a_small_tag_out_of_focus_is_read() {
    for turn in 0..18 {
        let tag = Tag {
            position_m: [0.001 * f64::from(turn), 0.0, 0.80],
            turn_deg: [20.0, 0.0, 10.0 * f64::from(turn)],
            ..Tag::new(56)
        };
        let pixels = Picture::draw(&camera(), &[tag], 120.0)
            .blurred(2.0)
            .pixels(1.0, 3);
        let ids = detect(&pixels, &camera()).len();
        assert_eq!(ids, 1, "turned by {turn}0 degrees");
    }
}

/// Dim light, as a camera with little noise shows it: black 10, white 22 to 28.
#[test]
fn dim_tags_are_read_where_they_stand_out_of_the_noise() {
    let mut random = Random(36);
    for i in 0..24 {
        let tag = Tag {
            position_m: [0.0, 0.0, 0.04 * 600.0 / random.between(24.0, 45.0)],
            turn_deg: [
                20.0,
                random.between(-30.0, 30.0),
                random.between(0.0, 360.0),
            ],
            greys: [10.0, random.between(22.0, 28.0)],
            ..Tag::new(i)
        };
        let picture = Picture::draw(&camera(), &[tag], 15.0).blurred(0.6);
        let found = detect(&picture.pixels(1.2, u64::from(i)), &camera());
        assert_eq!(ids(&found), [i]);
    }
}

#[test]
fn families_of_every_layout_are_read() {
    for family in [
        Family::Tag36h11,
        Family::Tag25h9,
        Family::Tag16h5,
        Family::TagStandard41h12,
        Family::Aruco5x5With100,
    ] {
        let tag = Tag {
            family,
            turn_deg: [15.0, 20.0, 100.0],
            margin: 2.0,
            ..Tag::new(21)
        };
        let options = Options {
            families: vec![family],
            ..Options::default()
        };
        let found = detect_with(options, &draw(&tag), &camera());
        assert_eq!(found.len(), 1, "{family}");
        assert_eq!(
            (found[0].family, found[0].id, found[0].hamming),
            (family, 21, 0)
        );
        assert!(worst_error(&found[0], &tag, &camera()) < 0.03, "{family}");
    }
    let both = Options {
        families: vec![Family::Tag36h11, Family::TagStandard41h12],
        ..Options::default()
    };
    assert_eq!(
        detect_with(both.clone(), &draw(&Tag::new(3)), &camera()).len(),
        1
    );
    let standard = Tag {
        family: Family::TagStandard41h12,
        ..Tag::new(3)
    };
    assert_eq!(detect_with(both, &draw(&standard), &camera()).len(), 1);
}

/// Now and then a tag of 8x8 modules shows a code word of 6x6 when it is read as one.
#[test]
fn tags_of_more_modules_are_not_read_as_ones_of_few() {
    let options = Options {
        families: vec![Family::Tag16h5],
        ..Options::default()
    };
    for id in 100..125 {
        let tag = Tag {
            turn_deg: [15.0, 20.0, 10.0],
            ..Tag::new(id)
        };
        let found = detect_with(options.clone(), &draw(&tag), &camera());
        assert!(found.is_empty(), "{id}: {found:?}");
    }
}

#[test]
fn detections_are_sorted_by_id_and_place() {
    let at = |id, x, y| Tag {
        position_m: [x, y, 0.6],
        ..Tag::new(id)
    };
    let tags = [
        at(9, -0.05, 0.04),
        at(3, 0.05, 0.04),
        at(9, 0.04, -0.04),
        at(3, -0.05, -0.045),
    ];
    let pixels = Picture::draw(&camera(), &tags, 128.0).pixels(0.0, 1);
    let found = detect(&pixels, &camera());
    let order: Vec<(u32, bool)> = found
        .iter()
        .map(|detection| (detection.id, detection.centre()[1] > 75.0))
        .collect();
    assert_eq!(order, [(3, false), (3, true), (9, false), (9, true)]);
}

#[test]
fn a_stride_changes_nothing() {
    let camera = camera();
    let pixels = draw(&Tag::new(77));
    let stride = camera.width + 29;
    let mut padded = vec![99; stride * camera.height];
    for (row, padded) in pixels.chunks(camera.width).zip(padded.chunks_mut(stride)) {
        padded[..camera.width].copy_from_slice(row);
    }
    let image = Image::new(&padded, camera.width, camera.height, stride).unwrap();
    let mut detector = Detector::new(Options::default()).unwrap();
    assert_eq!(detector.detect(&image), detect(&pixels, &camera));
}

/// Covariance of x and y of each corner in turn.
fn joint_covariance(found: &Detection) -> SMatrix<f64, 8, 8> {
    let mut joint = SMatrix::<f64, 8, 8>::zeros();
    for (corner, [xx, xy, yy]) in found.corner_covariance.into_iter().enumerate() {
        let own = Matrix2::new(xx, xy, xy, yy).cast();
        joint
            .fixed_view_mut::<2, 2>(2 * corner, 2 * corner)
            .copy_from(&own);
    }
    for ([a, b], cross) in CORNER_PAIRS.into_iter().zip(found.corner_cross_covariance) {
        let cross: Matrix2<f64> = Matrix2::from_row_slice(&cross).cast();
        joint.fixed_view_mut::<2, 2>(2 * a, 2 * b).copy_from(&cross);
        joint
            .fixed_view_mut::<2, 2>(2 * b, 2 * a)
            .copy_from(&cross.transpose());
    }
    joint
}

/// Over many drawn tags: squared errors of all corners per degree of freedom, of the tag's place and of its turn in the
/// image, against what the joint covariance says of each.
fn normalised_errors() -> [f64; 3] {
    let (camera, mut random) = (Camera::new(120, 112), Random(7));
    let mut sums = [0.0; 3];
    const TRIALS: u32 = 60;
    for trial in 0..TRIALS {
        let tag = Tag {
            position_m: [
                random.between(-0.01, 0.01),
                random.between(-0.01, 0.01),
                random.between(0.4, 1.0),
            ],
            turn_deg: [
                random.between(-45.0, 45.0),
                random.between(-45.0, 45.0),
                random.between(0.0, 360.0),
            ],
            ..Tag::new(trial * 9)
        };
        let picture = Picture::draw(&camera, std::slice::from_ref(&tag), 128.0).blurred(0.6);
        let pixels = picture.pixels(2.0, u64::from(trial) + 1);
        let found = detect(&pixels, &camera);
        assert_eq!(found.len(), 1, "trial {trial}");
        let (seen, truth) = (found[0].corners, tag.corners(&camera));
        let error = SVector::from_fn(|i, _| f64::from(seen[i / 2][i % 2]) - truth[i / 2][i % 2]);
        let middle = found[0].centre();
        let turn = SVector::from_fn(|i, _| match i % 2 {
            0 => f64::from(middle[1] - seen[i / 2][1]),
            _ => f64::from(seen[i / 2][0] - middle[0]),
        });
        let place = |axis: usize| SVector::from_fn(|i, _| f64::from(u8::from(i % 2 == axis)));
        let joint = joint_covariance(&found[0]);
        let along = |what: SVector<f64, 8>| what.dot(&error).powi(2) / what.dot(&(joint * what));
        let all = error.dot(&(joint.cholesky().unwrap().solve(&error))) / 8.0;
        let of_place = 0.5 * (along(place(0)) + along(place(1)));
        for (sum, one) in sums.iter_mut().zip([all, of_place, along(turn)]) {
            *sum += one;
        }
    }
    sums.map(|sum| sum / f64::from(TRIALS))
}

#[test]
fn stated_covariances_are_what_errors_are() {
    let errors = normalised_errors();
    assert!(
        errors.iter().all(|one| (0.6..1.6).contains(one)),
        "{errors:?}"
    );
}

#[test]
fn noise_and_plain_images_hold_no_tags() {
    let mut random = Random(99);
    for (width, height) in [(16, 16), (17, 33), (640, 480), (641, 31), (64, 2000)] {
        let camera = Camera::new(width, height);
        for (low, high) in [(0.0, 0.0), (0.0, 255.0), (100.0, 160.0), (255.0, 255.0)] {
            let pixels: Vec<u8> = (0..width * height)
                .map(|_| random.between(low, high) as u8)
                .collect();
            assert_eq!(
                detect(&pixels, &camera),
                [],
                "{width}x{height} {low}..{high}"
            );
        }
    }
}

#[test]
fn large_images_of_any_shape_are_taken() {
    for (width, height) in [(3_024, 4_032), (11_648, 8_736), (Image::MAX_SIZE, 800)] {
        takes_an_image_of(width, height);
    }
}

fn takes_an_image_of(width: usize, height: usize) {
    let mut pixels = vec![128; width * height];
    let small = camera();
    let drawn = draw(&Tag::new(8));
    for (y, row) in drawn.chunks(small.width).enumerate() {
        let at = (height - small.height + y) * width + width - small.width;
        pixels[at..at + small.width].copy_from_slice(row);
    }
    let found = detect(&pixels, &Camera::new(width, height));
    let alone = detect(&drawn, &small);
    assert_eq!(found.len(), 1);
    for (corner, expected) in found[0].corners.iter().zip(alone[0].corners) {
        let (dx, dy) = ((width - small.width) as f32, (height - small.height) as f32);
        assert!(
            (corner[0] - dx - expected[0]).abs() < 0.01
                && (corner[1] - dy - expected[1]).abs() < 0.01
        );
    }
}

/// Prints whose black is brighter than their white, in bright and in dim pictures.
#[test]
fn inverted_prints_are_read_on_demand_with_corners_as_exact() {
    let tag = |greys| Tag {
        turn_deg: [12.0, -20.0, 31.0],
        greys,
        ..Tag::new(17)
    };
    for (dark, bright) in [(30.0, 220.0), (12.0, 28.0)] {
        let detected = |inverted, greys| {
            let picture = Picture::draw(&camera(), &[tag(greys)], (dark + bright) / 2.0);
            let options = Options {
                inverted,
                ..Options::default()
            };
            detect_with(options, &picture.blurred(0.5).pixels(0.5, 1), &camera())
        };
        let (inverted, ordinary) = ([bright, dark], [dark, bright]);
        let found = [detected(true, inverted), detected(false, ordinary)];
        assert_eq!(found.each_ref().map(|found| ids(found)), [[17], [17]]);
        let [error, usual] = found.map(|found| worst_error(&found[0], &tag(ordinary), &camera()));
        assert!(error < 1.5 * usual + 0.01, "{error} px, else {usual} px");
        assert!(detected(false, inverted).is_empty());
    }
}
