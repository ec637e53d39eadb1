//! Plain chessboards: their inner corners where they are, in the right columns and rows.

#![allow(clippy::unwrap_used)]

use crate::drawing::Random;
use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};
use sextant_apriltag::{BoardShape, ChessboardView, Extent, Family, Image, find_chessboard};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_tag_families::chessboard_place;
use std::collections::BTreeMap;

const SIZE: [usize; 2] = [320, 240];
const SHAPE: BoardShape = BoardShape {
    columns: 7,
    rows: 6,
};
/// Rays of a pixel along either axis.
const RAYS: usize = 9;

fn numbers(focal: f64) -> Intrinsics {
    Intrinsics {
        fx: focal,
        fy: focal,
        cx: 161.3,
        cy: 118.8,
    }
}

fn plain_lens() -> Lens {
    Lens::brown_conrady(numbers(300.0), [-0.2, 0.05, 0.0005, -0.0003, 0.0]).unwrap()
}

fn fisheye_lens() -> Lens {
    Lens::kannala_brandt(numbers(110.0), [0.02, -0.01, 0.004, -0.001]).unwrap()
}

/// A board of squares with an edge of 1 before a camera. Its origin is the first inner corner.
struct Scene {
    lens: Lens,
    shape: BoardShape,
    camera_from_board: Pose,
    blur_px: f64,
}

impl Scene {
    /// The middle of the board at a depth, tilted about an axis and turned about the optical axis, degrees.
    fn new(lens: Lens, depth: f64, tilt_deg: f64, turn_deg: f64) -> Self {
        let shape = SHAPE;
        let tilt = Vector3::new(0.8, 0.6, 0.0) * tilt_deg.to_radians();
        let turn = Vector3::z() * turn_deg.to_radians();
        let rotation =
            UnitQuaternion::from_scaled_axis(tilt) * UnitQuaternion::from_scaled_axis(turn);
        let [columns, rows] = [shape.columns, shape.rows].map(f64::from);
        let middle = Vector3::new((columns - 1.0) / 2.0, (rows - 1.0) / 2.0, 0.0);
        let place = Vector3::new(0.3, -0.2, depth) - rotation * middle;
        let camera_from_board = Pose::from_parts(place.into(), rotation);
        Self {
            lens,
            shape,
            camera_from_board,
            blur_px: 0.6,
        }
    }

    fn corner(&self, [column, row]: [u16; 2]) -> Point2<f64> {
        let on_board = Point3::new(f64::from(column), f64::from(row), 0.0);
        self.lens
            .project(&(self.camera_from_board * on_board))
            .unwrap()
    }

    /// Grey where a ray meets the board, its paper or the wall behind it.
    fn grey(&self, pixel: Point2<f64>) -> f64 {
        const WALL: f64 = 110.0;
        let Ok(ray) = self.lens.unproject(&pixel) else {
            return WALL;
        };
        let board_from_camera = self.camera_from_board.inverse();
        let (eye, way) = (
            board_from_camera.translation.vector,
            board_from_camera.rotation * ray,
        );
        let times = -eye.z / way.z;
        let [x, y] = [0, 1].map(|axis| eye[axis] + times * way[axis]);
        let [columns, rows] = [self.shape.columns, self.shape.rows].map(f64::from);
        let within =
            |by: f64| (-by..columns - 1.0 + by).contains(&x) && (-by..rows - 1.0 + by).contains(&y);
        match () {
            () if times.is_nan() || times <= 0.0 || !within(2.0) => WALL,
            () if !within(1.0) => 220.0,
            () if (x.floor() + y.floor()).rem_euclid(2.0) == 0.0 => 35.0,
            () => 220.0,
        }
    }

    fn draw(&self, noise: f64) -> Vec<u8> {
        // Rays over the point spread function, weighted by it.
        let half = (RAYS / 2) as f64;
        let offset = |ray: usize| (ray as f64 - half) / half * 2.5 * self.blur_px;
        let weight = |by: f64| (-0.5 * (by / self.blur_px).powi(2)).exp();
        let total: f64 = (0..RAYS).map(|ray| weight(offset(ray))).sum();
        let mut random = Random(77);
        let mut pixels = Vec::new();
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let mut sum = 0.0;
                for ray in 0..RAYS * RAYS {
                    let [right, down] = [ray % RAYS, ray / RAYS].map(offset);
                    let at = Point2::new(x as f64 + right, y as f64 + down);
                    sum += weight(right) * weight(down) * self.grey(at);
                }
                let grey = sum / (total * total) + noise * random.normal();
                pixels.push(grey.round().clamp(0.0, 255.0) as u8);
            }
        }
        pixels
    }
}

fn find(pixels: &[u8], shape: BoardShape) -> Option<ChessboardView> {
    let image = Image::new(pixels, SIZE[0], SIZE[1], SIZE[0]).unwrap();
    find_chessboard(&image, shape)
}

/// Corners by column and row. Squares that share a corner must agree on it.
fn corners(view: &ChessboardView) -> BTreeMap<[u16; 2], [f32; 2]> {
    let mut corners = BTreeMap::new();
    for square in &view.squares {
        assert_eq!(square.family, Family::Chessboard);
        let [column, row] = chessboard_place(square.id);
        for (at, [right, down]) in [[0, 0], [1, 0], [1, 1], [0, 1]].into_iter().enumerate() {
            let before = corners.insert([column + right, row + down], square.corners[at]);
            assert!(before.is_none_or(|before| before == square.corners[at]));
        }
    }
    corners
}

/// Largest distance of a corner from where it is, with the columns and rows of the board as given or turned by half a
/// turn.
fn worst(view: &ChessboardView, scene: &Scene, is_turned: bool) -> f64 {
    let distances = corners(view).into_iter().map(|([column, row], [x, y])| {
        let place = match is_turned {
            true => [scene.shape.columns - 1 - column, scene.shape.rows - 1 - row],
            false => [column, row],
        };
        let truth = scene.corner(place);
        (f64::from(x) - truth.x).hypot(f64::from(y) - truth.y)
    });
    distances.fold(0.0, f64::max)
}

#[test]
fn every_corner_of_a_tilted_board_is_where_it_is_through_any_lens() {
    let scenes = [
        Scene::new(plain_lens(), 11.0, 0.0, 7.0),
        Scene::new(plain_lens(), 11.0, 55.0, -20.0),
        Scene::new(fisheye_lens(), 4.0, 10.0, 33.0),
    ];
    for scene in scenes {
        let view = find(&scene.draw(2.0), SHAPE).unwrap();
        assert_eq!((view.extent, view.size), (Extent::Whole, [7, 6]));
        assert_eq!(corners(&view).len(), 42);
        let off = worst(&view, &scene, false);
        assert!(off < 0.12, "{off}");
    }
}

#[test]
fn a_blurred_board_is_found() {
    let mut scene = Scene::new(plain_lens(), 11.0, 20.0, 10.0);
    scene.blur_px = 3.0;
    let view = find(&scene.draw(3.0), SHAPE).unwrap();
    assert_eq!((view.extent, corners(&view).len()), (Extent::Whole, 42));
    assert!(worst(&view, &scene, false) < 0.4);
}

#[test]
fn a_board_upside_down_keeps_its_corners_if_its_sides_differ_by_an_odd_number() {
    let scene = Scene::new(plain_lens(), 11.0, 15.0, 186.0);
    let view = find(&scene.draw(2.0), SHAPE).unwrap();
    let off = worst(&view, &scene, false);
    assert!(off < 0.12, "{off}");
    let mut symmetric = Scene::new(plain_lens(), 11.0, 15.0, 186.0);
    symmetric.shape.rows = 5;
    let view = find(&symmetric.draw(2.0), symmetric.shape).unwrap();
    assert!(worst(&view, &symmetric, true) < 0.12);
}

#[test]
fn a_hidden_part_leaves_the_rest() {
    let scene = Scene::new(plain_lens(), 11.0, 15.0, 5.0);
    let mut pixels = scene.draw(2.0);
    let hand = scene.corner([3, 2]);
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            if (x as f64 - hand.x).hypot(y as f64 - hand.y) < 17.0 {
                pixels[y * SIZE[0] + x] = 150;
            }
        }
    }
    let view = find(&pixels, SHAPE).unwrap();
    let corners = corners(&view);
    assert_eq!(view.extent, Extent::Whole);
    assert!(
        !corners.contains_key(&[3, 2]) && corners.len() >= 36,
        "{}",
        corners.len()
    );
    let off = worst(&view, &scene, false);
    assert!(off < 0.12, "{off}");
}

/// Each corner counts once, whatever the number of squares that report it.
#[test]
fn corners_of_several_squares_share_their_information() {
    let scene = Scene::new(plain_lens(), 11.0, 15.0, 5.0);
    let view = find(&scene.draw(2.0), SHAPE).unwrap();
    // Of 7 columns the middle ones are in two squares: 4 x 3 squares contain 42 corners.
    assert_eq!(view.squares.len(), 12);
    let squares = view.squares.iter();
    let variances = squares.flat_map(|square| square.corner_covariance.map(|c| c[0] + c[2]));
    assert!(
        variances
            .clone()
            .all(|variance| variance.is_finite() && variance > 0.0)
    );
}

#[test]
fn a_board_in_part_or_of_another_size_is_named_so() {
    let scene = Scene::new(plain_lens(), 6.0, 10.0, 5.0);
    let pixels = scene.draw(2.0);
    let view = find(&pixels, SHAPE).unwrap();
    assert_eq!(view.extent, Extent::Part);
    assert!(!view.squares.is_empty());

    let scene = Scene::new(plain_lens(), 11.0, 10.0, 5.0);
    let pixels = scene.draw(2.0);
    let smaller = BoardShape {
        columns: 6,
        rows: 5,
    };
    let view = find(&pixels, smaller).unwrap();
    assert_eq!(
        (view.extent, view.size, view.squares.len()),
        (Extent::Larger, [7, 6], 0)
    );
}

#[test]
fn nothing_is_found_where_there_is_nothing() {
    let mut random = Random(5);
    let noise: Vec<u8> = (0..SIZE[0] * SIZE[1])
        .map(|_| random.between(0.0, 256.0) as u8)
        .collect();
    assert_eq!(find(&noise, SHAPE), None);
    assert_eq!(find(&vec![90; SIZE[0] * SIZE[1]], SHAPE), None);
    let tiny = Image::new(&noise, 16, 16, 16).unwrap();
    assert_eq!(find_chessboard(&tiny, SHAPE), None);
}
