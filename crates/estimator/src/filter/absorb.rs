//! From the pose that the corners show to the whole state: they see the pose only, the rest follows by its correlation.
//!
//! The seen pose is a linear function of the state. With S its prior covariance, M its covariance with the state,
//! L = J^T W J the information of the corners and C the Cholesky factor of S:
//! P⁺ = P - Mᵀ C⁻ᵀ (I - B⁻¹) C⁻¹ M with B = I + Cᵀ L C. B's eigenvalues are at least one, so the form holds for vague and
//! for sharp priors alike.

use nalgebra::{Cholesky, Const, Matrix6, Vector3};
use sextant_geometry::{se3, so3};

use super::clocks::Observed;
use super::kinematics::{Kinematics, symmetric};
use super::motion::Innovation;
use super::solve::{Fit, Prior};

type Factor = Cholesky<f64, Const<6>>;

impl Observed {
    /// What is known about the seen pose before; `None` where its covariance is not positive definite.
    pub fn prior(&self) -> Option<Prior> {
        let information = Factor::new(self.covariance)?.inverse();
        Some(Prior {
            pose: self.pose,
            information,
        })
    }
}

/// A state that has taken a fit in.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Absorbed {
    pub state: Kinematics,
    /// ln det(I + S L): how much the corners narrowed the prior; its half is the Occam factor of the evidence.
    pub narrowing: f64,
}

/// The state after the fit to what the camera saw; `None` where numbers end.
pub(crate) fn absorb(before: &Kinematics, camera_index: usize, fit: &Fit) -> Option<Absorbed> {
    let expected = before.observed(camera_index);
    let off = se3::difference(&fit.pose, &expected.pose);
    let pull = Factor::new(expected.covariance)?.solve(&off);
    let step = expected.with_motion.transpose() * pull;
    let mut state = before.clone();
    state.pose = se3::perturb(&before.pose, &step.fixed_rows::<6>(0).into_owned());
    state.twist += step.fixed_rows::<6>(6);
    if let Some(clocks) = &mut state.clocks {
        clocks.shift(&(expected.with_clocks.transpose() * pull));
    }
    reset(&mut state, &step.fixed_rows::<3>(3).into_owned());
    let expected = state.observed(camera_index);
    let (narrowing, weight) = narrow(&mut state, &expected, &fit.corners.information)?;
    let innovation = Innovation {
        pull,
        weight,
        expected: expected.covariance,
    };
    state.motion.learn(&innovation);
    state.is_finite().then_some(Absorbed { state, narrowing })
}

/// The prior covariance about the new attitude: dr' = J_l(turn) dr.
fn reset(state: &mut Kinematics, turn: &Vector3<f64>) {
    let jacobian = so3::left_jacobian(turn);
    let rows = jacobian * state.covariance.fixed_rows::<3>(3);
    state.covariance.fixed_rows_mut::<3>(3).copy_from(&rows);
    let columns = state.covariance.fixed_columns::<3>(3) * jacobian.transpose();
    state
        .covariance
        .fixed_columns_mut::<3>(3)
        .copy_from(&columns);
    if let Some(clocks) = &mut state.clocks {
        let rows = jacobian * clocks.cross.fixed_rows::<3>(3);
        clocks.cross.fixed_rows_mut::<3>(3).copy_from(&rows);
    }
}

/// Takes the information in; returns its narrowing and the inverse of the innovation's covariance.
fn narrow(
    state: &mut Kinematics,
    expected: &Observed,
    information: &Matrix6<f64>,
) -> Option<(f64, Matrix6<f64>)> {
    let c = Factor::new(expected.covariance)?.unpack();
    let b = Factor::new(symmetric(
        &(Matrix6::identity() + c.transpose() * information * c),
    ))?;
    let taken = Matrix6::identity() - b.inverse();
    let motion = c.solve_lower_triangular(&expected.with_motion)?;
    let by_motion = taken * motion;
    state.covariance = symmetric(&(state.covariance - motion.transpose() * by_motion));
    if let Some(clocks) = &mut state.clocks {
        let own = c.solve_lower_triangular(&expected.with_clocks)?;
        clocks.cross -= by_motion.transpose() * own;
        clocks.own = symmetric(&(clocks.own - own.transpose() * taken * own));
    }
    let narrowing = 2.0 * b.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let whitened = c.solve_lower_triangular(&Matrix6::identity())?;
    Some((narrowing, whitened.transpose() * taken * whitened))
}
