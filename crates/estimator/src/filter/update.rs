//! From the configuration that the corners show to the whole state: they see base and joints only, the rest follows by
//! its correlation.
//!
//! The seen configuration is a linear function of the state. With S its prior covariance, M its covariance with the
//! state, L = J^T W J the information of the corners and C the Cholesky factor of S:
//!
//! ```text
//! P⁺ = P - Mᵀ C⁻ᵀ (I - B⁻¹) C⁻¹ M with B = I + Cᵀ L C
//! ```
//!
//! B's eigenvalues are at least one, so the form holds for vague and for sharp priors alike.

use nalgebra::{Cholesky, Const, SMatrix, Vector3};
use sextant_geometry::{se3, so3};

use crate::filter::covariance::{CrossCovariance, symmetric};
use crate::filter::least_squares::Fit;
use crate::filter::observed_configuration::{ObservationTime, ObservedConfiguration};
use crate::filter::process_noise::{Innovation, ScalarInnovation};
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::joint_places;

type Factor<const D: usize> = Cholesky<f64, Const<D>>;

/// A state updated by a fit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Updated<const D: usize> {
    pub state: ObjectState,
    /// ln det(I + S L): the reduction of the prior by the corners; half of it is the Occam factor of the evidence.
    pub log_shrinkage: f64,
    /// M.
    with: CrossCovariance<D>,
    /// (I + S L)⁻¹.
    left: SMatrix<f64, D, D>,
}

impl<const D: usize> Updated<D> {
    /// Gain: (I + S L)⁻¹ M, transposed, which is H P⁺ where S is no more than H P Hᵀ.
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

/// The state after the fit to the configuration that the camera saw; `None` where numbers end.
pub(crate) fn update<const D: usize>(
    before: &ObjectState,
    observation_time: ObservationTime,
    fit: &Fit<D>,
) -> Option<Updated<D>> {
    let expected = before.observed_from::<D>(observation_time);
    let off = fit.configuration.difference::<D>(&expected.configuration);
    let pull = Factor::<D>::new(expected.covariance)?.solve(&off);
    let step = expected.with.motion.transpose() * pull;
    let mut state = before.clone();
    state.pose = se3::perturb(&before.pose, &step.fixed_rows::<6>(0).into_owned());
    state.twist += step.fixed_rows::<6>(6);
    if let Some(clocks) = &mut state.clocks {
        clocks.record(observation_time.camera_index);
        clocks.shift(&(expected.with.clocks.transpose() * pull));
    }
    if let Some(joints) = &mut state.joints {
        joints.shift(&(expected.with.joints.transpose() * pull));
    }
    reset(&mut state, &step.fixed_rows::<3>(3).into_owned());
    let expected = state.observed_from(observation_time);
    let shrunk = update_covariance(&mut state, &expected, &fit.information)?;
    let innovation = Innovation {
        pull,
        weight: shrunk.weight,
        information: shrunk.information,
    };
    state.information_gain = 1.0 - shrunk.left.trace() / D as f64;
    state.motion.learn(&innovation);
    learn_joints(&mut state, &innovation);
    state.is_finite().then_some(Updated {
        state,
        log_shrinkage: shrunk.log_shrinkage,
        with: expected.with,
        left: shrunk.left,
    })
}

fn learn_joints<const D: usize>(state: &mut ObjectState, innovation: &Innovation<D>) {
    let spread = state.motion.spread();
    let Some(joints) = &mut state.joints else {
        return;
    };
    for slot in 0..joints.moving.min(joint_places(D)) {
        let (place, at) = (6 + slot, (6 + slot, 6 + slot));
        let of_joint = ScalarInnovation {
            pull: innovation.pull[place],
            weight: innovation.weight[at],
            conditional: innovation.information[at].recip(),
        };
        joints.learn(slot, of_joint, spread);
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

/// Result of a covariance update.
struct CovarianceUpdate<const D: usize> {
    log_shrinkage: f64,
    /// Inverses of the innovation's covariance and of the prediction's.
    weight: SMatrix<f64, D, D>,
    information: SMatrix<f64, D, D>,
    left: SMatrix<f64, D, D>,
}

/// Updates the covariance with the information of the corners.
fn update_covariance<const D: usize>(
    state: &mut ObjectState,
    expected: &ObservedConfiguration<D>,
    information: &SMatrix<f64, D, D>,
) -> Option<CovarianceUpdate<D>> {
    let identity = SMatrix::<f64, D, D>::identity();
    let c = Factor::<D>::new(expected.covariance)?.unpack();
    let b = Factor::<D>::new(symmetric(&(identity + c.transpose() * information * c)))?;
    let left = b.inverse();
    let gained = identity - left;
    let motion = c.solve_lower_triangular(&expected.with.motion)?;
    let by_motion = gained * motion;
    state.covariance = symmetric(&(state.covariance - motion.transpose() * by_motion));
    if let Some(joints) = &mut state.joints {
        let own = c.solve_lower_triangular(&expected.with.joints)?;
        let by_own = gained * own;
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
        clocks.update_covariance(&(own.transpose() * gained * own));
    }
    let logarithms = (0..D).map(|place| b.l_dirty()[(place, place)].ln());
    let log_shrinkage = 2.0 * logarithms.sum::<f64>();
    let whitened = c.solve_lower_triangular(&identity)?;
    let weight = whitened.transpose() * gained * whitened;
    Some(CovarianceUpdate {
        log_shrinkage,
        weight,
        information: whitened.transpose() * whitened,
        left: c * left * whitened,
    })
}
