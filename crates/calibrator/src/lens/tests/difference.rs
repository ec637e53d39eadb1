//! How far two lenses differ.

use nalgebra::{Matrix3, Point2, UnitQuaternion, Vector3};
use sextant_geometry::Lens;

/// Mean distance, over the picture, between where two lenses show the same ray; the second camera may be turned as a
/// whole, as the calibration of its pose would turn it.
pub(super) fn mean_difference(truth: &Lens, found: &Lens) -> f64 {
    let rays: Vec<_> = (0..32 * 24)
        .map(|at| {
            Point2::new(
                f64::from(at % 32) * 20.0 + 10.0,
                f64::from(at / 32) * 20.0 + 10.0,
            )
        })
        .map(|pixel| (pixel, truth.unproject(&pixel).unwrap()))
        .collect();
    let mut turn = UnitQuaternion::identity();
    for _ in 0..3 {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (pixel, ray) in &rays {
            let turned = turn * ray;
            let (seen, by_point) = found.project_with_jacobian(&turned.into()).unwrap();
            let by_turn = -by_point * turned.cross_matrix();
            normal += by_turn.transpose() * by_turn;
            right += by_turn.transpose() * (pixel - seen);
        }
        turn = UnitQuaternion::from_scaled_axis(normal.try_inverse().unwrap() * right) * turn;
    }
    let differences = rays
        .iter()
        .map(|(pixel, ray)| (found.project(&(turn * ray).into()).unwrap() - pixel).norm());
    differences.sum::<f64>() / rays.len() as f64
}
