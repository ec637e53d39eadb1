//! The laws of a Lie group, for rotations and for rigid motions.

use crate::generators::{pose, rotation_vector, twist, vector};
use crate::numeric::{jacobian_at_zero, relative_difference};
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3, Vector6};
use proptest::prelude::*;
use sextant_geometry::{Pose, se3, so3};

/// A group with an exponential map from `N` numbers.
trait LieGroup<const N: usize> {
    type Element: Copy;
    fn exp(tangent: &SVector<f64, N>) -> Self::Element;
    fn log(element: &Self::Element) -> SVector<f64, N>;
    fn compose(a: &Self::Element, b: &Self::Element) -> Self::Element;
    fn inverse(a: &Self::Element) -> Self::Element;
    fn adjoint(a: &Self::Element) -> SMatrix<f64, N, N>;
    fn left_jacobian(tangent: &SVector<f64, N>) -> SMatrix<f64, N, N>;
    fn left_jacobian_inverse(tangent: &SVector<f64, N>) -> SMatrix<f64, N, N>;

    /// How far two elements are apart, without using the logarithm.
    fn distance(a: &Self::Element, b: &Self::Element) -> f64;
}

struct So3;
struct Se3;

impl LieGroup<3> for So3 {
    type Element = UnitQuaternion<f64>;
    fn exp(tangent: &Vector3<f64>) -> Self::Element {
        so3::exp(tangent)
    }
    fn log(element: &Self::Element) -> Vector3<f64> {
        so3::log(element)
    }
    fn compose(a: &Self::Element, b: &Self::Element) -> Self::Element {
        a * b
    }
    fn inverse(a: &Self::Element) -> Self::Element {
        a.inverse()
    }
    fn adjoint(a: &Self::Element) -> SMatrix<f64, 3, 3> {
        *a.to_rotation_matrix().matrix()
    }
    fn left_jacobian(tangent: &Vector3<f64>) -> SMatrix<f64, 3, 3> {
        so3::left_jacobian(tangent)
    }
    fn left_jacobian_inverse(tangent: &Vector3<f64>) -> SMatrix<f64, 3, 3> {
        so3::left_jacobian_inverse(tangent)
    }
    fn distance(a: &Self::Element, b: &Self::Element) -> f64 {
        (a.to_rotation_matrix().matrix() - b.to_rotation_matrix().matrix()).amax()
    }
}

impl LieGroup<6> for Se3 {
    type Element = Pose;
    fn exp(tangent: &Vector6<f64>) -> Pose {
        se3::exp(tangent)
    }
    fn log(element: &Pose) -> Vector6<f64> {
        se3::log(element)
    }
    fn compose(a: &Pose, b: &Pose) -> Pose {
        a * b
    }
    fn inverse(a: &Pose) -> Pose {
        a.inverse()
    }
    fn adjoint(a: &Pose) -> SMatrix<f64, 6, 6> {
        se3::adjoint(a)
    }
    fn left_jacobian(tangent: &Vector6<f64>) -> SMatrix<f64, 6, 6> {
        se3::left_jacobian(tangent)
    }
    fn left_jacobian_inverse(tangent: &Vector6<f64>) -> SMatrix<f64, 6, 6> {
        se3::left_jacobian_inverse(tangent)
    }
    fn distance(a: &Pose, b: &Pose) -> f64 {
        (a.to_homogeneous() - b.to_homogeneous()).amax()
    }
}

const TOLERANCE: f64 = 1e-12;

fn group_axioms<const N: usize, G: LieGroup<N>>(a: &G::Element, b: &G::Element, c: &G::Element) {
    let identity = G::exp(&SVector::zeros());
    let left = G::compose(&G::compose(a, b), c);
    let right = G::compose(a, &G::compose(b, c));
    assert!(
        G::distance(&left, &right) < TOLERANCE * 100.0,
        "associative"
    );
    assert!(
        G::distance(&G::compose(a, &identity), a) < TOLERANCE,
        "right identity"
    );
    assert!(
        G::distance(&G::compose(&identity, a), a) < TOLERANCE,
        "left identity"
    );
    assert!(
        G::distance(&G::compose(a, &G::inverse(a)), &identity) < TOLERANCE,
        "right inverse"
    );
    assert!(
        G::distance(&G::compose(&G::inverse(a), a), &identity) < TOLERANCE,
        "left inverse"
    );
}

fn exp_and_log_are_inverse<const N: usize, G: LieGroup<N>>(a: &G::Element) {
    let tangent = G::log(a);
    assert!(tangent.iter().all(|t| t.is_finite()));
    assert!(
        G::distance(&G::exp(&tangent), a) < TOLERANCE,
        "exp(log(a)) = a"
    );
    assert!(
        G::distance(&G::exp(&-tangent), &G::inverse(a)) < TOLERANCE,
        "exp(-log(a)) = inverse"
    );
}

fn exp_is_a_one_parameter_subgroup<const N: usize, G: LieGroup<N>>(
    tangent: &SVector<f64, N>,
    s: f64,
    t: f64,
) {
    let product = G::compose(&G::exp(&(tangent * s)), &G::exp(&(tangent * t)));
    assert!(G::distance(&product, &G::exp(&(tangent * (s + t)))) < TOLERANCE * 10.0);
}

fn adjoint_moves_a_step_across<const N: usize, G: LieGroup<N>>(
    a: &G::Element,
    step: &SVector<f64, N>,
) {
    let right = G::compose(a, &G::exp(step));
    let left = G::compose(&G::exp(&(G::adjoint(a) * step)), a);
    assert!(G::distance(&right, &left) < TOLERANCE * 10.0);
}

fn adjoint_is_a_homomorphism<const N: usize, G: LieGroup<N>>(a: &G::Element, b: &G::Element) {
    let product = G::adjoint(a) * G::adjoint(b);
    assert!(relative_difference(&product, &G::adjoint(&G::compose(a, b))) < TOLERANCE);
}

fn left_jacobian_is_the_derivative_of_exp<const N: usize, G: LieGroup<N>>(
    tangent: &SVector<f64, N>,
) {
    let back = G::inverse(&G::exp(tangent));
    let numeric =
        jacobian_at_zero(|d: &SVector<f64, N>| G::log(&G::compose(&G::exp(&(tangent + d)), &back)));
    assert!(relative_difference(&G::left_jacobian(tangent), &numeric) < 1e-8);
}

fn left_jacobian_and_inverse_cancel<const N: usize, G: LieGroup<N>>(tangent: &SVector<f64, N>) {
    let product = G::left_jacobian(tangent) * G::left_jacobian_inverse(tangent);
    assert!((product - SMatrix::<f64, N, N>::identity()).amax() < 1e-11);
}

proptest! {
    #[test]
    fn rotations_form_a_group(a in rotation_vector(), b in rotation_vector(), c in rotation_vector()) {
        group_axioms::<3, So3>(&so3::exp(&a), &so3::exp(&b), &so3::exp(&c));
        adjoint_is_a_homomorphism::<3, So3>(&so3::exp(&a), &so3::exp(&b));
    }

    #[test]
    fn rigid_motions_form_a_group(a in pose(), b in pose(), c in pose()) {
        group_axioms::<6, Se3>(&a, &b, &c);
        adjoint_is_a_homomorphism::<6, Se3>(&a, &b);
    }

    #[test]
    fn exp_and_log_of_rotations_are_inverse(w in rotation_vector()) {
        exp_and_log_are_inverse::<3, So3>(&so3::exp(&w));
    }

    #[test]
    fn exp_and_log_of_rigid_motions_are_inverse(a in pose()) {
        exp_and_log_are_inverse::<6, Se3>(&a);
    }

    #[test]
    fn exp_is_a_one_parameter_subgroup_of_both(w in rotation_vector(), xi in twist(), s in -1.0..1.0, t in -1.0..1.0) {
        exp_is_a_one_parameter_subgroup::<3, So3>(&w, s, t);
        exp_is_a_one_parameter_subgroup::<6, Se3>(&xi, s, t);
    }

    #[test]
    fn adjoints_move_steps_across(w in rotation_vector(), dw in vector::<3>(1.0), a in pose(), d in vector::<6>(1.0)) {
        adjoint_moves_a_step_across::<3, So3>(&so3::exp(&w), &dw);
        adjoint_moves_a_step_across::<6, Se3>(&a, &d);
    }

    #[test]
    fn left_jacobians_are_derivatives_of_exp(w in rotation_vector(), xi in twist()) {
        left_jacobian_is_the_derivative_of_exp::<3, So3>(&w);
        left_jacobian_is_the_derivative_of_exp::<6, Se3>(&xi);
    }

    #[test]
    fn left_jacobians_and_their_inverses_cancel(w in rotation_vector(), xi in twist()) {
        left_jacobian_and_inverse_cancel::<3, So3>(&w);
        left_jacobian_and_inverse_cancel::<6, Se3>(&xi);
    }

    #[test]
    fn log_keeps_the_relative_precision_of_tiny_rotations(w in rotation_vector(), exponent in -300.0..-2.0) {
        let w = w * 10_f64.powf(exponent);
        let off = (so3::log(&so3::exp(&w)) - w).norm();
        prop_assert!(off <= 1e-14 * w.norm());
    }

    #[test]
    fn log_is_never_longer_than_pi(w in vector::<3>(20.0)) {
        let log = so3::log(&so3::exp(&w));
        prop_assert!(log.norm() <= std::f64::consts::PI + 1e-15);
        prop_assert!(so3::exp(&log).angle_to(&so3::exp(&w)) < 1e-7);
    }

    #[test]
    fn the_exponential_agrees_with_nalgebra(w in rotation_vector()) {
        let theirs = UnitQuaternion::from_scaled_axis(w);
        prop_assert!((so3::exp(&w).coords - theirs.coords).amax() < 1e-15 * 4.0);
    }

    #[test]
    fn hat_is_the_cross_product(a in vector::<3>(5.0), b in vector::<3>(5.0)) {
        prop_assert_eq!(so3::hat(&a) * b, a.cross(&b));
    }

    #[test]
    fn perturb_and_difference_are_inverse(truth in pose(), estimate in pose(), step in vector::<6>(1.5)) {
        let reached = se3::perturb(&truth, &se3::difference(&estimate, &truth));
        prop_assert!(Se3::distance(&reached, &estimate) < TOLERANCE);
        let measured = se3::difference(&se3::perturb(&truth, &step), &truth);
        prop_assert!((measured - step).amax() < TOLERANCE);
    }
}

#[test]
fn a_half_turn_has_a_logarithm_of_length_pi() {
    for axis in [
        Vector3::x(),
        -Vector3::y(),
        Vector3::new(1.0, 1.0, 0.0).normalize(),
    ] {
        let half_turn = so3::exp(&(axis * std::f64::consts::PI));
        let log = so3::log(&half_turn);
        assert!((log.norm() - std::f64::consts::PI).abs() < 1e-15);
        assert!(log.cross(&axis).norm() < 1e-15);
    }
}
