//! The pose of a square tag from its four corners in one image: both branches of the planar ambiguity.
//!
//! Input: a lens, corners in pixels (top left, top right, bottom right, bottom left), the edge of the black square in
//! metres. Output: `camera_from_tag`, best first. A small or distant square looks almost the same tilted one way or the
//! other, and noise decides which of the two fits better, so both are given with their errors
//! (G. Schweighofer, A. Pinz, Robust pose estimation from a planar target, PAMI 2006).

mod ippe;
mod refine;

use crate::homography::Homography;
use crate::lens::{Lens, UnprojectError};
use crate::pose::Pose;
use crate::{se3, tag_frame};
use nalgebra::{Point2, Vector2};
use refine::refine;

/// Branches nearer than this, in radians and in tag sizes, have run into the same minimum.
const SAME_POSE: f64 = 1e-4;
/// Edges of a tag; the bounds keep positions finite and apart from zero.
const SIZES_M: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
/// The edge for which the inner steps are done, so that their numbers are of the order of one whatever the tag's size.
const UNIT_SIZE: f64 = 2.0;

/// One of the two poses that a planar tag in an image may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPose {
    /// Pose of the tag in the camera frame, metres; the whole tag lies before the camera.
    pub camera_from_tag: Pose,
    /// Root mean square over the four corners of the distance between seen and reprojected corner, pixels.
    pub rms_px: f64,
}

/// One or two branches. Where both run into the same minimum there is only one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPoses {
    best: PlanarPose,
    other: Option<PlanarPose>,
}

impl PlanarPoses {
    /// The branch with the smaller reprojection error.
    pub fn best(&self) -> &PlanarPose {
        &self.best
    }

    /// The other branch, if it is another.
    pub fn other(&self) -> Option<&PlanarPose> {
        self.other.as_ref()
    }

    /// The branches, best first.
    pub fn iter(&self) -> impl Iterator<Item = &PlanarPose> {
        std::iter::once(&self.best).chain(&self.other)
    }
}

/// Why four corners have no pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlanarPoseError {
    /// The tag's edge is no length that a tag can have.
    #[error("tag size {0} m must be between 1e-6 and 1e6")]
    Size(f64),
    /// A corner has no ray.
    #[error("corner {corner}: {cause}")]
    Corner {
        /// 0 to 3 from the top left.
        corner: usize,
        /// Why.
        cause: UnprojectError,
    },
    /// The corners are no convex quadrilateral that runs clockwise, so they are no image of a tag's face.
    #[error("the corners are no convex quadrilateral that runs clockwise from the top left")]
    NotATag,
    /// No pose before the camera explains the corners.
    #[error("no pose before the camera explains the corners")]
    NoPose,
}

/// Both poses of a square tag, best first, each minimising the reprojection error in pixels through the real lens.
///
/// `corners_in_image` in pixels: top left, top right, bottom right, bottom left; `size_m` the edge of the black square.
/// Two starts from the homography, each led to its nearest minimum; all results are finite.
pub fn solve_square(
    lens: &Lens,
    corners_in_image: &[Point2<f64>; 4],
    size_m: f64,
) -> Result<PlanarPoses, PlanarPoseError> {
    if !SIZES_M.contains(&size_m) {
        return Err(PlanarPoseError::Size(size_m));
    }
    let rays = undistort(lens, corners_in_image)?;
    let starts = branches(&rays).ok_or(PlanarPoseError::NotATag)?;
    let refined = starts.map(|start| {
        refine(lens, corners_in_image, &start?).filter(|pose| is_in_field(lens, pose, size_m))
    });
    let unit = order(refined).ok_or(PlanarPoseError::NoPose)?;
    Ok(unit.scaled(size_m / UNIT_SIZE))
}

/// The poses of [`solve_square`], best first; empty where the corners allow none.
///
/// `corners_in_image` in pixels: top left, top right, bottom right, bottom left; `size_m` the edge of the black square.
#[must_use]
pub fn tag_poses(lens: &Lens, corners_in_image: &[Point2<f64>; 4], size_m: f64) -> Vec<PlanarPose> {
    solve_square(lens, corners_in_image, size_m)
        .map(|poses| poses.iter().copied().collect())
        .unwrap_or_default()
}

/// Whether the tag still projects at its own size: a corner on the very end of the valid field may round out of it.
fn is_in_field(lens: &Lens, unit: &PlanarPose, size_m: f64) -> bool {
    let mut camera_from_tag = unit.camera_from_tag;
    camera_from_tag.translation.vector *= size_m / UNIT_SIZE;
    tag_frame::tag_corners_in_tag(size_m)
        .iter()
        .all(|corner| lens.project(&(camera_from_tag * corner)).is_some())
}

fn undistort(lens: &Lens, corners: &[Point2<f64>; 4]) -> Result<[Point2<f64>; 4], PlanarPoseError> {
    let mut rays = [Point2::origin(); 4];
    for (corner, (ray, pixel)) in rays.iter_mut().zip(corners).enumerate() {
        *ray = lens
            .undistort(pixel)
            .map_err(|cause| PlanarPoseError::Corner { corner, cause })?;
    }
    Ok(rays)
}

/// Starting poses of a tag of [`UNIT_SIZE`] from its normalised corners; `None` if they are no tag's.
fn branches(rays: &[Point2<f64>; 4]) -> Option<[Option<Pose>; 2]> {
    if !is_clockwise_and_convex(rays) {
        return None;
    }
    let corners = tag_frame::tag_corners_in_tag(UNIT_SIZE);
    let image_from_tag = Homography::from_corners(&corners.map(|p| p.xy()), rays)?;
    ippe::both_poses(&image_from_tag, &corners, rays)
}

/// With y down, as in images, clockwise turns have a positive cross product.
fn is_clockwise_and_convex(corners: &[Point2<f64>; 4]) -> bool {
    let edge = |i: usize| -> Vector2<f64> { corners[(i + 1) % 4] - corners[i % 4] };
    (0..4).all(|i| edge(i).perp(&edge(i + 1)) > 0.0)
}

fn order(refined: [Option<PlanarPose>; 2]) -> Option<PlanarPoses> {
    match refined {
        [Some(a), Some(b)] if b.rms_px < a.rms_px => Some(pair(b, a)),
        [Some(a), Some(b)] => Some(pair(a, b)),
        [Some(best), None] | [None, Some(best)] => Some(PlanarPoses { best, other: None }),
        [None, None] => None,
    }
}

fn pair(best: PlanarPose, other: PlanarPose) -> PlanarPoses {
    let apart = se3::difference(&other.camera_from_tag, &best.camera_from_tag).amax() > SAME_POSE;
    PlanarPoses {
        best,
        other: apart.then_some(other),
    }
}

impl PlanarPoses {
    fn scaled(mut self, scale: f64) -> Self {
        for pose in std::iter::once(&mut self.best).chain(&mut self.other) {
            pose.camera_from_tag.translation.vector *= scale;
        }
        self
    }
}
