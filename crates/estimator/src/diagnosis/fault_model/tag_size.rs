//! A tag whose size is not that in the object file.

use nalgebra::Vector6;

use super::FaultModel;
use crate::measurement::pose_innovation::PoseInnovation;

/// Share by which the tag is larger: it looks as if it were nearer by that share of its distance.
pub(crate) struct TagSizeFault;

impl FaultModel<1> for TagSizeFault {
    const PRIOR: [f64; 1] = [0.1];
    /// As of the tag's pose.
    const MEMORY: f64 = 60.0;
    const UNEXPLAINED: f64 = 0.03;

    fn jacobian(innovation: &PoseInnovation) -> Vector6<f64> {
        let away = innovation.world_from_tag.translation.vector - innovation.centre;
        Vector6::new(-away.x, -away.y, -away.z, 0.0, 0.0, 0.0)
    }
}
