//! A tag whose size is not that in the object file.

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::fault_model::{FaultModel, first_of_tag};
use crate::diagnosis::window::WindowEquations;
use crate::self_calibration::parameters::SIZE;
use sextant_site_model::TagId;

/// Logarithm of the tag's size over that in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TagSizeFault {
    pub tag: TagId,
}

impl FaultModel for TagSizeFault {
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>> {
        let first = first_of_tag(&self.tag, equations)? + SIZE;
        Some(vec![vec![first]])
    }

    fn prior(&self) -> &'static [f64] {
        &[0.1]
    }

    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        _: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool {
        parameters[0].abs() > options.tag_size
    }
}
