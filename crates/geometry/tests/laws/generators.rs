//! Random vectors, poses and lenses.

use nalgebra::{Point2, SVector, Vector3};
use proptest::prelude::*;
use sextant_geometry::{Intrinsics, Lens, Pose, se3, so3};
use std::f64::consts::PI;

/// A vector with entries in [-`bound`, `bound`].
pub fn vector<const N: usize>(bound: f64) -> impl Strategy<Value = SVector<f64, N>> {
    prop::array::uniform(-bound..bound).prop_map(SVector::from)
}

/// A rotation vector of any direction whose length is zero, tiny, ordinary, or pi up to a tiny difference.
pub fn rotation_vector() -> impl Strategy<Value = Vector3<f64>> {
    let direction = vector::<3>(1.0).prop_filter_map("has a direction", |v| v.try_normalize(1e-3));
    let tiny = (-16.0..-3.0).prop_map(|exponent: f64| 10_f64.powf(exponent));
    let length = prop_oneof![
        1 => Just(0.0),
        3 => tiny.clone(),
        6 => 1e-3..PI,
        3 => tiny.prop_map(|below| PI - below),
    ];
    (direction, length).prop_map(|(direction, length)| direction * length)
}

/// A pose within some metres of the origin.
pub fn pose() -> impl Strategy<Value = Pose> {
    (vector::<3>(5.0), rotation_vector())
        .prop_map(|(position, rotation)| Pose::from_parts(position.into(), so3::exp(&rotation)))
}

/// A twist `(v, w)` with `|w| < pi`.
pub fn twist() -> impl Strategy<Value = SVector<f64, 6>> {
    pose().prop_map(|pose| se3::log(&pose))
}

/// Lenses as calibrations give them.
pub fn lens() -> impl Strategy<Value = Lens> {
    lens_with_distortion(1.0)
}

/// Lenses of all models, their distortion up to `strength` times that of ordinary ones.
pub fn lens_with_distortion(strength: f64) -> impl Strategy<Value = Lens> {
    let brown =
        (intrinsics(), prop::array::uniform5(-strength..strength)).prop_map(|(intrinsics, k)| {
            let scale = [0.4, 0.2, 0.005, 0.005, 0.05];
            Lens::brown_conrady(intrinsics, std::array::from_fn(|i| k[i] * scale[i])).unwrap()
        });
    let kannala =
        (intrinsics(), prop::array::uniform4(-strength..strength)).prop_map(|(intrinsics, k)| {
            let scale = [0.1, 0.05, 0.02, 0.01];
            Lens::kannala_brandt(intrinsics, std::array::from_fn(|i| k[i] * scale[i])).unwrap()
        });
    let pinhole = intrinsics().prop_map(|intrinsics| Lens::pinhole(intrinsics).unwrap());
    prop_oneof![1 => pinhole, 3 => brown, 3 => kannala]
}

fn intrinsics() -> impl Strategy<Value = Intrinsics> {
    (200.0..1500.0, 0.95..1.05, 200.0..700.0, 150.0..500.0).prop_map(|(fx, aspect, cx, cy)| {
        Intrinsics {
            fx,
            fy: fx * aspect,
            cx,
            cy,
        }
    })
}

/// A lens and a normalised point inside its field, and at most `max_radius` from its axis.
pub fn lens_and_point(
    strength: f64,
    max_radius: f64,
) -> impl Strategy<Value = (Lens, Point2<f64>)> {
    (lens_with_distortion(strength), 0.0..0.999, -PI..PI).prop_map(
        move |(lens, fraction, direction): (Lens, f64, f64)| {
            let radius = fraction * lens.max_radius().min(max_radius);
            (
                lens,
                Point2::new(radius * direction.cos(), radius * direction.sin()),
            )
        },
    )
}
