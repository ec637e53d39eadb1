//! A camera that is not where the rig file has it.

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::{FaultModel, each};
use crate::diagnosis::window::WindowEquations;

/// Displacement (dt, dr) of the camera about its centre, world axes, m and rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct CameraPoseFault {
    /// Index of the camera.
    pub camera: usize,
}

impl FaultModel for CameraPoseFault {
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>> {
        let first = *equations.layout.cameras.get(&self.camera)?;
        Some(each(first..first + 6))
    }

    fn prior(&self) -> &'static [f64] {
        &[0.1; 6]
    }

    /// By the angles by which the displacement moves the direction of the body and turns it.
    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        equations: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool {
        let Some(arm) = equations.arms.get(&self.camera) else {
            return false;
        };
        let (translation, rotation) =
            (parameters.fixed_rows::<3>(0), parameters.fixed_rows::<3>(3));
        let step = translation + rotation.cross(arm);
        step.norm() > options.camera_angle * arm.norm() || rotation.norm() > options.camera_turn
    }
}
