//! Rows of a view without robust weights: by the pose of its body alone, and by everything that self-calibration and
//! diagnosis estimate.

use nalgebra::{RowVector6, SVector, Vector6};

use crate::measurement::corners::WeightedView;
use crate::measurement::rolling_shutter::LinkMotion;
use crate::measurement::whitening::Rows;
use crate::self_calibration::parameters::{CLOCK, LENS, OF_CAMERA, OF_SCALE, OF_TAG, SIZE};

/// Number of columns by the pose, which come first; the residual comes last.
pub(crate) const OF_POSE: usize = 6;
/// First columns by the errors of the camera, by those of the tag, and by the scale of the object.
pub(crate) const BY_CAMERA: usize = OF_POSE;
pub(crate) const BY_TAG: usize = BY_CAMERA + OF_CAMERA;
pub(crate) const BY_SCALE: usize = BY_TAG + OF_TAG;
pub(crate) const BY_SIZE: usize = BY_TAG + SIZE;
/// Number of columns by all errors.
pub(crate) const ALL: usize = BY_SCALE + OF_SCALE + 1;

/// Whitened rows by a displacement of the body, with the residual.
pub(crate) type PoseRows = Rows<{ OF_POSE + 1 }>;
/// Whitened rows by all errors.
pub(crate) type AllRows = Rows<ALL>;

impl WeightedView<'_> {
    /// Rows by the pose of the body; `None` where the tag cannot be seen from there.
    pub fn pose_rows(&self, link: &LinkMotion) -> Option<PoseRows> {
        let mut rows = [[0.0; OF_POSE + 1]; 8];
        for corner in 0..4 {
            let (_, seen, residual) = self.at_corner(corner, link)?;
            for (axis, slopes) in seen.by_pose().iter().enumerate() {
                let row = &mut rows[2 * corner + axis];
                row[..OF_POSE].copy_from_slice(slopes);
                row[OF_POSE] = residual[axis];
            }
        }
        Some(self.view.whitening.whitened(&rows, self.noise))
    }

    /// Rows by all errors; `twist` is that of the body, m/s and rad/s in world axes.
    pub fn all_rows(&self, link: &LinkMotion, twist: &Vector6<f64>) -> Option<AllRows> {
        let mut rows = [[0.0; ALL]; 8];
        let centre = self.view.object_from_tag.translation.vector;
        for corner in 0..4 {
            let (body, seen, residual) = self.at_corner(corner, link)?;
            let in_object = self.view.corners_in_object[corner].coords;
            let by_lens = self.camera.by_lens(&body.in_camera(&in_object))?;
            let by = body.jacobian(&seen, &(in_object - centre), 1.0);
            for axis in 0..2 {
                let row = &mut rows[2 * corner + axis];
                row[..OF_POSE].copy_from_slice(&by.body[axis]);
                row[BY_CAMERA..BY_CAMERA + LENS].copy_from_slice(&by.camera[axis]);
                row[BY_CAMERA + LENS] = by_lens[(axis, 0)];
                row[BY_CAMERA + LENS + 1] = by_lens[(axis, 1)];
                row[BY_CAMERA + CLOCK] = -(RowVector6::from(by.body[axis]) * twist)[0];
                row[BY_TAG..BY_SIZE].copy_from_slice(&by.tag[axis]);
                row[BY_SIZE] = by.size[axis];
                row[BY_SCALE] = by.scale[axis];
                row[ALL - 1] = residual[axis];
            }
        }
        Some(self.view.whitening.whitened(&rows, self.noise))
    }
}

/// Sum of the squares of the residuals.
pub(crate) fn square<const N: usize>(rows: &Rows<N>) -> f64 {
    SVector::from(rows.map(|row| row[N - 1])).norm_squared()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use sextant_geometry::{Lens, Pose, se3};
    use sextant_site_model::ObjectTag;

    use super::*;
    use crate::filter::tests::{camera, object, small_offsets, still, view, weighted};
    use crate::measurement::corners::{CalibratedCamera, TagView};

    const STEP: f64 = 1e-6;

    fn with_lens(camera: &CalibratedCamera, change: impl Fn(&mut [f64])) -> CalibratedCamera {
        let mut parameters = camera.lens.parameters().to_vec();
        change(&mut parameters);
        let lens: Lens = camera.lens.with_parameters(&parameters).unwrap();
        CalibratedCamera::new(lens, &camera.camera_from_world.inverse(), None)
    }

    fn with_tag(view: &TagView, object_from_tag: Pose, log_size: f64) -> TagView {
        let mut view = view.clone();
        let size_m = view.size_m * log_size.exp();
        view.set_model(&ObjectTag::new(view.tag, size_m, Some(object_from_tag)));
        view
    }

    /// Camera, view and pose of the body after a step of the error of a column.
    fn stepped(
        column: usize,
        by: f64,
        twist: &Vector6<f64>,
        camera: &CalibratedCamera,
        view: &TagView,
    ) -> (CalibratedCamera, TagView, Pose) {
        let pose_step = |first: usize| {
            Vector6::from_fn(|axis, _| if first + axis == column { by } else { 0.0 })
        };
        let world_from_camera = camera.camera_from_world.inverse();
        let place = view.object_from_tag;
        let (mut found_camera, mut found_view, mut pose) = (camera.clone(), view.clone(), object());
        match column {
            0..OF_POSE => pose = se3::perturb(&pose, &pose_step(0)),
            _ if column < BY_CAMERA + LENS => {
                let moved = se3::perturb(&world_from_camera, &pose_step(BY_CAMERA));
                found_camera = CalibratedCamera::new(camera.lens, &moved, None);
            }
            _ if column == BY_CAMERA + LENS => {
                found_camera = with_lens(camera, |p| (0..2).for_each(|at| p[at] += by));
            }
            _ if column == BY_CAMERA + LENS + 1 => found_camera = with_lens(camera, |p| p[4] += by),
            _ if column == BY_CAMERA + CLOCK => pose = se3::perturb(&pose, &(-twist * by)),
            _ if column < BY_SIZE => {
                found_view = with_tag(view, se3::perturb(&place, &pose_step(BY_TAG)), 0.0);
            }
            BY_SIZE => found_view = with_tag(view, place, by),
            _ => {
                let moved: Vector3<f64> = place.translation.vector * by.exp();
                found_view = with_tag(view, Pose::from_parts(moved.into(), place.rotation), by);
            }
        }
        (found_camera, found_view, pose)
    }

    #[test]
    fn all_rows_are_the_derivatives_of_the_residuals() {
        let place = Pose::new(
            Vector3::new(0.02, -0.03, 0.01),
            Vector3::new(0.2, 0.1, -0.3),
        );
        let (camera, twist) = (camera(), Vector6::new(0.3, -0.2, 0.1, 0.5, 1.0, -0.7));
        let view = view(&camera, place, small_offsets());
        let rows = weighted(&camera, &view)
            .all_rows(&still(&object()), &twist)
            .unwrap();
        let residual = |column: usize, by: f64| {
            let (camera, view, pose) = stepped(column, by, &twist, &camera, &view);
            let rows = weighted(&camera, &view).pose_rows(&still(&pose)).unwrap();
            rows.map(|row| row[OF_POSE])
        };
        for column in 0..ALL - 1 {
            let (after, before) = (residual(column, STEP), residual(column, -STEP));
            let slopes = after
                .iter()
                .zip(before)
                .map(|(after, before)| (after - before) / (2.0 * STEP));
            for (slope, row) in slopes.zip(rows) {
                let off = (slope - row[column]).abs();
                assert!(
                    off < 1e-4 * (1.0 + slope.abs()),
                    "{column}: {slope} {}",
                    row[column]
                );
            }
        }
    }
}
