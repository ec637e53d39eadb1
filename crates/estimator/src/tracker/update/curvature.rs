//! Covariance where the cost is flatter than its parabola.
//!
//! The foreshortening of a tag goes with the square of its tilt, so that the normal matrix overstates the information
//! near the frontal view: it extends the slope at the fitted tilt to all tilts. For a vague attitude the cost is
//! evaluated three standard deviations to either side along the widest axis. Where it has risen by less than nine, the
//! covariance grows by the ratio.

use nalgebra::{SVector, Vector6};

use crate::filter::covariance::symmetric;
use crate::filter::least_squares::{Fit, Prior};
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::{Configuration, joint_places, rates_at};
use crate::measurement::corners::WeightedView;

/// Radians (one sigma) from which on the parabola is checked.
const VAGUE: f64 = 0.03;
/// Standard deviations to either side at which the cost is evaluated.
const SIGMAS: f64 = 3.0;
/// Most growth of the variance.
const MOST_GROWTH: f64 = 10.0;

/// Widens the state after a fit, where its cost is flatter than its covariance claims.
pub(crate) fn widen<const D: usize>(
    state: &mut ObjectState,
    prior: &Prior<D>,
    views: &[WeightedView<'_>],
    fit: &Fit<D>,
) {
    let Some((axis, variance)) = widest(state) else {
        return;
    };
    let sigma = one_sigma::<D>(state, &axis, variance);
    let risen = |sigmas: f64| {
        let stepped = fit.configuration.perturbed(&(sigma * sigmas));
        cost(prior, views, &stepped) - fit.cost
    };
    let flattest = risen(SIGMAS).min(risen(-SIGMAS)) / SIGMAS.powi(2);
    let growth = (1.0 / flattest.max(1.0 / MOST_GROWTH)).max(1.0);
    let along = state.covariance.fixed_columns::<6>(0) * (axis / variance.sqrt());
    let wider = state.covariance + along * along.transpose() * (growth - 1.0);
    state.covariance = symmetric(&wider);
    widen_joints(state, &along, &(axis / variance.sqrt()), growth);
}

/// The widest axis of the pose, of unit length, and its variance; `None` where the attitude is sharp.
fn widest(state: &ObjectState) -> Option<(Vector6<f64>, f64)> {
    let covariance = state.covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let turns = (3..6).map(|axis| covariance[(axis, axis)]);
    if turns.fold(0.0, f64::max) < VAGUE.powi(2) {
        return None;
    }
    let eigen = covariance.symmetric_eigen();
    let widest = eigen.eigenvalues.imax();
    let variance = eigen.eigenvalues[widest];
    (variance > 0.0).then(|| (eigen.eigenvectors.column(widest).into_owned(), variance))
}

/// The step of base and joints that goes with one sigma along the axis.
fn one_sigma<const D: usize>(
    state: &ObjectState,
    axis: &Vector6<f64>,
    variance: f64,
) -> SVector<f64, D> {
    let mut step = SVector::<f64, D>::zeros();
    step.fixed_rows_mut::<6>(0)
        .copy_from(&(axis * variance.sqrt()));
    if let Some(joints) = &state.joints {
        let joined = joints.cross.fixed_rows::<6>(0).transpose() * (axis / variance.sqrt());
        (0..joint_places(D)).for_each(|place| step[6 + place] = joined[place]);
    }
    if let Some(first) = rates_at(D) {
        let rates = state.covariance.fixed_view::<6, 6>(6, 0) * (axis / variance.sqrt());
        step.fixed_rows_mut::<6>(first).copy_from(&rates);
    }
    step
}

/// The joints' part of the wider covariance; `along` is that of one sigma with the motion.
fn widen_joints(
    state: &mut ObjectState,
    along: &SVector<f64, 12>,
    axis: &Vector6<f64>,
    growth: f64,
) {
    if let Some(joints) = &mut state.joints {
        let joined = joints.cross.fixed_rows::<6>(0).transpose() * axis;
        joints.cross += along * joined.transpose() * (growth - 1.0);
        joints.own = symmetric(&(joints.own + joined * joined.transpose() * (growth - 1.0)));
    }
}

fn cost<const D: usize>(prior: &Prior<D>, views: &[WeightedView<'_>], at: &Configuration) -> f64 {
    prior.nis(at) + views.iter().map(|weighted| weighted.chi2(at)).sum::<f64>()
}
