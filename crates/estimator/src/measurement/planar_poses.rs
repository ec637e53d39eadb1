//! The two poses that the corners of one tag allow: the branches of the planar ambiguity.

use sextant_geometry::Pose;
use sextant_geometry::planar_pose::solve_square;

use crate::measurement::corners::WeightedView;

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
