//! The laws of a homography.

use crate::generators::vector;
use crate::numeric::{jacobian_at_zero, relative_difference};
use nalgebra::{Matrix3, Point2, SVector, Vector2};
use proptest::prelude::*;
use sextant_geometry::Homography;

const SQUARE: [[f64; 2]; 4] = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];

fn points(corners: [[f64; 2]; 4]) -> [Point2<f64>; 4] {
    corners.map(Point2::from)
}

/// Quadrilaterals near a square, somewhere and of some size.
fn quadrilateral() -> impl Strategy<Value = [Point2<f64>; 4]> {
    let jitter = vector::<8>(0.4);
    (jitter, vector::<2>(1000.0), -0.5..3.0).prop_map(
        |(jitter, at, exponent): (SVector<f64, 8>, Vector2<f64>, f64)| {
            let scale = 10_f64.powf(exponent);
            std::array::from_fn(|i| {
                let moved =
                    Vector2::from(SQUARE[i]) + Vector2::new(jitter[2 * i], jitter[2 * i + 1]);
                Point2::from(at + moved * scale)
            })
        },
    )
}

fn spread(corners: &[Point2<f64>; 4]) -> f64 {
    (corners[0] - corners[2]).norm()
}

proptest! {
    #[test]
    fn corners_go_to_corners(from in quadrilateral(), to in quadrilateral()) {
        let map = Homography::from_corners(&from, &to).unwrap();
        for (from, seen) in from.iter().zip(&to) {
            let off = (map.apply(from).unwrap() - seen).norm();
            // A corner of half a pixel's size a thousand pixels off the origin has ten digits left, its matrix seven.
            prop_assert!(off < 1e-6 * spread(&to), "{off}");
        }
    }

    #[test]
    fn the_inverse_leads_back(to in quadrilateral(), inside in vector::<2>(0.9)) {
        let map = Homography::from_corners(&points(SQUARE), &to).unwrap();
        let point = Point2::from(inside);
        let back = map.inverse().unwrap().apply(&map.apply(&point).unwrap()).unwrap();
        prop_assert!((back - point).norm() < 1e-6);
    }

    #[test]
    fn the_jacobian_is_the_derivative(to in quadrilateral(), inside in vector::<2>(0.9)) {
        let map = Homography::from_corners(&points(SQUARE), &to).unwrap();
        let point = Point2::from(inside);
        let analytic = map.jacobian(&point).unwrap() / spread(&to);
        let numeric = jacobian_at_zero(|d: &Vector2<f64>| map.apply(&(point + d)).unwrap().coords / spread(&to));
        prop_assert!(relative_difference(&analytic, &numeric) < 1e-3);
    }

    #[test]
    fn no_corners_give_nan(from in prop::array::uniform8(any::<f64>()), to in prop::array::uniform8(-10.0..10.0)) {
        let corners = |c: [f64; 8]| std::array::from_fn(|i| Point2::new(c[2 * i], c[2 * i + 1]));
        if let Some(map) = Homography::from_corners(&corners(from), &corners(to)) {
            prop_assert!(map.matrix().iter().all(|m| m.is_finite()));
            if let Some(point) = map.apply(&Point2::new(from[0], to[0])) {
                prop_assert!(point.iter().all(|c| c.is_finite()));
            }
        }
    }
}

#[test]
fn a_square_goes_to_itself_by_the_identity() {
    let map = Homography::from_corners(&points(SQUARE), &points(SQUARE)).unwrap();
    let matrix = map.matrix() / map.matrix().m33;
    assert!((matrix - Matrix3::identity()).amax() < 1e-14);
}

#[test]
fn degenerate_corners_have_no_homography() {
    let square = points(SQUARE);
    let degenerate = [
        [[0.0, 0.0]; 4],
        [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 1.0]],
        [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]],
        [[f64::NAN, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        [[f64::INFINITY, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
    ];
    for corners in degenerate.map(points) {
        assert_eq!(
            Homography::from_corners(&corners, &square),
            None,
            "{corners:?}"
        );
        assert_eq!(
            Homography::from_corners(&square, &corners),
            None,
            "{corners:?}"
        );
    }
}

#[test]
fn a_point_on_the_horizon_goes_nowhere() {
    let map = Homography::from_matrix(&Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0))
        .unwrap();
    assert_eq!(map.apply(&Point2::new(-1.0, 0.5)), None);
    assert_eq!(map.jacobian(&Point2::new(-1.0, 0.5)), None);
}
