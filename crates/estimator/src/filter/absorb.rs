//! From the best pose to the whole state: the corners see the pose only, the twist follows by its correlation.
//!
//! With P the prior covariance, M its columns of the pose, L = J^T W J the information of the corners and C the Cholesky
//! factor of the pose's block: P⁺ = P - M C⁻ᵀ (I - B⁻¹) C⁻¹ Mᵀ with B = I + Cᵀ L C. B's eigenvalues are at least one,
//! so the form holds for vague and for sharp priors alike.

use nalgebra::{Cholesky, Const, Matrix6, SMatrix};
use sextant_geometry::{se3, so3};

use super::kinematics::{Covariance, Kinematics, symmetric};
use super::solve::{Fit, Prior};

type Factor = Cholesky<f64, Const<6>>;

/// The prior of the pose alone, with the factor of its covariance; `None` where that is not positive definite.
pub(crate) fn pose_prior(state: &Kinematics) -> Option<(Prior, Factor)> {
    let factor = Cholesky::new(state.covariance.fixed_view::<6, 6>(0, 0).into_owned())?;
    Some((
        Prior {
            pose: state.pose,
            information: factor.inverse(),
        },
        factor,
    ))
}

/// A state that has taken a fit in.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Absorbed {
    pub state: Kinematics,
    /// ln det(I + P L): how much the corners narrowed the prior; its half is the Occam factor of the evidence.
    pub narrowing: f64,
}

/// The state after the fit; `None` where numbers end.
pub(crate) fn absorb(before: &Kinematics, fit: &Fit) -> Option<Absorbed> {
    let off = se3::difference(&fit.pose, &before.pose);
    let prior_factor = Cholesky::new(before.covariance.fixed_view::<6, 6>(0, 0).into_owned())?;
    let pull = before.covariance.fixed_view::<6, 6>(6, 0) * prior_factor.solve(&off);
    let moved = reset(&before.covariance, &off.fixed_rows::<3>(3).into_owned());
    let (covariance, narrowing) = narrowed(&moved, &fit.corners.information)?;
    let state = Kinematics {
        pose: fit.pose,
        twist: before.twist + pull,
        covariance,
    };
    state.is_finite().then_some(Absorbed { state, narrowing })
}

/// The prior covariance about the new attitude: dr' = J_l(off) dr.
fn reset(covariance: &Covariance, turn: &nalgebra::Vector3<f64>) -> Covariance {
    let jacobian = so3::left_jacobian(turn);
    let mut rows = *covariance;
    rows.fixed_rows_mut::<3>(3)
        .copy_from(&(jacobian * covariance.fixed_rows::<3>(3)));
    let mut both = rows;
    both.fixed_columns_mut::<3>(3)
        .copy_from(&(rows.fixed_columns::<3>(3) * jacobian.transpose()));
    both
}

fn narrowed(prior: &Covariance, information: &Matrix6<f64>) -> Option<(Covariance, f64)> {
    let c = Factor::new(prior.fixed_view::<6, 6>(0, 0).into_owned())?.unpack();
    let b = Factor::new(symmetric(
        &(Matrix6::identity() + c.transpose() * information * c),
    ))?;
    let narrowing = 2.0 * b.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let kept = b.inverse();
    let cross = c.solve_lower_triangular(&prior.fixed_view::<6, 6>(0, 6).into_owned())?;
    let pose = c * kept * c.transpose();
    let pose_twist = c * kept * cross;
    let twist =
        prior.fixed_view::<6, 6>(6, 6) - cross.transpose() * (Matrix6::identity() - kept) * cross;
    let mut after: SMatrix<f64, 12, 12> = Covariance::zeros();
    after.fixed_view_mut::<6, 6>(0, 0).copy_from(&pose);
    after.fixed_view_mut::<6, 6>(0, 6).copy_from(&pose_twist);
    after
        .fixed_view_mut::<6, 6>(6, 0)
        .copy_from(&pose_twist.transpose());
    after.fixed_view_mut::<6, 6>(6, 6).copy_from(&twist);
    Some((symmetric(&after), narrowing))
}
