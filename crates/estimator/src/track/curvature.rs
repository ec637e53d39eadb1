//! Covariance where the cost is flatter than its parabola.
//!
//! The foreshortening of a tag goes with the square of its tilt, so that near the frontal view the normal matrix says too
//! much: it takes the slope at the tilt found for the slope everywhere. For a vague attitude the cost is looked at three
//! sigmas to either side along the widest axis, and where it has risen by less than nine the covariance grows by the ratio.

use nalgebra::Vector6;
use sextant_geometry::{Pose, se3};

use crate::filter::corners::Sight;
use crate::filter::kinematics::{Kinematics, symmetric};
use crate::filter::solve::{Fit, Prior, UNSEEN};

/// Radians (one sigma) from which on the parabola is checked.
const VAGUE: f64 = 0.03;
/// How far to look, in sigmas.
const SIGMAS: f64 = 3.0;
/// Most growth of the variance.
const MOST_GROWTH: f64 = 10.0;

/// Widens the state after a fit, where its cost is flatter than it claims. Whether it had to be looked at.
pub(crate) fn widen(
    state: &mut Kinematics,
    prior: &Prior,
    sights: &[Sight<'_>],
    fit: &Fit,
) -> bool {
    let Some((axis, variance)) = widest(state) else {
        return false;
    };
    let risen = |sigmas: f64| {
        let step = axis * (sigmas * variance.sqrt());
        cost(prior, sights, &se3::perturb(&fit.pose, &step)) - fit.cost
    };
    let flattest = risen(SIGMAS).min(risen(-SIGMAS)) / SIGMAS.powi(2);
    let growth = (1.0 / flattest.max(1.0 / MOST_GROWTH)).max(1.0);
    let along = state.covariance.fixed_columns::<6>(0) * (axis / variance.sqrt());
    let wider = state.covariance + along * along.transpose() * (growth - 1.0);
    state.covariance = symmetric(&wider);
    true
}

/// The widest axis of the pose, of unit length, and its variance; `None` where the attitude is sharp.
fn widest(state: &Kinematics) -> Option<(Vector6<f64>, f64)> {
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

fn cost(prior: &Prior, sights: &[Sight<'_>], pose: &Pose) -> f64 {
    let off = se3::difference(pose, &prior.pose);
    let chi2 = |sight: &Sight<'_>| sight.normal(pose).map_or(UNSEEN, |normal| normal.chi2);
    off.dot(&(prior.information * off)) + sights.iter().map(chi2).sum::<f64>()
}
