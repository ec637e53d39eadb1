//! Kannala-Brandt distortion: a polynomial of the angle off the axis, for wide and fisheye lenses.
//!
//! With `a = atan(r)`: `a_d = a + k1 a^3 + k2 a^5 + k3 a^7 + k4 a^9` and `distorted = normalised * a_d / r`
//! (J. Kannala, S. Brandt, A generic camera model and calibration method, PAMI 2006, eq. 6; OpenCV's fisheye).
//! Lenses that see more than 180 degrees are used up to 89.4 degrees off the axis.

use super::LensError;
use super::parameters::check_coefficients;
use super::valid_field::{MAX_RADIUS, MIN_SLOPE, first_zero, invert_monotone};
use nalgebra::{Matrix2, SMatrix, Vector2};

const NAMES: [&str; 4] = ["k1", "k2", "k3", "k4"];
/// Newton's method doubles the digits with each step: after one this small all are right.
const LAST_STEP: f64 = 1e-9;
/// Normalised radius below which the quotients by it are replaced by the first terms of their series.
const NEAR_AXIS: f64 = 1e-4;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct KannalaBrandt {
    coefficients: [f64; 4],
    /// End of the valid field, radians off the axis.
    max_angle: f64,
    /// Its tangent.
    max_radius: f64,
    /// Distorted radius there.
    max_distorted: f64,
}

impl KannalaBrandt {
    pub(super) fn new(coefficients: [f64; 4]) -> Result<Self, LensError> {
        check_coefficients(&NAMES, &coefficients)?;
        let max_angle = max_angle(&coefficients);
        let (max_distorted, _) = bend(&coefficients, max_angle);
        Ok(Self {
            coefficients,
            max_angle,
            max_radius: max_angle.tan(),
            max_distorted,
        })
    }

    pub(super) fn coefficients(&self) -> &[f64; 4] {
        &self.coefficients
    }

    pub(super) fn max_radius(&self) -> f64 {
        self.max_radius
    }

    pub(super) fn distort(&self, n: &Vector2<f64>) -> Vector2<f64> {
        let (scale, _) = self.scale(n.norm());
        n * scale
    }

    pub(super) fn distort_with_jacobian(&self, n: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let (scale, slope) = self.scale(n.norm());
        (
            n * scale,
            Matrix2::identity() * scale + n * n.transpose() * slope,
        )
    }

    /// Derivatives with respect to k1, k2, k3, k4.
    pub(super) fn coefficient_jacobian(&self, n: &Vector2<f64>) -> SMatrix<f64, 2, 4> {
        let r = n.norm();
        let angle = r.atan();
        let angle_over_r = if r < NEAR_AXIS {
            1.0 - r * r / 3.0
        } else {
            angle / r
        };
        let s = angle * angle;
        let column = n * (angle_over_r * s);
        SMatrix::<f64, 2, 4>::from_columns(&[
            column,
            column * s,
            column * (s * s),
            column * (s * s * s),
        ])
    }

    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        let target = distorted.norm();
        if target == 0.0 {
            return Some(Vector2::zeros());
        }
        if target > self.max_distorted {
            return None;
        }
        let angle = invert_monotone(
            |angle| bend(&self.coefficients, angle),
            target,
            self.max_angle,
            LAST_STEP,
        );
        Some(distorted * (angle.tan() / target))
    }

    /// `g = a_d / r` and `(dg/dr) / r` at normalised radius `r`.
    fn scale(&self, r: f64) -> (f64, f64) {
        let [k1, ..] = self.coefficients;
        if r < NEAR_AXIS {
            // a = r - r^3/3 + .., hence a_d/r = 1 + (k1 - 1/3) r^2 + ..
            let curvature = k1 - 1.0 / 3.0;
            return (1.0 + curvature * r * r, 2.0 * curvature);
        }
        let (bent, bent_by_angle) = bend(&self.coefficients, r.atan());
        let bent_by_r = bent_by_angle / (1.0 + r * r);
        (bent / r, (bent_by_r - bent / r) / (r * r))
    }
}

/// `a_d` and its derivative at the angle `a`.
fn bend(&[k1, k2, k3, k4]: &[f64; 4], a: f64) -> (f64, f64) {
    let s = a * a;
    let value = a * (1.0 + s * (k1 + s * (k2 + s * (k3 + s * k4))));
    let slope = 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * (7.0 * k3 + s * 9.0 * k4)));
    (value, slope)
}

/// The angle up to which `a_d` grows with `a`.
fn max_angle(&[k1, k2, k3, k4]: &[f64; 4]) -> f64 {
    let start = 1.0 - MIN_SLOPE;
    let slope = [
        start,
        0.0,
        3.0 * k1,
        0.0,
        5.0 * k2,
        0.0,
        7.0 * k3,
        0.0,
        9.0 * k4,
    ];
    first_zero(&slope, MAX_RADIUS.atan())
}
