//! A tag that is not where the object file has it.

use nalgebra::{Matrix6, Vector6};
use sextant_geometry::so3;

use super::FaultModel;
use crate::measurement::pose_innovation::PoseInnovation;

/// Displacement (dt, dr) of the tag on its object about the tag's centre, axes of the tag, m and rad.
pub(crate) struct TagPoseFault;

impl FaultModel<6> for TagPoseFault {
    const PRIOR: [f64; 6] = [0.02, 0.02, 0.02, 0.2, 0.2, 0.2];
    /// Twice that of a camera: several cameras see a tag.
    const MEMORY: f64 = 60.0;
    const UNEXPLAINED: f64 = 0.03;

    fn jacobian(innovation: &PoseInnovation) -> Matrix6<f64> {
        let tag = &innovation.world_from_tag;
        let rotation = tag.rotation.to_rotation_matrix().into_inner();
        let arm = so3::hat(&(innovation.link_origin() - tag.translation.vector));
        let mut jacobian = Matrix6::zeros();
        for (row, column, block) in [(0, 0, rotation), (3, 3, rotation), (0, 3, -arm * rotation)] {
            let mut view = jacobian.fixed_view_mut::<3, 3>(row, column);
            view.copy_from(&block);
        }
        jacobian
    }

    fn given_variance(innovation: &PoseInnovation) -> Vector6<f64> {
        innovation.tag_variance
    }
}
