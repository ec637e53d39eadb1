//! A camera that is not where the rig file has it.

use nalgebra::{Matrix6, Vector6};
use sextant_geometry::so3;

use super::FaultModel;
use crate::measurement::pose_innovation::PoseInnovation;

/// Displacement (dt, dr) of the camera about its centre, world axes, m and rad.
pub(crate) struct CameraPoseFault;

impl FaultModel<6> for CameraPoseFault {
    const PRIOR: [f64; 6] = [0.1; 6];
    const MEMORY: f64 = 30.0;
    const UNEXPLAINED: f64 = 0.03;

    fn jacobian(innovation: &PoseInnovation) -> Matrix6<f64> {
        let mut jacobian = -Matrix6::identity();
        let arm = so3::hat(&(innovation.link_origin() - innovation.centre));
        jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&arm);
        jacobian
    }

    fn given_variance(innovation: &PoseInnovation) -> Vector6<f64> {
        innovation.camera_variance
    }
}

/// Angle by which a displacement of the camera moves the direction in which it sees a tag, and angle by which it turns the tag; rad.
pub(crate) fn apparent_angles(
    innovation: &PoseInnovation,
    displacement: &Vector6<f64>,
) -> [f64; 2] {
    let (translation, rotation) = (
        displacement.fixed_rows::<3>(0),
        displacement.fixed_rows::<3>(3),
    );
    let line_of_sight = innovation.world_from_tag.translation.vector - innovation.centre;
    let step = translation + rotation.cross(&line_of_sight);
    let distance = line_of_sight.norm().max(1e-9);
    [step.norm() / distance, rotation.norm()]
}
