//! A camera whose lens is not that in the rig file.

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::{FaultModel, each};
use crate::diagnosis::window::WindowEquations;
use crate::self_calibration::parameters::{CLOCK, LENS};

/// Error of the focal length, px, and of the first coefficient of the distortion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct LensFault {
    /// Index of the camera.
    pub camera: usize,
}

impl FaultModel for LensFault {
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>> {
        let first = *equations.layout.cameras.get(&self.camera)?;
        Some(each(first + LENS..first + CLOCK))
    }

    fn prior(&self) -> &'static [f64] {
        &[30.0, 0.3]
    }

    /// Self-calibration has moved the tags to where the bent picture shows them, which a straight one contradicts as
    /// well.
    fn explains(&self) -> f64 {
        0.3
    }

    /// By the displacement of the image's corners.
    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        equations: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool {
        let per_px = equations.distortions_per_px.get(&self.camera);
        per_px.is_some_and(|per_px| (parameters[1] / per_px).abs() > options.lens_corner_px)
    }
}
