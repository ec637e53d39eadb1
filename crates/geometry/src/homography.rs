//! Homographies: projective maps of one plane onto another, from four corners.
//!
//! Points are plain 2-D points of whatever unit the caller uses; nothing here knows pixels or metres.

use nalgebra::{Matrix2, Matrix3, Point2, Vector3};

/// Smallest ratio of the smallest to the largest triangle among four corners; below it three are in line.
const MIN_AREA_RATIO: f64 = 1e-9;
/// Smallest ratio of a mapped point's third coordinate to the magnitude of its terms; below it it lies at infinity.
const MIN_DEPTH_RATIO: f64 = 1e-12;

/// A projective map of the plane, scaled to unit Frobenius norm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography(Matrix3<f64>);

impl Homography {
    /// The map that takes each corner of `from` to that of `to`. `None` if three corners of either are in line,
    /// coincide, or a coordinate is not finite.
    ///
    /// Each quadrilateral is first moved to its centroid and scaled (R. Hartley, In defense of the eight-point
    /// algorithm, PAMI 1997), then written as the image of the projective basis (R. Hartley, A. Zisserman, Multiple
    /// View Geometry, 2004, 4.1), so that no linear system larger than 3x3 is solved.
    pub fn from_corners(from: &[Point2<f64>; 4], to: &[Point2<f64>; 4]) -> Option<Self> {
        let (from_unit, unit_from) = (basis_of(from)?, basis_of(to)?);
        let map = unit_from * from_unit.try_inverse()?;
        Self::from_matrix(&map)
    }

    /// The map of an invertible matrix; `None` if it is singular or not finite.
    pub fn from_matrix(matrix: &Matrix3<f64>) -> Option<Self> {
        let norm = matrix.norm();
        if !(norm.is_finite() && norm > 0.0) {
            return None;
        }
        let scaled = matrix / norm;
        let determinant = scaled.determinant();
        (determinant != 0.0 && determinant.is_finite()).then_some(Self(scaled))
    }

    /// The matrix, of unit Frobenius norm; its sign is arbitrary.
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.0
    }

    /// Where a point goes; `None` if to infinity.
    pub fn apply(&self, point: &Point2<f64>) -> Option<Point2<f64>> {
        Some(self.apply_with_depth(point)?.0)
    }

    /// The derivative of [`Homography::apply`] at a point.
    pub fn jacobian(&self, point: &Point2<f64>) -> Option<Matrix2<f64>> {
        let (mapped, depth) = self.apply_with_depth(point)?;
        let linear = self.0.fixed_view::<2, 2>(0, 0);
        let depth_by_point = self.0.fixed_view::<1, 2>(2, 0);
        let jacobian = (linear - mapped.coords * depth_by_point) / depth;
        jacobian.iter().all(|j| j.is_finite()).then_some(jacobian)
    }

    /// The map back; `None` if its matrix cannot be inverted.
    pub fn inverse(&self) -> Option<Self> {
        Self::from_matrix(&self.0.try_inverse()?)
    }

    /// The mapped point and the third coordinate by which it was divided.
    fn apply_with_depth(&self, point: &Point2<f64>) -> Option<(Point2<f64>, f64)> {
        let mapped = self.0 * point.to_homogeneous();
        let row = self.0.row(2);
        let magnitude = (row[0] * point.x).abs() + (row[1] * point.y).abs() + row[2].abs();
        let image = Point2::from(mapped.xy() / mapped.z);
        let finite = image.iter().all(|c| c.is_finite());
        (finite && mapped.z.abs() > MIN_DEPTH_RATIO * magnitude).then_some((image, mapped.z))
    }
}

/// The matrix that maps the projective basis (e1, e2, e3, e1 + e2 + e3) to the four corners.
fn basis_of(corners: &[Point2<f64>; 4]) -> Option<Matrix3<f64>> {
    let (unit_corners, corners_from_unit) = normalise(corners)?;
    let [a, b, c, d] = unit_corners.map(|p| p.to_homogeneous());
    // d = l a + m b + n c by Cramer's rule: ratios of the areas of the four triangles.
    let areas = [
        triple(&d, &b, &c),
        triple(&a, &d, &c),
        triple(&a, &b, &d),
        triple(&a, &b, &c),
    ];
    let sizes = areas.map(f64::abs);
    let largest = sizes.into_iter().fold(0.0, f64::max);
    if !sizes
        .into_iter()
        .all(|size| size > MIN_AREA_RATIO * largest && size > f64::MIN_POSITIVE)
    {
        return None;
    }
    let [l, m, n, _] = areas;
    Some(corners_from_unit * Matrix3::from_columns(&[a * l, b * m, c * n]))
}

fn triple(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> f64 {
    a.cross(b).dot(c)
}

/// The corners about their centroid at unit mean distance, and the matrix that undoes it.
fn normalise(corners: &[Point2<f64>; 4]) -> Option<([Point2<f64>; 4], Matrix3<f64>)> {
    let centroid = corners
        .iter()
        .fold(Point2::origin(), |sum, p| sum + p.coords * 0.25);
    let spread = corners.iter().map(|p| (p - centroid).norm()).sum::<f64>() * 0.25;
    if !(spread.is_finite() && spread > 0.0) {
        return None;
    }
    let unit = corners.map(|p| Point2::from((p - centroid) / spread));
    let back = Matrix3::new(
        spread, 0.0, centroid.x, 0.0, spread, centroid.y, 0.0, 0.0, 1.0,
    );
    Some((unit, back))
}
