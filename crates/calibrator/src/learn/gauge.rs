//! The frame of a learned object, and the standard deviations of its tags in that frame.

use nalgebra::{DMatrix, Matrix6, SMatrix, UnitQuaternion, Vector3};
use sextant_geometry::{Pose, so3};
use sextant_site_model::TagId;

/// Frame of a learned object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Gauge {
    /// Origin at the centroid of the tags, axes of the best visible tag. Standard deviations are those that remain
    /// after aligning the whole constellation.
    #[default]
    Centroid,
    /// Frame of this tag; standard deviations are relative to it.
    Tag(TagId),
}

/// The mean position of poses.
pub(crate) fn centroid(poses: &[Pose]) -> Vector3<f64> {
    let sum: Vector3<f64> = poses.iter().map(|pose| pose.translation.vector).sum();
    sum / poses.len().max(1) as f64
}

/// Covariance of every tag's pose after the constellation is aligned as a whole: removes the common rigid motion from
/// the errors (inner constraints; W. Baarda, S-transformations and criterion matrices, 1973).
pub(crate) fn aligned(covariance: &DMatrix<f64>, poses: &[Pose]) -> DMatrix<f64> {
    let n = poses.len();
    let middle = centroid(poses);
    // A rigid motion (d, r) about the centroid moves a tag by d + r x (t - centroid) and rotates it by r.
    let mut rigid = DMatrix::<f64>::zeros(6 * n, 6);
    let mut fit = DMatrix::<f64>::zeros(6, 6 * n);
    for (tag, pose) in poses.iter().enumerate() {
        let arm = pose.translation.vector - middle;
        let mut block = Matrix6::<f64>::identity();
        block
            .fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&-so3::hat(&arm));
        rigid.fixed_rows_mut::<6>(6 * tag).copy_from(&block);
        // Aligned on the tags' corners: positions and, weighted by the tag's arm, attitudes.
        let mut weight = Matrix6::<f64>::identity();
        for axis in 3..6 {
            weight[(axis, axis)] = TAG_ARM_M * TAG_ARM_M;
        }
        let weighted: SMatrix<f64, 6, 6> = block.transpose() * weight;
        fit.fixed_columns_mut::<6>(6 * tag).copy_from(&weighted);
    }
    let Some(inverse) = (&fit * &rigid).try_inverse() else {
        return covariance.clone();
    };
    let rest = DMatrix::identity(6 * n, 6 * n) - rigid * (inverse * fit);
    &rest * covariance * rest.transpose()
}

/// Covariance of every tag's pose when the object's frame is rotated: steps of poses are along the axes of that frame
/// (FRAMES.md).
pub(crate) fn turned(
    covariance: &DMatrix<f64>,
    new_from_old: &UnitQuaternion<f64>,
) -> DMatrix<f64> {
    let matrix = new_from_old.to_rotation_matrix();
    let mut turn = DMatrix::<f64>::zeros(covariance.nrows(), covariance.nrows());
    for first in (0..covariance.nrows()).step_by(3) {
        turn.fixed_view_mut::<3, 3>(first, first)
            .copy_from(matrix.matrix());
    }
    &turn * covariance * turn.transpose()
}

/// Mean arm of a corner about its tag's axes, for alignment: that of a tag of about 4 cm.
const TAG_ARM_M: f64 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn what_is_vague_along_an_axis_stays_so_along_the_same_way_in_a_turned_frame() {
        let old = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 1.0, 9.0, 4.0, 1.0, 1.0]));
        // The former z axis becomes the x axis, the former x axis the -z axis.
        let new_from_old = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
        let new = turned(&old, &new_from_old);
        let expected =
            DMatrix::from_diagonal(&DVector::from_vec(vec![9.0, 1.0, 1.0, 1.0, 1.0, 4.0]));
        assert!((new - expected).amax() < 1e-12);
    }
}
