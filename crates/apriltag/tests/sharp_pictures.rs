//! Pictures that no camera takes: every edge falls between two pixels, and there is no noise, as in exported boards and
//! screenshots.

#![allow(clippy::unwrap_used)]

use crate::drawing::detect;
use sextant_apriltag::Family;
use sextant_tag_families::module_is_white;

/// The number of a lone tag.
const ID: u32 = 5;

/// Corners of a tag in edges from its top left one.
const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// A square picture, and the number and corners of each tag in it.
struct Sheet {
    size: usize,
    pixels: Vec<u8>,
    corners: Vec<(u32, [[f64; 2]; 4])>,
}

/// Pixels by the colour at their centres, which is given in units of a module.
fn rasterised(size: usize, module_px: f64, is_white: impl Fn(f64, f64) -> bool) -> Vec<u8> {
    let at = |pixel: usize| (pixel as f64 + 0.5) / module_px;
    let pixels = (0..size * size).map(|i| is_white(at(i % size), at(i / size)));
    pixels.map(|white| if white { 255 } else { 0 }).collect()
}

/// Colour of a tag's printed module; white beside the tag.
fn tag_is_white(family: Family, id: u32, x: f64, y: f64) -> bool {
    let total = f64::from(family.data().total_width);
    let on_tag = (0.0..total).contains(&x) && (0.0..total).contains(&y);
    !on_tag || module_is_white(family, id, x as usize, y as usize)
}

/// A ChArUco board of 4 x 4 squares with a marker of two thirds of a square in each white one.
fn charuco(family: Family, module_px: f64) -> Sheet {
    let marker = f64::from(family.data().border_width);
    let (square, quiet) = (1.5 * marker, 2.0);
    let size = ((4.0 * square + 2.0 * quiet) * module_px).ceil() as usize;
    let mut places = Vec::new();
    for row in 0..4 {
        for column in 0..4 {
            if (row + column) % 2 == 1 {
                places.push([column, row]);
            }
        }
    }
    let is_white = |x: f64, y: f64| {
        let [x, y] = [x - quiet, y - quiet];
        let [column, row] = [x, y].map(|at| (at / square).floor());
        if ![column, row].iter().all(|at| (0.0..4.0).contains(at)) {
            return true;
        }
        let place = [column as usize, row as usize];
        let Some(id) = places.iter().position(|at| *at == place) else {
            return false;
        };
        let data = family.data();
        let ring = f64::from(data.total_width - data.border_width) / 2.0;
        let [x, y] = [x - column * square, y - row * square].map(|at| at - square / 6.0 + ring);
        tag_is_white(family, id as u32, x, y)
    };
    let pixels = rasterised(size, module_px, is_white);
    let corner = |at: f64| (quiet + at * square) * module_px - 0.5;
    let corners = (0..).zip(&places).map(|(id, place)| {
        let [column, row] = place.map(|at| at as f64);
        (
            id,
            SQUARE.map(|[x, y]| [corner(column + x), corner(row + y)]),
        )
    });
    Sheet {
        size,
        corners: corners.collect(),
        pixels,
    }
}

/// A lone tag with two modules of paper around it.
fn lone(family: Family, module_px: f64) -> Sheet {
    const QUIET: f64 = 2.0;
    let data = family.data();
    let [border, total] = [data.border_width, data.total_width].map(f64::from);
    let size = ((total + 2.0 * QUIET) * module_px).ceil() as usize;
    let is_white = |x: f64, y: f64| tag_is_white(family, ID, x - QUIET, y - QUIET);
    let corner = |at: f64| (QUIET + (total - border) / 2.0 + at * border) * module_px - 0.5;
    let corners = SQUARE.map(|[x, y]| [corner(x), corner(y)]);
    Sheet {
        size,
        pixels: rasterised(size, module_px, is_white),
        corners: vec![(ID, corners)],
    }
}

/// Every tag of the sheet is read without a wrong bit, and the corners that it claims to know well are where the
/// picture has them.
fn assert_read(sheet: &Sheet, family: Family, module_px: f64) {
    // Edges that fall within a pixel are drawn at its nearer side.
    let rounding_px = if module_px.fract() == 0.0 { 0.0 } else { 0.71 };
    let found = detect(&sheet.pixels, sheet.size, &[family]);
    let n = sheet.corners.len();
    assert_eq!(found.len(), n, "{family}, {module_px} px a module");
    for (tag, (id, truth)) in found.iter().zip(&sheet.corners) {
        assert_eq!((tag.id, tag.hamming), (*id, 0), "{family}, {module_px} px");
        let corners = tag.corners.iter().zip(truth).zip(tag.corner_covariance);
        for (([x, y], [true_x, true_y]), [xx, _, yy]) in corners {
            let error = (f64::from(*x) - true_x).hypot(f64::from(*y) - true_y);
            let is_visible = xx + yy < 0.01;
            assert!(
                !is_visible || error < rounding_px + 0.05,
                "{family} {id}, {module_px} px a module: {error} px off"
            );
        }
    }
}

#[test]
fn tags_are_read_at_every_scale() {
    let families = Family::ALL.into_iter();
    for family in families.filter(|family| family.data().board.is_none()) {
        for module_px in [2.0, 2.5, 3.0, 3.3, 4.0, 5.0, 7.7, 8.0, 16.0, 40.0] {
            assert_read(&lone(family, module_px), family, module_px);
        }
    }
}

#[test]
fn charuco_boards_are_read_at_every_scale() {
    let families = [
        Family::Charuco4x4With50,
        Family::Charuco5x5With100,
        Family::Charuco6x6With250,
    ];
    for family in families {
        for module_px in [2.0, 2.5, 3.3, 4.0, 6.0, 7.7, 8.0, 12.0, 16.0] {
            assert_read(&charuco(family, module_px), family, module_px);
        }
    }
}
