//! Poses of single tags in the camera, for those who need no fusion.

use nalgebra::Point2;
use sextant_geometry::Lens;
use sextant_geometry::planar_pose::{PlanarPose, solve_square};

/// Both branches of the planar ambiguity, best first; empty where the corners allow none.
///
/// `corners_in_image` run clockwise from the top left of the upright tag, in pixels; `size_m` is the black square's edge.
pub fn tag_poses(lens: &Lens, corners_in_image: &[Point2<f64>; 4], size_m: f64) -> Vec<PlanarPose> {
    solve_square(lens, corners_in_image, size_m)
        .map(|poses| poses.iter().cloned().collect())
        .unwrap_or_default()
}
