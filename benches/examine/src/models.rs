//! Building blocks of random models.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectTag, TagId};
use sextant_tag_families::Family;

pub fn tag(id: u32, size_m: f64, place: Vector3<f64>, turn: UnitQuaternion<f64>) -> ObjectTag {
    let family = Family::Tag36h11;
    ObjectTag::new(
        TagId { family, id },
        size_m,
        Some(Pose::from_parts(place.into(), turn)),
    )
}

/// Unwraps a model, which is valid by construction.
///
/// # Panics
/// If it is not.
pub fn made<T, E: std::fmt::Debug>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error:?}"))
}
