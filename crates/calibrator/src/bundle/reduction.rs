//! What a bundle says of its kept parameters without being solved: information and slope where it stands.

use super::elimination::Reduced;
use super::equations::Equations;
use super::layout::Layout;
use super::state::{Bundle, BundleError};
use nalgebra::{DMatrix, DVector};
use sextant_geometry::least_squares::Kernel;

/// Over the kept parameters' steps of the solver, cameras before tags (poses: twists of the outer frame), in units of the stated noise, the instants eliminated.
#[derive(Clone, Debug)]
pub(crate) struct Reduction {
    pub information: DMatrix<f64>,
    /// Half the derivative of the sum of squares.
    pub gradient: DVector<f64>,
}

impl Reduction {
    /// # Errors
    /// As for solving.
    pub(crate) fn of(bundle: &Bundle, kernel: &Kernel) -> Result<Self, BundleError> {
        bundle.check()?;
        if bundle.motion.is_some() {
            Self::of_size::<12>(bundle, kernel)
        } else {
            Self::of_size::<6>(bundle, kernel)
        }
    }

    fn of_size<const D: usize>(bundle: &Bundle, kernel: &Kernel) -> Result<Self, BundleError> {
        let layout = Layout::of(bundle);
        let equations = Equations::<D>::of(bundle, &layout, kernel);
        let reduced = Some(equations).filter(Equations::is_finite);
        let reduced = reduced.and_then(|equations| Reduced::of(&equations, 0.0));
        let reduced = reduced.ok_or(BundleError::BadStart)?;
        Ok(Self {
            gradient: reduced.gradient,
            information: reduced.information,
        })
    }
}
