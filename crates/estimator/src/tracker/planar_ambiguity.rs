//! The other branch of the planar ambiguity, for a track that is followed already.
//!
//! A tag seen by one camera looks almost the same when tilted the other way. While it turns through the frontal view
//! both branches are possible, so that the single minimum of a filter is not enough: other attitudes are tried with the
//! same prediction.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};
use sextant_geometry::{Pose, se3};

use crate::FusionOptions;
use crate::filter::covariance::is_wider_than;
use crate::filter::least_squares::Prior;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::measurement::planar_poses::{branches, largest};

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
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Others {
    let mut others = Others {
        starts: Vec::new(),
        mirrored_odds: f64::NEG_INFINITY,
    };
    let largest = largest(weighted_views.iter());
    let Some(largest) = largest.filter(|one| is_alone(one.camera_index, weighted_views)) else {
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
        let cost = |at: &Configuration| cost(&prior, weighted_views, at, options);
        others.mirrored_odds = 0.5 * (cost(found) - cost(&mirrored));
        others.starts.push(mirrored);
    }
    if is_vague {
        let branches = branches(largest).into_iter();
        let branches = branches.map(|link| largest.view.anchored(&link, found));
        for start in branches.filter(|start| is_possible(&prior, start, options)) {
            let known = std::iter::once(found).chain(&others.starts);
            if !known
                .into_iter()
                .any(|at| is_beside(&start, at, weighted_views))
            {
                others.starts.push(start);
            }
        }
    }
    others
}

/// Share of the turn to the mirrored attitude, and of the way from the camera, within which starts lead to one minimum.
const BESIDE: (f64, f64) = (0.25, 0.03);

/// Whether a search that begins at `start` would end where another one is: all links that are seen are far nearer to it
/// than to its mirrored attitude.
pub(crate) fn is_beside(
    start: &Configuration,
    at: &Configuration,
    weighted_views: &[WeightedView<'_>],
) -> bool {
    let Some(largest) = largest(weighted_views.iter()) else {
        return false;
    };
    let turned = |one: &Configuration| largest.view.world_from_link(one).rotation;
    let apart = turned(&mirrored(largest, at)).angle_to(&turned(at));
    weighted_views.iter().all(|weighted| {
        let [here, there] = [start, at].map(|one| weighted.view.world_from_link(one));
        let far = (there.translation.vector - weighted.camera.centre).norm();
        let off = (here.translation.vector - there.translation.vector).norm();
        here.rotation.angle_to(&there.rotation) < BESIDE.0 * apart && off < BESIDE.1 * far
    })
}

/// The step to the mirrored attitude of the largest view.
pub(crate) fn step_to_mirrored(
    at: &Configuration,
    weighted_views: &[&WeightedView<'_>],
) -> Option<Vector6<f64>> {
    let largest = largest(weighted_views.iter().copied())?;
    Some(se3::difference(&mirrored(largest, at).pose, &at.pose))
}

/// Logarithm of the odds of the images of one instant against the mirrored attitude, by their corners alone. The motion
/// does not count: a mirrored motion is as smooth as the true one.
pub(crate) fn odds_against_mirrored(
    at: &Configuration,
    weighted_views: &[&WeightedView<'_>],
) -> f64 {
    let Some(largest) = largest(weighted_views.iter().copied()) else {
        return 0.0;
    };
    let all = |at: &Configuration| -> f64 {
        weighted_views
            .iter()
            .map(|weighted| weighted.chi2(at))
            .sum()
    };
    if weighted_views.len() > 1 {
        return 0.5 * (all(&mirrored(largest, at)) - all(at));
    }
    let found = largest.view.world_from_link(at).rotation;
    let mut branches = branches(largest);
    branches.sort_by(|a, b| {
        let turn = |branch: &Pose| branch.rotation.angle_to(&found);
        turn(a).total_cmp(&turn(b))
    });
    match branches[..] {
        [near, far] => {
            let chi2 = |link: &Pose| largest.chi2(&largest.view.anchored(link, at));
            0.5 * (chi2(&far) - chi2(&near))
        }
        _ => 0.0,
    }
}

fn is_alone(camera_index: usize, weighted_views: &[WeightedView<'_>]) -> bool {
    weighted_views
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
    weighted_views: &[WeightedView<'_>],
    at: &Configuration,
    options: &FusionOptions,
) -> f64 {
    let views: f64 = weighted_views
        .iter()
        .map(|weighted| weighted.chi2(at).min(options.tag_gate))
        .sum();
    prior.nis(at) + views
}

/// With the tag mirrored in the plane through its centre across the line of sight: R' = (I - 2 d dᵀ) R diag(1, 1, -1).
/// Links go with the tag's as one body.
fn mirrored(weighted: &WeightedView<'_>, at: &Configuration) -> Configuration {
    let camera_from_tag = weighted.camera_from_tag(&weighted.view.world_from_link(at));
    let towards = camera_from_tag.translation.vector.normalize();
    let across = Matrix3::identity() - towards * towards.transpose() * 2.0;
    let turned = camera_from_tag.rotation.to_rotation_matrix();
    let flipped = across * turned.matrix() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(flipped));
    let camera_from_flipped = Pose::from_parts(camera_from_tag.translation, rotation);
    let world_from_link = weighted.camera.camera_from_world.inverse()
        * camera_from_flipped
        * weighted.view.object_from_tag.inverse();
    weighted.view.anchored(&world_from_link, at)
}
