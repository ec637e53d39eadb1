//! Rotations: exponential, logarithm and Jacobians of SO(3).
//!
//! In and out: rotation vectors (axis times angle, radians) and unit quaternions. Formulas: J. Sola, J. Deray,
//! D. Atchuthan, A micro Lie theory for state estimation in robotics, arXiv 1812.01537, 2018; the coefficients are
//! Stumpff functions, so no branch loses digits near zero, and the logarithm of a quaternion loses none near pi.

use crate::stumpff::stumpff;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// The matrix of the cross product: `hat(a) * b == a.cross(&b)`.
pub fn hat(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// The rotation by `|w|` radians about `w`.
pub fn exp(w: &Vector3<f64>) -> UnitQuaternion<f64> {
    let [cos_half, sinc_half, ..] = stumpff(0.25 * w.norm_squared());
    UnitQuaternion::new_normalize(Quaternion::from_parts(cos_half, w * (0.5 * sinc_half)))
}

/// The rotation vector of `rotation`, at most pi long. Inverse of [`exp`] below pi; at pi either of the two signs.
pub fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    // q and -q are the same rotation; the one with w >= 0 turns by at most pi.
    let sign = if rotation.w < 0.0 { -1.0 } else { 1.0 };
    let (sin_half_axis, cos_half) = (sign * rotation.imag(), sign * rotation.w);
    let sin_half = sin_half_axis.norm();
    let angle_over_sin_half = if sin_half < 1e-8 {
        2.0 / cos_half // 2 atan(s/c)/s = 2/c (1 - (s/c)^2/3 + ..)
    } else {
        2.0 * sin_half.atan2(cos_half) / sin_half
    };
    sin_half_axis * angle_over_sin_half
}

/// `J` with `exp(w + d) = exp(J d) exp(w)` to first order in `d`.
/// `J = I + c_2 W + c_3 W^2`, `W = hat(w)` (Sola eq. 145).
pub fn left_jacobian(w: &Vector3<f64>) -> Matrix3<f64> {
    let [_, _, c2, c3, ..] = stumpff(w.norm_squared());
    let hat_w = hat(w);
    Matrix3::identity() + hat_w * c2 + hat_w * hat_w * c3
}

/// The inverse of [`left_jacobian`], for `|w| < 2 pi` (where it is singular; [`log`] never exceeds pi).
///
/// `I - W/2 + k W^2` with `k = (1 - (a/2) cot(a/2)) / a^2` (Sola eq. 146), written as
/// `(c_2 - c_3) / (4 c_1)` at half the angle, which is smooth at zero and at pi.
pub fn left_jacobian_inverse(w: &Vector3<f64>) -> Matrix3<f64> {
    let [_, c1, c2, c3, ..] = stumpff(0.25 * w.norm_squared());
    let hat_w = hat(w);
    Matrix3::identity() - hat_w * 0.5 + hat_w * hat_w * ((c2 - c3) / (4.0 * c1))
}
