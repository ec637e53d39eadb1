//! The other branch of the planar ambiguity, for a track that is already followed.
//!
//! A tag seen by one camera looks almost the same when tilted the other way. While it turns through the frontal view both
//! ways are open, so the filter's single minimum is not enough: the mirrored attitude is tried under the same prediction.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Pose, se3};

use super::birth::area;
use super::restlessness;
use crate::FusionOptions;
use crate::filter::corners::Sight;
use crate::filter::kinematics::Kinematics;
use crate::filter::solve::{Prior, UNSEEN};

/// An attitude worth trying.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mirrored {
    pub pose: Pose,
    /// Logarithm of its odds against the attitude found, as it is: its own minimum may be better.
    pub odds: f64,
}

/// The mirrored attitude, where all views come from one camera and the prediction does not exclude it.
pub(crate) fn worth_trying(
    predicted: &Kinematics,
    found: &Pose,
    sights: &[Sight<'_>],
    options: &FusionOptions,
) -> Option<Mirrored> {
    let camera = sights.first()?.camera_index;
    if sights.iter().any(|sight| sight.camera_index != camera) {
        return None;
    }
    let largest = sights.iter().max_by(|a, b| area(a).total_cmp(&area(b)))?;
    let pose = mirrored(largest, found);
    let prior = predicted.observed(camera, restlessness(options)).prior()?;
    let off = se3::difference(&pose, &prior.pose);
    // Twice the odds as chi-square, twice again because the minimum lies nearer to the prediction than the mirror image.
    if off.dot(&(prior.information * off)) > 4.0 * options.hopeless_odds {
        return None;
    }
    let cost = |pose: &Pose| cost(&prior, sights, pose, options);
    Some(Mirrored {
        pose,
        odds: 0.5 * (cost(found) - cost(&pose)),
    })
}

/// Twice the cost of a pose, each view's limited by its gate.
fn cost(prior: &Prior, sights: &[Sight<'_>], pose: &Pose, options: &FusionOptions) -> f64 {
    let off = se3::difference(pose, &prior.pose);
    let chi2 = |sight: &Sight<'_>| sight.normal(pose).map_or(UNSEEN, |normal| normal.chi2);
    let views: f64 = sights
        .iter()
        .map(|sight| chi2(sight).min(options.tag_gate))
        .sum();
    off.dot(&(prior.information * off)) + views
}

/// With the tag mirrored in the plane through its centre across the line of sight: R' = (I - 2 d dᵀ) R diag(1, 1, -1).
fn mirrored(sight: &Sight<'_>, world_from_object: &Pose) -> Pose {
    let camera_from_tag = sight.camera_from_tag(world_from_object);
    let towards = camera_from_tag.translation.vector.normalize();
    let across = Matrix3::identity() - towards * towards.transpose() * 2.0;
    let turned = camera_from_tag.rotation.to_rotation_matrix();
    let flipped = across * turned.matrix() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(flipped));
    let camera_from_flipped = Pose::from_parts(camera_from_tag.translation, rotation);
    sight.camera.camera_from_world.inverse()
        * camera_from_flipped
        * sight.view.object_from_tag.inverse()
}
