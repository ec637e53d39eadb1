//! A camera whose timestamps are offset.

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::FaultModel;
use crate::diagnosis::window::WindowEquations;
use crate::self_calibration::parameters::CLOCK;

/// Seconds by which the timestamps lie after the true capture times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ClockFault {
    /// Index of the camera.
    pub camera: usize,
}

impl FaultModel for ClockFault {
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>> {
        let first = equations.layout.cameras.get(&self.camera)? + CLOCK;
        Some(vec![vec![first]])
    }

    fn prior(&self) -> &'static [f64] {
        &[0.1]
    }

    /// Several times that of a size: the model is linear in the offset with a constant twist.
    fn unexplained(&self) -> f64 {
        0.15
    }

    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        _: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool {
        parameters[0].abs() > options.clock_offset
    }
}
