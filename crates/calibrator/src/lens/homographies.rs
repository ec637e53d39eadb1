//! Homographies of the board, and the focal lengths that follow from them.
//!
//! Z. Zhang, A flexible new technique for camera calibration, PAMI 2000, section 3.1, with the principal point in the
//! middle of the picture and no skew: the two constraints of each homography are then linear in 1/fx^2 and 1/fy^2.

use super::board::Board;
use super::view::BoardView;
use nalgebra::{DMatrix, Matrix2, Matrix3, Point2, SymmetricEigen, Vector2};
use sextant_geometry::Homography;

/// Largest distance of a corner from its homography, as a share of the image width; beyond it the corner is wrong or
/// distortion too strong.
const TOLERANCE: f64 = 0.03;
/// Largest deviation of a board from a plane, as a share of its size.
const FLATNESS: f64 = 1e-6;

/// Focal lengths, pixels; `None` if the homographies do not determine them.
pub(super) fn focal_lengths(
    board: &Board,
    views: &[BoardView],
    [width, height]: [f64; 2],
) -> Option<[f64; 2]> {
    if board
        .tags
        .iter()
        .flat_map(|tag| &tag.corners)
        .any(|corner| corner.z.abs() > FLATNESS)
    {
        return None;
    }
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for view in views {
        let Some(map) = homography(board, view, TOLERANCE * width) else {
            continue;
        };
        // Columns in half image widths about the centre of the image.
        let unit = width / 2.0;
        let to_unit = Matrix3::new(
            1.0 / unit,
            0.0,
            -(width - 1.0) / 2.0 / unit,
            0.0,
            1.0 / unit,
            -(height - 1.0) / 2.0 / unit,
            0.0,
            0.0,
            1.0,
        );
        let map = to_unit * map;
        let scale = map.fixed_view::<3, 2>(0, 0).norm();
        let (a, b) = (map.column(0) / scale, map.column(1) / scale);
        for (row, constant) in [
            (Vector2::new(a[0] * b[0], a[1] * b[1]), a[2] * b[2]),
            (
                Vector2::new(a[0] * a[0] - b[0] * b[0], a[1] * a[1] - b[1] * b[1]),
                a[2] * a[2] - b[2] * b[2],
            ),
        ] {
            normal += row * row.transpose();
            right -= row * constant;
        }
    }
    let inverse_squares = normal.try_inverse()? * right;
    let focal = |x: f64| {
        (x > 0.0)
            .then(|| width / 2.0 / x.sqrt())
            .filter(|f| f.is_finite())
    };
    Some([focal(inverse_squares[0])?, focal(inverse_squares[1])?])
}

/// The homography from the board's plane to pixels with which most tags agree, fitted to those.
fn homography(board: &Board, view: &BoardView, tolerance: f64) -> Option<Matrix3<f64>> {
    let agreeing = |map: &Homography| -> Vec<(Point2<f64>, Point2<f64>)> {
        let tags = view.tags.iter().filter_map(|seen| {
            let on_board = board.tags[seen.tag].corners.map(|corner| corner.xy());
            let fits = on_board.iter().zip(&seen.corners).all(|(from, to)| {
                map.apply(from)
                    .is_some_and(|mapped| (mapped - to).norm() < tolerance)
            });
            fits.then(|| on_board.into_iter().zip(seen.corners))
        });
        tags.flatten().collect()
    };
    let hypotheses = view.tags.iter().filter_map(|seen| {
        let on_board = board.tags[seen.tag].corners.map(|corner| corner.xy());
        Homography::from_corners(&on_board, &seen.corners)
    });
    let best = hypotheses.map(|map| agreeing(&map)).max_by_key(Vec::len)?;
    let refined = fitted(&best)?;
    fitted(&agreeing(&Homography::from_matrix(&refined)?))
}

/// Homography of point pairs by the direct linear transform, with both sides centred and scaled.
fn fitted(pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Matrix3<f64>> {
    let from_unit = unit_of(pairs.iter().map(|(from, _)| from))?;
    let to_unit = unit_of(pairs.iter().map(|(_, to)| to))?;
    let mut normal = DMatrix::<f64>::zeros(9, 9);
    for (from, to) in pairs {
        let p = from_unit * from.to_homogeneous();
        let q = to_unit * to.to_homogeneous();
        for (axis, at) in [(0, q.x), (1, q.y)] {
            let mut row = DMatrix::<f64>::zeros(1, 9);
            for k in 0..3 {
                row[(0, 3 * axis + k)] = p[k];
                row[(0, 6 + k)] = -at * p[k];
            }
            normal += row.transpose() * &row;
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let least = eigen.eigenvalues.imin();
    let h = eigen.eigenvectors.column(least);
    let map = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]);
    let map = to_unit.try_inverse()? * map * from_unit;
    map.iter().all(|x| x.is_finite()).then_some(map)
}

/// Centres points and scales them to a mean square distance of two.
fn unit_of<'a>(points: impl Iterator<Item = &'a Point2<f64>> + Clone) -> Option<Matrix3<f64>> {
    let n = points.clone().count() as f64;
    let middle = points.clone().map(|p| p.coords).sum::<Vector2<f64>>() / n;
    let square = points
        .map(|p| (p.coords - middle).norm_squared())
        .sum::<f64>()
        / n;
    let scale = (2.0 / square).sqrt();
    scale.is_finite().then(|| {
        Matrix3::new(
            scale,
            0.0,
            -scale * middle.x,
            0.0,
            scale,
            -scale * middle.y,
            0.0,
            0.0,
            1.0,
        )
    })
}
