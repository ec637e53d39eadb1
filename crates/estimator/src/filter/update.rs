//! From the configuration that the corners show to the whole state: they see base and joints only, the rest follows by its
//! correlation.
//!
//! The seen configuration is a linear function of the state. With S its prior covariance, M its covariance with the state,
//! L = J^T W J the information of the corners and C the Cholesky factor of S:
//! P⁺ = P - Mᵀ C⁻ᵀ (I - B⁻¹) C⁻¹ M with B = I + Cᵀ L C. B's eigenvalues are at least one, so the form holds for vague and
//! for sharp priors alike.

use nalgebra::{Cholesky, Const, Matrix6, SMatrix, Vector3};
use sextant_geometry::{se3, so3};

use crate::filter::covariance::{CrossCovariance, symmetric};
use crate::filter::least_squares::{Fit, Prior};
use crate::filter::observed_configuration::{ObservationTime, ObservedConfiguration};
use crate::filter::process_noise::Innovation;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::joint_places;
use crate::measurement::biases::BiasJacobian;
use crate::measurement::corners::WeightedView;

type Factor<const D: usize> = Cholesky<f64, Const<D>>;

/// A state that has taken a fit in.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Updated<const D: usize> {
    pub state: ObjectState,
    /// ln det(I + S L): how much the corners narrowed the prior; its half is the Occam factor of the evidence.
    pub narrowing: f64,
    /// M.
    with: CrossCovariance<D>,
    /// (I + S L)⁻¹.
    left: SMatrix<f64, D, D>,
}

impl<const D: usize> Updated<D> {
    /// By how much the parts of the state follow a gradient of the corners: (I + S L)⁻¹ M, transposed. That is H P⁺ where S is no
    /// more than H P Hᵀ.
    pub fn gain(&self) -> CrossCovariance<D> {
        let mut gain = CrossCovariance {
            motion: self.left * self.with.motion,
            joints: SMatrix::zeros(),
            clocks: SMatrix::zeros(),
        };
        if self.state.joints.is_some() {
            gain.joints = self.left * self.with.joints;
        }
        if self.state.clocks.is_some() {
            gain.clocks = self.left * self.with.clocks;
        }
        gain
    }
}

/// The state after the fit to what the camera saw; `None` where numbers end.
pub(crate) fn update<const D: usize>(
    before: &ObjectState,
    vantage: ObservationTime,
    fit: &Fit<D>,
) -> Option<Updated<D>> {
    let expected = before.observed_from::<D>(vantage);
    let off = fit.configuration.difference::<D>(&expected.configuration);
    let pull = Factor::<D>::new(expected.covariance)?.solve(&off);
    let step = expected.with.motion.transpose() * pull;
    let mut state = before.clone();
    state.pose = se3::perturb(&before.pose, &step.fixed_rows::<6>(0).into_owned());
    state.twist += step.fixed_rows::<6>(6);
    if let Some(clocks) = &mut state.clocks {
        clocks.record(vantage.camera_index);
        clocks.shift(&(expected.with.clocks.transpose() * pull));
    }
    if let Some(joints) = &mut state.joints {
        joints.shift(&(expected.with.joints.transpose() * pull));
    }
    reset(&mut state, &step.fixed_rows::<3>(3).into_owned());
    let expected = state.observed_from(vantage);
    let narrowed = update_covariance(&mut state, &expected, &fit.information)?;
    let innovation = Innovation {
        pull,
        weight: narrowed.weight,
        information: narrowed.information,
    };
    state.information_gain = 1.0 - narrowed.left.trace() / D as f64;
    state.motion.learn(&innovation);
    learn_joints(&mut state, &innovation);
    state.is_finite().then_some(Updated {
        state,
        narrowing: narrowed.narrowing,
        with: expected.with,
        left: narrowed.left,
    })
}

fn learn_joints<const D: usize>(state: &mut ObjectState, innovation: &Innovation<D>) {
    let spread = state.motion.spread();
    let Some(joints) = &mut state.joints else {
        return;
    };
    for slot in 0..joints.moving.min(joint_places(D)) {
        let (place, at) = (6 + slot, (6 + slot, 6 + slot));
        let alone = innovation.information[at].recip();
        let seen = (innovation.pull[place], innovation.weight[at], alone);
        joints.learn(slot, seen, spread);
    }
}

/// The prior covariance about the new attitude: dr' = J_l(turn) dr.
fn reset(state: &mut ObjectState, turn: &Vector3<f64>) {
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
    if let Some(joints) = &mut state.joints {
        let rows = jacobian * joints.cross.fixed_rows::<3>(3);
        joints.cross.fixed_rows_mut::<3>(3).copy_from(&rows);
    }
}

/// What became of the prediction.
struct CovarianceUpdate<const D: usize> {
    narrowing: f64,
    /// Inverses of the innovation's covariance and of the prediction's.
    weight: SMatrix<f64, D, D>,
    information: SMatrix<f64, D, D>,
    left: SMatrix<f64, D, D>,
}

/// Takes the information in.
fn update_covariance<const D: usize>(
    state: &mut ObjectState,
    expected: &ObservedConfiguration<D>,
    information: &SMatrix<f64, D, D>,
) -> Option<CovarianceUpdate<D>> {
    let identity = SMatrix::<f64, D, D>::identity();
    let c = Factor::<D>::new(expected.covariance)?.unpack();
    let b = Factor::<D>::new(symmetric(&(identity + c.transpose() * information * c)))?;
    let left = b.inverse();
    let taken = identity - left;
    let motion = c.solve_lower_triangular(&expected.with.motion)?;
    let by_motion = taken * motion;
    state.covariance = symmetric(&(state.covariance - motion.transpose() * by_motion));
    if let Some(joints) = &mut state.joints {
        let own = c.solve_lower_triangular(&expected.with.joints)?;
        let by_own = taken * own;
        joints.cross -= by_motion.transpose() * own;
        joints.own = symmetric(&(joints.own - own.transpose() * by_own));
        if state.clocks.is_some() {
            let clocks = c.solve_lower_triangular(&expected.with.clocks)?;
            joints.with_clocks -= by_own.transpose() * clocks;
        }
    }
    if let Some(clocks) = &mut state.clocks {
        let own = c.solve_lower_triangular(&expected.with.clocks)?;
        clocks.cross -= by_motion.transpose() * own;
        clocks.update_covariance(&(own.transpose() * taken * own));
    }
    let logarithms = (0..D).map(|place| b.l_dirty()[(place, place)].ln());
    let narrowing = 2.0 * logarithms.sum::<f64>();
    let whitened = c.solve_lower_triangular(&identity)?;
    let weight = whitened.transpose() * taken * whitened;
    Some(CovarianceUpdate {
        narrowing,
        weight,
        information: whitened.transpose() * whitened,
        left: c * left * whitened,
    })
}

/// Squared sigmas within which a pose of six numbers is what errors as stated make of it: 95 of 100 are.
const AS_STATED: f64 = 12.6;

/// By how much a fit surprises the state: its squared Mahalanobis distance from what was expected, with what errors that last may make
/// of either where that explains it. The view is one of those that were fitted; of several cameras' all share what the first one's
/// error may be.
pub(crate) fn nis<const D: usize>(
    before: &ObjectState,
    expected: &Prior<D>,
    fit: &Fit<D>,
    weighted: &WeightedView<'_>,
) -> f64 {
    let own = weighted.displacing(&fit.configuration.pose);
    let own = own.filter(|one| one.of_camera().is_some()).collect();
    let displacing = before.displacing::<6>(weighted.camera_index, None, own);
    let lasting: Matrix6<f64> = displacing.iter().map(BiasJacobian::covariance).sum();
    let apart = || {
        let mut covariance = expected.information.try_inverse()?;
        let mut of_pose = covariance.fixed_view_mut::<6, 6>(0, 0);
        of_pose += lasting;
        let off = fit.configuration.difference::<D>(&expected.configuration);
        let factor = Cholesky::<f64, Const<D>>::new(covariance)?;
        Some(off.dot(&factor.solve(&off)))
    };
    let apart = apart().filter(|apart| *apart < AS_STATED);
    apart.unwrap_or(fit.nis)
}
