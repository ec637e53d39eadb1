//! The other branch of the planar ambiguity, for a track that is followed already.
//!
//! A tag seen by one camera looks almost the same when tilted the other way. While it turns through the frontal view
//! both branches are possible, so that the single minimum of a filter is not enough: other attitudes are tried with the
//! same prediction.

use crate::FusionOptions;
use crate::filter::covariance::is_wider_than;
use crate::filter::least_squares::Prior;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::measurement::planar_poses::{branches, is_beside, largest, mirrored};

/// Radians (one sigma about the worst axis) from which on a prediction is too vague to lead to the right one of several
/// minima.
const VAGUE: f64 = 0.05;

/// Attitudes worth trying besides the one found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Others {
    pub starts: Vec<Configuration>,
    /// Logarithm of the odds of the mirrored attitude against the one found, as it is: its own minimum may be better.
    pub mirrored_odds: f64,
}

/// The mirrored attitude, and with a vague prediction both branches of the largest tag: where all views come from one
/// camera and the prediction does not exclude them.
pub(crate) fn others<const D: usize>(
    predicted: &ObjectState,
    found: &Configuration,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Others {
    let mut others = Others {
        starts: Vec::new(),
        mirrored_odds: f64::NEG_INFINITY,
    };
    let largest = largest(views.iter());
    let Some(largest) = largest.filter(|one| is_alone(one.camera_index, views)) else {
        return others;
    };
    let seen = predicted.observed::<D>(largest.camera_index);
    let mirrored = mirrored(largest, found);
    let turn = seen.covariance.fixed_view::<3, 3>(3, 3).into_owned();
    let is_vague = is_wider_than(&turn, VAGUE.powi(2));
    // Nearly always the prediction leaves no doubt.
    let nis = seen.nis(&mirrored);
    if !is_vague && nis.is_none_or(|nis| !is_likely(nis, options)) {
        return others;
    }
    let Some(prior) = seen.prior() else {
        return others;
    };
    if is_possible(&prior, &mirrored, options) {
        let cost = |at: &Configuration| cost(&prior, views, at, options);
        others.mirrored_odds = 0.5 * (cost(found) - cost(&mirrored));
        others.starts.push(mirrored);
    }
    if is_vague {
        let branches = branches(largest).into_iter();
        let branches = branches.map(|link| largest.view.anchored(&link, found));
        for start in branches.filter(|start| is_possible(&prior, start, options)) {
            let known = std::iter::once(found).chain(&others.starts);
            if !known.into_iter().any(|at| is_beside(&start, at, views)) {
                others.starts.push(start);
            }
        }
    }
    others
}

fn is_alone(camera_index: usize, views: &[WeightedView<'_>]) -> bool {
    views
        .iter()
        .all(|weighted| weighted.camera_index == camera_index)
}

/// Twice the odds as chi-square, twice again because the minimum lies nearer to the prediction than the start.
fn is_possible<const D: usize>(
    prior: &Prior<D>,
    start: &Configuration,
    options: &FusionOptions,
) -> bool {
    is_likely(prior.nis(start), options)
}

fn is_likely(nis: f64, options: &FusionOptions) -> bool {
    nis < 4.0 * options.hopeless_odds
}

/// Twice the cost of a configuration, each view's limited by its gate.
fn cost<const D: usize>(
    prior: &Prior<D>,
    views: &[WeightedView<'_>],
    at: &Configuration,
    options: &FusionOptions,
) -> f64 {
    let views: f64 = views
        .iter()
        .map(|weighted| weighted.chi2(at).min(options.tag_gate))
        .sum();
    prior.nis(at) + views
}
