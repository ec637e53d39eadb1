//! The two poses that the corners of one tag allow: the branches of the planar ambiguity.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_geometry::planar_pose::solve_square;

use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;

/// Share of the turn to the mirrored attitude, and of the way from the camera, within which starts lead to one minimum.
const BESIDE: (f64, f64) = (0.25, 0.03);

/// `world_from_object`, or that of the tag's link, by each branch of a view.
pub(crate) fn branches(weighted: &WeightedView<'_>) -> Vec<Pose> {
    let Ok(poses) = solve_square(
        &weighted.camera.lens,
        &[0, 1, 2, 3].map(|corner| weighted.view.corner(corner, weighted.distortion_share)),
        weighted.view.size_m,
    ) else {
        return Vec::new();
    };
    let world_from_camera = weighted.camera.camera_from_world.inverse();
    let tag_from_object = weighted.view.object_from_tag.inverse();
    poses
        .iter()
        .map(|pose| world_from_camera * pose.camera_from_tag * tag_from_object)
        .collect()
}

/// The view of the largest tag.
pub(crate) fn largest<'v, 'a: 'v>(
    views: impl Iterator<Item = &'v WeightedView<'a>>,
) -> Option<&'v WeightedView<'a>> {
    views.max_by(|a, b| area(a).total_cmp(&area(b)))
}

/// Area of the tag in px², by its diagonals.
pub(crate) fn area(weighted: &WeightedView<'_>) -> f64 {
    let [a, b, c, d] = weighted.view.corners_in_image;
    0.5 * (c - a).perp(&(d - b)).abs()
}

/// With the tag mirrored in the plane through its centre across the line of sight: R' = (I - 2 d dᵀ) R diag(1, 1, -1).
/// Links go with the tag's as one body.
pub(crate) fn mirrored(weighted: &WeightedView<'_>, at: &Configuration) -> Configuration {
    let camera_from_tag = weighted.camera_from_tag(&weighted.view.world_from_link(at));
    let towards = camera_from_tag.translation.vector.normalize();
    let across = Matrix3::identity() - towards * towards.transpose() * 2.0;
    let turned = camera_from_tag.rotation.to_rotation_matrix();
    let flipped = across * turned.matrix() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(flipped));
    let camera_from_flipped = Pose::from_parts(camera_from_tag.translation, rotation);
    let world_from_link = weighted.camera.camera_from_world.inverse()
        * camera_from_flipped
        * weighted.view.object_from_tag.inverse();
    weighted.view.anchored(&world_from_link, at)
}

/// Whether a search that begins at `start` would end where another one is: all links that are seen are far nearer to it
/// than to its mirrored attitude.
pub(crate) fn is_beside(
    start: &Configuration,
    at: &Configuration,
    views: &[WeightedView<'_>],
) -> bool {
    let Some(largest) = largest(views.iter()) else {
        return false;
    };
    let turned = |one: &Configuration| largest.view.world_from_link(one).rotation;
    let apart = turned(&mirrored(largest, at)).angle_to(&turned(at));
    views.iter().all(|weighted| {
        let [here, there] = [start, at].map(|one| weighted.view.world_from_link(one));
        let far = (there.translation.vector - weighted.camera.centre).norm();
        let off = (here.translation.vector - there.translation.vector).norm();
        here.rotation.angle_to(&there.rotation) < BESIDE.0 * apart && off < BESIDE.1 * far
    })
}
