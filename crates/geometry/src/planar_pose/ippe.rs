//! Infinitesimal plane-based pose estimation: two poses from the homography's derivative at the tag's centre.
//!
//! T. Collins, A. Bartoli, Infinitesimal plane-based pose estimation, IJCV 2014, doi 10.1007/s11263-014-0725-5,
//! algorithm 1. Exact for exact corners; a start for refinement otherwise.

use crate::homography::Homography;
use crate::pose::Pose;
use nalgebra::{
    Isometry3, Matrix2, Matrix2x3, Matrix3, Point2, Point3, Rotation3, Translation3,
    UnitQuaternion, Vector2, Vector3,
};

/// Both poses that explain the homography from tag (metres, centre at zero) to normalised image at the tag's centre.
/// A branch is `None` if it puts a corner behind the camera; all is `None` if the homography is degenerate.
pub(super) fn both_poses(
    image_from_tag: &Homography,
    corners_in_tag: &[Point3<f64>; 4],
    corners_normalised: &[Point2<f64>; 4],
) -> Option<[Option<Pose>; 2]> {
    let centre = image_from_tag.apply(&Point2::origin())?;
    let derivative = image_from_tag.jacobian(&Point2::origin())?;
    let rotations = both_rotations(&centre.coords, &derivative)?;
    Some(rotations.map(|rotation| {
        let translation = translation(&rotation, corners_in_tag, corners_normalised)?;
        let pose = Isometry3::from_parts(Translation3::from(translation), rotation);
        corners_in_tag
            .iter()
            .all(|corner| (pose * corner).z > 0.0)
            .then_some(pose)
    }))
}

/// The two rotations with derivative `j` of the projection at the point seen at `v` (equations 13 to 19).
fn both_rotations(v: &Vector2<f64>, j: &Matrix2<f64>) -> Option<[UnitQuaternion<f64>; 2]> {
    let sight = Vector3::new(v.x, v.y, 1.0);
    let camera_from_sight = UnitQuaternion::rotation_between(&Vector3::z(), &sight)?;
    let turn = camera_from_sight.to_rotation_matrix();
    let b = Matrix2x3::new(1.0, 0.0, -v.x, 0.0, 1.0, -v.y) * turn.matrix();
    let a = b.fixed_view::<2, 2>(0, 0).try_inverse()? * j;
    let upper = a / largest_singular_value(&a)?;
    let lower = lower_row(&upper);
    Some([lower, -lower].map(|lower| camera_from_sight * complete(&upper, &lower)))
}

fn largest_singular_value(a: &Matrix2<f64>) -> Option<f64> {
    let square = a * a.transpose();
    let half_difference = 0.5 * (square.m11 - square.m22);
    let value = (0.5 * square.trace() + half_difference.hypot(square.m12)).sqrt();
    (value.is_finite() && value > 0.0).then_some(value)
}

/// The third row of the two columns whose first two rows are `upper`, up to its sign: what makes them unit vectors
/// orthogonal to each other.
fn lower_row(upper: &Matrix2<f64>) -> Vector2<f64> {
    let missing = Matrix2::identity() - upper.transpose() * upper;
    let x = missing.m11.max(0.0).sqrt();
    let y = missing.m22.max(0.0).sqrt();
    Vector2::new(x, if missing.m12 < 0.0 { -y } else { y })
}

fn complete(upper: &Matrix2<f64>, lower: &Vector2<f64>) -> UnitQuaternion<f64> {
    let x = Vector3::new(upper.m11, upper.m21, lower.x).normalize();
    let y = Vector3::new(upper.m12, upper.m22, lower.y);
    let z = x.cross(&y).normalize();
    let matrix = Matrix3::from_columns(&[x, z.cross(&x), z]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// The translation that best explains the corners for a given rotation, by linear least squares: each corner with
/// `q = R p` says `t_x - u t_z = u q_z - q_x` and the same for y.
fn translation(
    rotation: &UnitQuaternion<f64>,
    corners_in_tag: &[Point3<f64>; 4],
    corners_normalised: &[Point2<f64>; 4],
) -> Option<Vector3<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (corner, seen) in corners_in_tag.iter().zip(corners_normalised) {
        let q = rotation * corner;
        let rows = Matrix2x3::new(1.0, 0.0, -seen.x, 0.0, 1.0, -seen.y);
        let target = seen.coords * q.z - q.coords.xy();
        normal += rows.transpose() * rows;
        right += rows.transpose() * target;
    }
    let solution = normal.cholesky()?.solve(&right);
    solution.iter().all(|t| t.is_finite()).then_some(solution)
}
