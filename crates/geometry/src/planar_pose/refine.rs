//! Refinement of a tag's pose on its corners' reprojection error in pixels, through the real lens.

use super::{PlanarPose, UNIT_SIZE};
use crate::least_squares::{NormalEquations, Options, Problem, minimise};
use crate::lens::Lens;
use crate::pose::Pose;
use crate::{se3, so3, tag_frame};
use nalgebra::{Matrix2x6, Point2, Point3, Vector3, Vector6};

/// Residuals are in pixels here, and the last step lowers their squares by less than 1e-14. Five to ten steps are
/// usual; where the two branches are about to merge, the valley between them is flat and takes dozens.
const OPTIONS: Options = Options {
    max_iterations: 50,
    tolerance: 1e-14,
    initial_damping: 1e-6,
};

struct Reprojection<'a> {
    lens: &'a Lens,
    corners_in_tag: [Point3<f64>; 4],
    corners_in_image: &'a [Point2<f64>; 4],
}

/// The nearest minimum of the reprojection error from `start`, in units of half the tag's edge; `None` if the start
/// cannot be projected or the minimum shows the tag's back.
pub(super) fn refine(
    lens: &Lens,
    corners_in_image: &[Point2<f64>; 4],
    start: &Pose,
) -> Option<PlanarPose> {
    let corners_in_tag = tag_frame::tag_corners_in_tag(UNIT_SIZE);
    let problem = Reprojection {
        lens,
        corners_in_tag,
        corners_in_image,
    };
    let solution = minimise(&problem, *start, &OPTIONS).ok()?;
    if !shows_its_face(&solution.state) {
        return None;
    }
    // The cost is half the sum over four corners of the squared distance.
    Some(PlanarPose {
        camera_from_tag: solution.state,
        rms_px: (0.5 * solution.cost).sqrt(),
    })
}

/// Corners that are far from any tag's may be explained best by its back.
fn shows_its_face(camera_from_tag: &Pose) -> bool {
    let normal_in_camera = camera_from_tag.rotation * Vector3::z();
    normal_in_camera.dot(&camera_from_tag.translation.vector) < 0.0
}

impl Problem<6> for Reprojection<'_> {
    type State = Pose;

    fn linearise(&self, camera_from_tag: &Pose, equations: &mut NormalEquations<6>) -> Option<()> {
        for (corner, seen) in self.corners_in_tag.iter().zip(self.corners_in_image) {
            let arm = camera_from_tag.rotation * corner.coords;
            let corner_in_camera = Point3::from(camera_from_tag.translation.vector + arm);
            let (pixel, pixel_by_point) = self.lens.project_with_jacobian(&corner_in_camera)?;
            // A step (dt, dr) moves the corner by dt + dr x arm.
            let mut jacobian = Matrix2x6::zeros();
            jacobian
                .fixed_view_mut::<2, 3>(0, 0)
                .copy_from(&pixel_by_point);
            jacobian
                .fixed_view_mut::<2, 3>(0, 3)
                .copy_from(&(-pixel_by_point * so3::hat(&arm)));
            equations.add_unweighted(&(pixel - seen), &jacobian);
        }
        Some(())
    }

    fn step(&self, camera_from_tag: &Pose, step: &Vector6<f64>) -> Pose {
        se3::perturb(camera_from_tag, step)
    }
}
