//! A tag that is not where the object file has it.

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::{FaultModel, each, first_of_tag};
use crate::diagnosis::window::WindowEquations;
use sextant_site_model::TagId;

/// Displacement (dt, dr) of the tag on its object about the tag's centre, axes of the object, m and rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TagPoseFault {
    pub tag: TagId,
}

impl FaultModel for TagPoseFault {
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>> {
        let first = first_of_tag(&self.tag, equations)?;
        Some(each(first..first + 6))
    }

    fn prior(&self) -> &'static [f64] {
        &[0.02, 0.02, 0.02, 0.2, 0.2, 0.2]
    }

    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        _: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool {
        parameters.rows(0, 3).norm() > options.tag_position
            || parameters.rows(3, 3).norm() > options.tag_turn
    }
}
