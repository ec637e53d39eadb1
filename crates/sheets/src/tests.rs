//! What is printed, read back from the PDF itself, drawn as pixels and looked at by the detector.

use super::*;
use nalgebra::Vector2;
use sextant_apriltag::{Detector, Image, Options};
use sextant_calibrator::PrintedGrid;
use sextant_geometry::tag_corners_in_tag;
use sextant_site_files::{AprilGrid, CharucoBoard, Chessboard, UpperLeft};
use std::collections::BTreeMap;

/// Pixels a millimetre.
const SCALE: f64 = 8.0;

struct Picture {
    width: usize,
    height: usize,
    white: Vec<f64>,
}

impl Picture {
    fn new(size: [f64; 2]) -> Self {
        let [width, height] = size.map(|mm| (mm * SCALE).ceil() as usize);
        Self {
            width,
            height,
            white: vec![1.0; width * height],
        }
    }

    /// Takes away the white of each pixel as far as the rectangle covers it.
    fn blacken(&mut self, [x, y, width, height]: [f64; 4]) {
        let bottom = self.height as f64;
        let (left, right) = (x * SCALE, (x + width) * SCALE);
        let (top, low) = (bottom - (y + height) * SCALE, bottom - y * SCALE);
        let overlap = |pixel: usize, from: f64, to: f64| {
            (to.min(pixel as f64 + 1.0) - from.max(pixel as f64)).clamp(0.0, 1.0)
        };
        for row in top as usize..=(low as usize).min(self.height - 1) {
            for column in left as usize..=(right as usize).min(self.width - 1) {
                let covered = overlap(row, top, low) * overlap(column, left, right);
                self.white[row * self.width + column] -= covered;
            }
        }
    }

    /// Corners of every tag seen, millimetres from the lower left corner of the paper, by id.
    fn tags(&self, family: Family) -> BTreeMap<u32, [[f64; 2]; 4]> {
        let pixels: Vec<u8> = self
            .white
            .iter()
            .map(|w| (w * 255.0).round() as u8)
            .collect();
        let image = Image::new(&pixels, self.width, self.height, self.width).unwrap();
        let options = Options {
            families: vec![family],
            ..Options::default()
        };
        let mut detector = Detector::new(options).unwrap();
        let place = |[x, y]: [f32; 2]| {
            [
                (f64::from(x) + 0.5) / SCALE,
                (self.height as f64 - 0.5 - f64::from(y)) / SCALE,
            ]
        };
        let seen = detector.detect(&image);
        seen.iter()
            .map(|tag| (tag.id, tag.corners.map(place)))
            .collect()
    }
}

/// The pages of a PDF as their black rectangles in millimetres.
fn pictures(pdf: &[u8]) -> Vec<Picture> {
    let text = std::str::from_utf8(pdf).unwrap();
    let numbers = |text: &str| -> Vec<f64> {
        text.split_whitespace()
            .filter_map(|word| word.trim_end_matches(']').parse().ok())
            .collect()
    };
    let sizes = text.split("/MediaBox [").skip(1);
    let contents = text.split("stream\n").skip(1).step_by(2);
    let pages = sizes.zip(contents).map(|(page, content)| {
        let size = numbers(page.split(']').next().unwrap());
        let (matrix, content) = content.split_once(" cm\n").unwrap();
        let points_per_mm = numbers(matrix)[0];
        let mut picture = Picture::new([size[2] / points_per_mm, size[3] / points_per_mm]);
        for line in content.lines().filter(|line| line.ends_with(" re")) {
            let area: [f64; 4] = numbers(line).try_into().unwrap();
            // In points, and from them in millimetres as the printer has them.
            picture.blacken(area.map(|mm| mm * points_per_mm * 25.4 / 72.0));
        }
        picture
    });
    pages.collect()
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn grid() -> PrintedGrid {
    PrintedGrid {
        columns: 5,
        rows: 6,
        size_m: 0.028,
        family: Family::Tag36h11,
        first: 0,
    }
}

#[test]
fn every_tag_of_a_board_is_seen_upright_where_its_object_file_says() {
    for paper in [Paper::A4, Paper::Letter] {
        let printed = board(&grid(), "board", paper).unwrap();
        let pictures = pictures(&pdf::pdf("", &printed.pages));
        let seen = pictures[0].tags(Family::Tag36h11);
        assert_eq!(seen.len(), 30);
        let middle = |id: u32| {
            seen[&id]
                .iter()
                .fold([0.0; 2], |m, c| [m[0] + c[0] / 4.0, m[1] + c[1] / 4.0])
        };
        // The frame's origin is the middle of the grid.
        let (first, last) = (middle(0), middle(29));
        let origin = [(first[0] + last[0]) / 2.0, (first[1] + last[1]) / 2.0];
        for tag in printed.model.tags() {
            let corners = tag_corners_in_tag(tag.size_m);
            for (corner, seen) in corners.iter().zip(seen[&tag.tag.id]) {
                let on_board = tag.object_from_tag.unwrap() * corner;
                let expected = [origin[0] + on_board.x * 1e3, origin[1] + on_board.y * 1e3];
                assert!(apart(expected, seen) < 0.02, "{paper:?} {}", tag.tag.id);
            }
        }
    }
}

#[test]
fn single_tags_of_every_border_are_seen_in_their_size_on_all_pages() {
    for (name, ids) in [
        ("tag36h11", 0..=19),
        ("tagStandard41h12", 5..=8),
        ("aruco4x4-50", 3..=3),
    ] {
        let family = name.parse().unwrap();
        let ids: Vec<u32> = ids.collect();
        let printed = tags(family, &ids, 0.03, "tags", Paper::A4).unwrap();
        let pictures = pictures(&pdf::pdf("", &printed.pages));
        let seen: BTreeMap<u32, [[f64; 2]; 4]> = pictures
            .iter()
            .flat_map(|picture| picture.tags(family))
            .collect();
        let expected: Vec<u32> = printed.model.tags().iter().map(|tag| tag.tag.id).collect();
        assert_eq!(seen.keys().copied().collect::<Vec<_>>(), expected, "{name}");
        for [top_left, top_right, bottom_right, _] in seen.into_values() {
            assert!((apart(top_left, top_right) - 30.0).abs() < 0.02);
            assert!((apart(top_right, bottom_right) - 30.0).abs() < 0.02);
            assert!(top_left[1] > bottom_right[1] && top_left[0] < top_right[0]);
        }
    }
}

/// Corners as the detector sees them where the object file says, up to where the board lies on the paper.
fn assert_seen_as_described(printed: &PrintJob, family: Family) {
    let seen = pictures(&pdf::pdf("", &printed.pages))[0].tags(family);
    assert_eq!(seen.len(), printed.model.tags().len());
    let described = |tag: &ObjectTag| {
        let corners = tag_corners_in_tag(tag.size_m);
        corners.map(|corner| (tag.object_from_tag.unwrap() * corner).coords.xy() * 1e3)
    };
    // A board whose y runs down is seen from its back otherwise.
    let first = &printed.model.tags()[0];
    let is_upright = first.object_from_tag.unwrap().rotation.w.abs() > 0.5;
    let up = if is_upright { 1.0 } else { -1.0 };
    let origin = described(first)[2];
    let all = || printed.model.tags().iter().flat_map(described);
    let (low, high) = all().fold((origin, origin), |(low, high), at| {
        (low.inf(&at), high.sup(&at))
    });
    // At the rim of a chessboard no saddle point shows: corners are extrapolated.
    let most = |place: &Vector2<f64>| {
        let inside = (place - low).min() > 0.1 && (high - place).min() > 0.1;
        let shows = inside || family == Family::Tag36h11b2;
        if shows { 0.03 } else { 0.4 }
    };
    for tag in printed.model.tags() {
        for (corner, place) in described(tag).iter().enumerate() {
            let from = seen[&first.tag.id][2];
            let expected = [
                from[0] + place.x - origin.x,
                from[1] + up * (place.y - origin.y),
            ];
            let away = apart(expected, seen[&tag.tag.id][corner]);
            assert!(away < most(place), "{} {corner}: {away} mm", tag.tag);
        }
    }
}

#[test]
fn an_aprilgrid_is_seen_as_its_object_file_says() {
    for (paper, spacing) in [(Paper::A4, 0.3), (Paper::Letter, 0.2)] {
        let arguments = AprilGrid {
            columns: 6,
            rows: 6,
            size_m: 0.022,
            spacing,
            first: 4,
        };
        let printed = aprilgrid(&arguments, "grid", paper).unwrap();
        assert_seen_as_described(&printed, Family::Tag36h11b2);
    }
}

#[test]
fn a_charuco_board_is_seen_as_its_object_file_says() {
    for (columns, marker, name) in [(5, 0.75, "charuco5x5-100"), (4, 0.6, "charuco4x4-50")] {
        let arguments = CharucoBoard {
            columns,
            rows: 6,
            square_m: 0.033,
            marker_m: 0.033 * marker,
            family: name.parse().unwrap(),
            first: 0,
            upper_left: UpperLeft::Black,
        };
        let printed = charuco(&arguments, "board", Paper::A4).unwrap();
        assert_seen_as_described(&printed, arguments.family);
    }
}

#[test]
fn boards_that_are_none_are_refused_with_the_reason() {
    let mut arguments = grid();
    arguments.family = Family::Tag36h11b2;
    let error = board(&arguments, "board", Paper::A4).err().unwrap();
    assert!(matches!(error, SheetError::OfBoard { .. }), "{error}");
    let board = CharucoBoard {
        columns: 5,
        rows: 7,
        square_m: 0.033,
        marker_m: 0.033 * 0.95,
        family: Family::Charuco4x4With50,
        first: 0,
        upper_left: UpperLeft::Black,
    };
    let refused = |arguments: &_| {
        let printed = charuco(arguments, "board", Paper::A4);
        printed.err().unwrap().to_string()
    };
    assert!(refused(&board).contains("markers of 0.95 of a square"));
    let large = CharucoBoard {
        square_m: 0.05,
        marker_m: 0.05 * 0.75,
        ..board
    };
    assert!(refused(&large).contains("but A4 leaves"));
}

#[test]
fn each_face_of_a_cubes_net_carries_its_tag() {
    let arguments = Cube {
        edge_m: 0.06,
        size_m: 0.04,
        family: Family::Tag36h11,
        first: 10,
    };
    for paper in [Paper::A4, Paper::Letter] {
        let printed = cube(&arguments, "cube", paper).unwrap();
        let seen = pictures(&pdf::pdf("", &printed.pages))[0].tags(Family::Tag36h11);
        assert_eq!(
            seen.keys().copied().collect::<Vec<_>>(),
            [10, 11, 12, 13, 14, 15]
        );
        // Rows and columns of the net, by a tag's top left corner: up, left, right and down of the face +z.
        let from_front = |id: u32| {
            let (front, face) = (seen[&10][0], seen[&id][0]);
            [face[0] - front[0], face[1] - front[1]].map(|mm| (mm / 60.0 * 100.0).round() / 100.0)
        };
        let at = [11, 12, 13, 14, 15].map(from_front);
        assert_eq!(
            at,
            [
                [0.0, 1.0],
                [-1.0, 0.0],
                [1.0, 0.0],
                [0.0, -1.0],
                [0.0, -2.0]
            ]
        );
    }
}

#[test]
fn a_ruler_is_as_long_as_it_says() {
    let mut sheet = sheet::Sheet::new(Paper::A4);
    sheet.ruler_right([10.0, 10.0]);
    let file = pdf::pdf("", &[sheet.into_page()]);
    let text = String::from_utf8(file).unwrap();
    let columns: Vec<f64> = text
        .lines()
        .filter(|line| line.ends_with(" m"))
        .map(|line| line.split(' ').next().unwrap().parse().unwrap())
        .collect();
    // The line itself, then a tick every millimetre.
    assert_eq!(columns.len(), 102);
    assert_eq!((columns[1], columns[101]), (10.0, 110.0));
    assert!(text.contains("2.8346456693 0 0 2.8346456693 0 0 cm"));
}

#[test]
fn a_measured_size_scales_the_whole_object() {
    let printed = board(&grid(), "board", Paper::A4).unwrap();
    let measured = printed.as_measured(0.0294).unwrap();
    for (was, is) in printed.model.tags().iter().zip(measured.tags()) {
        assert!((is.size_m / was.size_m - 1.05).abs() < 1e-9);
        let place = |tag: &ObjectTag| tag.object_from_tag.unwrap().translation.vector;
        assert!((place(is) - place(was) * 1.05).norm() < 1e-9);
    }
    assert!(printed.as_measured(28.0).is_err());
    assert!(printed.as_measured(f64::NAN).is_err());
}

#[test]
fn what_does_not_fit_or_does_not_exist_is_refused_with_what_would() {
    let refused = |change: fn(&mut PrintedGrid)| {
        let mut arguments = grid();
        change(&mut arguments);
        let printed = board(&arguments, "board", Paper::A4);
        printed.err().unwrap().to_string()
    };
    assert!(refused(|a| a.size_m = 0.05).contains("the grid is"));
    assert!(refused(|a| a.size_m = f64::NAN).contains("edge of the black square"));
    assert!(refused(|a| a.first = 580).contains("has no tag 587; its ids are 0 to 586"));
    let large = Cube {
        edge_m: 0.08,
        size_m: 0.04,
        family: Family::Tag36h11,
        first: 0,
    };
    let error = cube(&large, "cube", Paper::A4).err().unwrap();
    assert!(
        matches!(error, SheetError::NetTooLarge { largest, .. } if largest.floor() == 63.0),
        "{error}"
    );
}

#[test]
fn a_chessboard_is_found_where_its_object_file_says() {
    let arguments = Chessboard {
        columns: 6,
        rows: 9,
        square_m: 0.022,
    };
    for paper in [Paper::A4, Paper::Letter] {
        let printed = chessboard(&arguments, "board", paper).unwrap();
        let picture = &pictures(&pdf::pdf("", &printed.pages))[0];
        let pixels: Vec<u8> = picture
            .white
            .iter()
            .map(|w| (w * 255.0).round() as u8)
            .collect();
        let image = Image::new(&pixels, picture.width, picture.height, picture.width).unwrap();
        let shape = sextant_apriltag::BoardShape {
            columns: 6,
            rows: 9,
        };
        let view = sextant_apriltag::find_chessboard(&image, shape).unwrap();
        assert_eq!(view.size, [6, 9]);
        let (first, last) = (&view.squares[0], &view.squares[view.squares.len() - 1]);
        assert_eq!(first.id, 0);
        let [across, down] =
            [0, 1].map(|i| f64::from(last.corners[2][i] - first.corners[0][i]) / SCALE);
        assert!(
            apart([across, down], [5.0 * 22.0, 8.0 * 22.0]) < 0.05,
            "{across} {down}"
        );
        assert_eq!(printed.model.tags().len(), 40);
    }
}
