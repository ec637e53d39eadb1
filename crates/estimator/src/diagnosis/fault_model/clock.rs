//! A camera whose timestamps are offset.

use nalgebra::Vector6;

use super::FaultModel;
use crate::measurement::pose_innovation::PoseInnovation;

/// Seconds by which the timestamps lie after the true capture times.
pub(crate) struct ClockFault;

impl FaultModel<1> for ClockFault {
    const PRIOR: [f64; 1] = [0.1];
    const MEMORY: f64 = 30.0;
    /// Several times that of the other faults: the model is linear in the offset with a constant twist, and the twist itself counts while its
    /// standard deviation is up to a fifth of it.
    const UNEXPLAINED: f64 = 0.15;

    fn jacobian(innovation: &PoseInnovation) -> Vector6<f64> {
        -innovation.twist
    }
}
