//! Kinds of faults: how each displaces what a camera sees, and how large it may be.
//!
//! A fault with parameters x displaces the link that a view shows by T x, so that the residuals of the view are r = -K T x with the
//! derivatives K of the corners by the link's pose. With the information N = K' W K and the gradient g = K' W r of the view the normal
//! equations of the parameters are T' N T and -T' g.

pub(crate) mod camera;
pub(crate) mod clock;
pub(crate) mod tag_pose;
pub(crate) mod tag_size;

use nalgebra::{SMatrix, SVector};

use crate::measurement::pose_innovation::PoseInnovation;

/// A kind of fault with D parameters.
pub(crate) trait FaultModel<const D: usize> {
    /// Prior standard deviation of each parameter.
    const PRIOR: [f64; D];
    /// Views after which the information of a view counts 1/e.
    const MEMORY: f64;
    /// Share of the squared residuals that the fault may leave unexplained.
    const UNEXPLAINED: f64;

    /// Displacement (dt, dr) of the view's link in world axes, m and rad, for one unit of each parameter.
    fn jacobian(innovation: &PoseInnovation) -> SMatrix<f64, 6, D>;

    /// Variances of the parameters that are given in the files of the site; zero where none are.
    fn given_variance(_: &PoseInnovation) -> SVector<f64, D> {
        SVector::zeros()
    }

    /// The normal equations of the parameters by one view.
    fn equations(innovation: &PoseInnovation) -> FaultEquations<D> {
        let jacobian = Self::jacobian(innovation);
        FaultEquations {
            information: jacobian.transpose() * (innovation.information * jacobian),
            gradient: -(jacobian.transpose() * innovation.gradient),
            given_variance: Self::given_variance(innovation),
        }
    }
}

/// Normal equations of the parameters of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FaultEquations<const D: usize> {
    pub information: SMatrix<f64, D, D>,
    /// Of the log-likelihood by the parameters at zero.
    pub gradient: SVector<f64, D>,
    /// Variances of the parameters that are given in the files of the site.
    pub given_variance: SVector<f64, D>,
}
