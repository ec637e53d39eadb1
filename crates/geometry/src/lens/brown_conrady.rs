//! Brown-Conrady distortion: radial and tangential polynomials of the normalised radius.
//!
//! With `s = x^2 + y^2` and `R = 1 + k1 s + k2 s^2 + k3 s^3` (D. Brown, Close-range camera calibration, 1971; OpenCV):
//! `x_d = x R + 2 p1 x y + p2 (s + 2 x^2)`, `y_d = y R + p1 (s + 2 y^2) + 2 p2 x y`.
//!
//! This is the gradient of a potential, so its Jacobian is symmetric, and wherever the Jacobian is positive definite on
//! a disc the map is one to one there and its inverse a convex minimisation.

use super::LensError;
use super::parameters::check_coefficients;
use super::valid_field::{MAX_RADIUS, MIN_SLOPE, first_zero, invert_monotone};
use nalgebra::{Matrix2, SMatrix, Vector2};

const NAMES: [&str; 5] = ["k1", "k2", "p1", "p2", "k3"];
/// How exactly the radial part is solved before the whole: Newton's method doubles the digits then.
const RADIAL_LAST_STEP: f64 = 1e-2;
/// Newton's method takes two or three steps in the field of a real lens.
const MAX_STEPS: usize = 50;
/// Shortest fraction of a Newton step tried before the point counts as out of reach.
const MIN_FRACTION: f64 = 1e-9;
/// A residual of rounding, relative to one plus the distorted radius.
const EXACT: f64 = 4.0 * f64::EPSILON;
/// Largest residual of an inverse, relative to one plus the distorted radius; Newton's method stops far below it.
const TOLERANCE: f64 = 1e-12;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BrownConrady {
    coefficients: [f64; 5],
    max_radius: f64,
}

impl BrownConrady {
    pub(super) fn new(coefficients: [f64; 5]) -> Result<Self, LensError> {
        check_coefficients(&NAMES, &coefficients)?;
        Ok(Self {
            coefficients,
            max_radius: max_radius(&coefficients),
        })
    }

    pub(super) fn coefficients(&self) -> &[f64; 5] {
        &self.coefficients
    }

    pub(super) fn max_radius(&self) -> f64 {
        self.max_radius
    }

    pub(super) fn distort(&self, n: &Vector2<f64>) -> Vector2<f64> {
        let [_, _, p1, p2, _] = self.coefficients;
        let s = n.norm_squared();
        let (radial, _) = self.radial(s);
        let twice_along = 2.0 * (p2 * n.x + p1 * n.y);
        n * (radial + twice_along) + Vector2::new(p2, p1) * s
    }

    pub(super) fn distort_with_jacobian(&self, n: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let [_, _, p1, p2, _] = self.coefficients;
        let (radial, radial_by_s) = self.radial(n.norm_squared());
        let twice_along = 2.0 * (p2 * n.x + p1 * n.y);
        let cross = 2.0 * (n.x * n.y * radial_by_s + p1 * n.x + p2 * n.y);
        let diagonal = radial + twice_along;
        let xx = diagonal + 2.0 * n.x * n.x * radial_by_s + 4.0 * p2 * n.x;
        let yy = diagonal + 2.0 * n.y * n.y * radial_by_s + 4.0 * p1 * n.y;
        (self.distort(n), Matrix2::new(xx, cross, cross, yy))
    }

    /// Derivatives with respect to k1, k2, p1, p2, k3.
    pub(super) fn coefficient_jacobian(&self, n: &Vector2<f64>) -> SMatrix<f64, 2, 5> {
        let s = n.norm_squared();
        let (x, y) = (n.x, n.y);
        let xy = 2.0 * x * y;
        SMatrix::<f64, 2, 5>::from_columns(&[
            n * s,
            n * (s * s),
            Vector2::new(xy, s + 2.0 * y * y),
            Vector2::new(s + 2.0 * x * x, xy),
            n * (s * s * s),
        ])
    }

    /// Damped Newton steps inside the valid field, from the solution for the radial part alone.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut normalised = self.undistort_radial(distorted);
        let mut residual = distorted - self.distort(&normalised);
        let scale = 1.0 + distorted.norm();
        for _ in 0..MAX_STEPS {
            if residual.norm() <= EXACT * scale {
                break;
            }
            let Some(step) = self.newton_step(&normalised, &residual) else {
                break;
            };
            let Some(better) = self.shorten(&normalised, &step, distorted, residual.norm_squared())
            else {
                break;
            };
            normalised = better;
            residual = distorted - self.distort(&normalised);
        }
        (residual.norm() <= TOLERANCE * scale).then_some(normalised)
    }

    fn undistort_radial(&self, distorted: &Vector2<f64>) -> Vector2<f64> {
        let target = distorted.norm();
        if target == 0.0 {
            return Vector2::zeros();
        }
        let distorted_radius = |r: f64| {
            let (radial, radial_by_s) = self.radial(r * r);
            (r * radial, radial + 2.0 * r * r * radial_by_s)
        };
        distorted
            * (invert_monotone(distorted_radius, target, self.max_radius, RADIAL_LAST_STEP)
                / target)
    }

    fn newton_step(
        &self,
        normalised: &Vector2<f64>,
        residual: &Vector2<f64>,
    ) -> Option<Vector2<f64>> {
        let (_, jacobian) = self.distort_with_jacobian(normalised);
        Some(jacobian.try_inverse()? * residual)
    }

    /// The longest of the halved steps that stays in the field and brings the distorted point nearer.
    fn shorten(
        &self,
        from: &Vector2<f64>,
        step: &Vector2<f64>,
        distorted: &Vector2<f64>,
        error: f64,
    ) -> Option<Vector2<f64>> {
        let max = self.max_radius * self.max_radius;
        let better = |n: &Vector2<f64>| {
            n.norm_squared() <= max && (distorted - self.distort(n)).norm_squared() < error
        };
        let fractions =
            std::iter::successors(Some(1.0), |f| Some(0.5 * f)).take_while(|&f| f > MIN_FRACTION);
        fractions
            .map(|fraction| from + step * fraction)
            .find(better)
    }

    /// `R` and its derivative with respect to `s`.
    fn radial(&self, s: f64) -> (f64, f64) {
        let [k1, k2, _, _, k3] = self.coefficients;
        (
            1.0 + s * (k1 + s * (k2 + s * k3)),
            k1 + s * (2.0 * k2 + s * 3.0 * k3),
        )
    }
}

/// The radius up to which the Jacobian is positive definite in every direction.
///
/// The radial part's eigenvalues are `R` and `d(rR)/dr`; the tangential part's are at least `-6 |p| r`, reached against
/// the direction of (p2, p1).
fn max_radius(&[k1, k2, p1, p2, k3]: &[f64; 5]) -> f64 {
    let tangential = -6.0 * p1.hypot(p2);
    let start = 1.0 - MIN_SLOPE;
    let along = [start, tangential, 3.0 * k1, 0.0, 5.0 * k2, 0.0, 7.0 * k3];
    let across = [start, tangential, k1, 0.0, k2, 0.0, k3];
    first_zero(&along, MAX_RADIUS).min(first_zero(&across, MAX_RADIUS))
}
