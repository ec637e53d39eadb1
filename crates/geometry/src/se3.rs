//! Rigid motions: exponential, logarithm, adjoint and Jacobians of SE(3), and the project's own perturbation.
//!
//! Six-vectors are (translation part, rotation part), metres and radians. Formulas: J. Sola, J. Deray, D. Atchuthan,
//! A micro Lie theory for state estimation in robotics, arXiv 1812.01537, 2018, appendix D.

use crate::pose::Pose;
use crate::so3;
use crate::stumpff::stumpff;
use nalgebra::{Isometry3, Matrix3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

/// The motion of the constant twist `(v, w)` in unit time: `(J(w) v, exp(w))` (Sola eq. 172).
pub fn exp(twist: &Vector6<f64>) -> Pose {
    let (v, w) = halves(twist);
    let translation = so3::left_jacobian(&w) * v;
    Isometry3::from_parts(Translation3::from(translation), so3::exp(&w))
}

/// The twist `(v, w)`, `|w| <= pi`, with `exp(twist) == pose` (Sola eq. 173).
pub fn log(pose: &Pose) -> Vector6<f64> {
    let w = so3::log(&pose.rotation);
    join(
        &(so3::left_jacobian_inverse(&w) * pose.translation.vector),
        &w,
    )
}

/// `Ad` with `pose * exp(d) == exp(Ad d) * pose` (Sola eq. 175).
pub fn adjoint(pose: &Pose) -> Matrix6<f64> {
    let rotation = matrix(&pose.rotation);
    let crossed = so3::hat(&pose.translation.vector) * rotation;
    blocks(&rotation, &crossed, &rotation)
}

/// `J` with `exp(twist + d) = exp(J d) exp(twist)` to first order in `d` (Sola eq. 179).
pub fn left_jacobian(twist: &Vector6<f64>) -> Matrix6<f64> {
    let (v, w) = halves(twist);
    let rotational = so3::left_jacobian(&w);
    blocks(&rotational, &coupling(&v, &w), &rotational)
}

/// The inverse of [`left_jacobian`], for `|w| < 2 pi`.
pub fn left_jacobian_inverse(twist: &Vector6<f64>) -> Matrix6<f64> {
    let (v, w) = halves(twist);
    let inverse = so3::left_jacobian_inverse(&w);
    blocks(&inverse, &(-inverse * coupling(&v, &w) * inverse), &inverse)
}

/// `pose` after the small step `(dt, dr)` of FRAMES.md: the position moves by `dt`, the attitude becomes `exp(dr) R`.
///
/// Covariances of poses are over this step: axes of the outer frame, turning about the inner frame's origin.
pub fn perturb(pose: &Pose, step: &Vector6<f64>) -> Pose {
    let (dt, dr) = halves(step);
    let mut rotation = so3::exp(&dr) * pose.rotation;
    rotation.renormalize();
    Isometry3::from_parts(Translation3::from(pose.translation.vector + dt), rotation)
}

/// The step that leads from `truth` to `estimate`: `perturb(&truth, &difference(&estimate, &truth)) == estimate`.
pub fn difference(estimate: &Pose, truth: &Pose) -> Vector6<f64> {
    let dt = estimate.translation.vector - truth.translation.vector;
    join(
        &dt,
        &so3::log(&(estimate.rotation * truth.rotation.inverse())),
    )
}

/// The block `Q(v, w)` of the left Jacobian (Sola eq. 180; T. Barfoot, State Estimation for Robotics, 2017, eq. 7.86).
fn coupling(v: &Vector3<f64>, w: &Vector3<f64>) -> Matrix3<f64> {
    let [_, _, _, c3, c4, c5] = stumpff(w.norm_squared());
    let (v, w) = (so3::hat(v), so3::hat(w));
    let (wv, vw) = (w * v, v * w);
    let wvw = wv * w;
    v * 0.5
        + (wv + vw + wvw) * c3
        + (w * wv + vw * w - wvw * 3.0) * c4
        + (wvw * w + w * wvw) * (0.5 * (c4 - 3.0 * c5))
}

fn matrix(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    *rotation.to_rotation_matrix().matrix()
}

fn halves(six: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        six.fixed_rows::<3>(0).into_owned(),
        six.fixed_rows::<3>(3).into_owned(),
    )
}

fn join(first: &Vector3<f64>, second: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(first.x, first.y, first.z, second.x, second.y, second.z)
}

/// Upper triangular block matrix `[a b; 0 c]`.
fn blocks(a: &Matrix3<f64>, b: &Matrix3<f64>, c: &Matrix3<f64>) -> Matrix6<f64> {
    let mut whole = Matrix6::zeros();
    whole.fixed_view_mut::<3, 3>(0, 0).copy_from(a);
    whole.fixed_view_mut::<3, 3>(0, 3).copy_from(b);
    whole.fixed_view_mut::<3, 3>(3, 3).copy_from(c);
    whole
}
