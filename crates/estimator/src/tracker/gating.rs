//! Update of a state by the views of one instant: groups of cameras that share a time, gates, robust fit.
//!
//! Cameras whose clocks are right see the same pose and are fitted jointly. A camera whose offset is estimated sees the
//! pose of another moment; such cameras follow one by one, in the order of the rig.

use std::borrow::Cow;

use nalgebra::Matrix6;

use crate::FusionOptions;
use crate::filter::consider::UpdateGain;
use crate::filter::least_squares::{Fit, solve};
use crate::filter::observed_configuration::ObservationTime;
use crate::filter::state::ObjectState;
use crate::filter::update::{Updated, update};
use crate::kinematics::configuration::Configuration;
use crate::measurement::biases::BiasGradient;
use crate::measurement::corners::{UNSEEN, WeightedView};
use crate::measurement::view_equations::ViewEquations;
use crate::tracker::camera_consistency::CameraConsistency;
use crate::tracker::curvature;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::view_outcome::ViewOutcome;

/// Views whose chi-square is at least this share of the worst one's are left out with it, so that many wrong views cost
/// few fits.
const ALMOST_AS_BAD: f64 = 0.5;

/// How much a further wrong view counts in an image whose views are all wrong.
const WITH_OTHERS: f64 = 1.0 / 6.0;

/// A hypothesis from the prior state and the views that agree with it; `None` where none does. The search begins at
/// `start`, or at the prior's pose.
pub(crate) fn updated<const D: usize>(
    prior: &ObjectState,
    start: Option<&Configuration>,
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Option<Hypothesis> {
    let mut sum = refused(prior.clone(), weighted_views, options);
    let mut start = start;
    for group in groups(weighted_views) {
        let members = members(weighted_views, &group);
        if let Some(prior) = members[0].clock {
            sum.state.know_clock(members[0].camera_index, prior);
        }
        if let Some(update) = updated_by_group::<D>(&sum.state, start.take(), &members, options) {
            let nothing = vec![false; members.len()];
            sum.evidence += update.fitted - update.refusal + refusal(&members, &nothing, options);
            sum.vague |= update.vague;
            group
                .iter()
                .zip(&update.outcomes)
                .for_each(|(index, outcome)| sum.outcomes[*index] = *outcome);
            sum.state = update.state;
        }
    }
    sum.outcomes
        .iter()
        .any(|outcome| outcome.part)
        .then_some(sum)
}

/// The state with all views refused.
pub(crate) fn refused(
    state: ObjectState,
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Hypothesis {
    Hypothesis {
        state,
        evidence: -refusal(weighted_views, &vec![false; weighted_views.len()], options),
        vague: false,
        mirrored: f64::NEG_INFINITY,
        confirmed_odds: 0.0,
        to_mirrored: None,
        consistency: CameraConsistency::default(),
        outcomes: vec![ViewOutcome::refused(); weighted_views.len()],
    }
}

/// Logarithm of the odds against the views that take no part. Wrong tags are rare and independent; but one cause, a
/// moved camera, makes all views of an image wrong at once.
fn refusal(weighted_views: &[WeightedView<'_>], part: &[bool], options: &FusionOptions) -> f64 {
    let mut odds = 0.0;
    let pairs: Vec<(usize, bool)> = weighted_views
        .iter()
        .map(|weighted| weighted.camera_index)
        .zip(part.iter().copied())
        .collect();
    for image in pairs.chunk_by(|a, b| a.0 == b.0) {
        let refused = image.iter().filter(|(_, part)| !part).count();
        odds += if refused == image.len() {
            image_refusal(refused, options)
        } else {
            options.refused_odds * refused as f64
        };
    }
    odds
}

/// The same of all views of an image.
pub(crate) fn image_refusal(views: usize, options: &FusionOptions) -> f64 {
    options.refused_odds * (1.0 + (views as f64 - 1.0) * WITH_OTHERS)
}

/// Indices of the views that see the same moment; those of right clocks first.
fn groups(weighted_views: &[WeightedView<'_>]) -> Vec<Vec<usize>> {
    let (right, other): (Vec<usize>, Vec<usize>) =
        (0..weighted_views.len()).partition(|index| weighted_views[*index].clock.is_none());
    let by_camera =
        other.chunk_by(|a, b| weighted_views[*a].camera_index == weighted_views[*b].camera_index);
    let mut groups: Vec<Vec<usize>> = by_camera.map(<[usize]>::to_vec).collect();
    if !right.is_empty() {
        groups.insert(0, right);
    }
    groups
}

/// Camera and time of simultaneous views.
fn observation_time(weighted_views: &[WeightedView<'_>]) -> ObservationTime {
    let rows = weighted_views
        .iter()
        .filter_map(|weighted| weighted.view.after_s);
    let of_all: f64 = rows.flatten().map(f64::abs).sum();
    ObservationTime {
        camera_index: weighted_views[0].camera_index,
        apart_s: of_all / (4 * weighted_views.len()) as f64,
    }
}

struct GroupUpdate {
    state: ObjectState,
    /// Logarithm of the odds that the corners give.
    fitted: f64,
    /// Logarithm of the odds against the views that take no part.
    refusal: f64,
    /// Whether the attitude is so vague that the cost may be no parabola about the fit.
    vague: bool,
    outcomes: Vec<ViewOutcome>,
}

/// The worst view is left out until all that are left pass their gates; `None` where none does, or where the prediction
/// contradicts them all.
fn updated_by_group<const D: usize>(
    prior: &ObjectState,
    start: Option<&Configuration>,
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Option<GroupUpdate> {
    let expected = prior.observed_from::<D>(observation_time(weighted_views));
    let seen_prior = expected.prior()?;
    let mut part = vec![true; weighted_views.len()];
    loop {
        let active = chosen(weighted_views, &part);
        if active.is_empty() {
            return None;
        }
        let mut fit = solve(
            &seen_prior,
            &active,
            start.unwrap_or(&expected.configuration),
        )?;
        let normals = normals(weighted_views, &part, &mut fit);
        let worst = worst_chi2(&normals, &part);
        if worst > options.tag_gate {
            // Just below the worst, so that at least that one goes.
            let limit = options.tag_gate.max(worst * ALMOST_AS_BAD);
            leave_out(&mut part, &normals, limit);
        } else if fit.nis > options.prediction_gate {
            return None;
        } else {
            let mut update = complete(prior, &fit, weighted_views, &normals, &part)?;
            if active.iter().all(|weighted| weighted.clock.is_none()) {
                update.vague = curvature::widen(&mut update.state, &seen_prior, &active, &fit);
            }
            update.refusal = refusal(weighted_views, &part, options);
            return Some(update);
        }
    }
}

/// The views of a group; nearly always all.
fn members<'s, 'a>(
    weighted_views: &'s [WeightedView<'a>],
    group: &[usize],
) -> Cow<'s, [WeightedView<'a>]> {
    if group.len() == weighted_views.len() {
        return Cow::Borrowed(weighted_views);
    }
    group.iter().map(|index| weighted_views[*index]).collect()
}

/// The views that take part; nearly always all.
fn chosen<'s, 'a>(
    weighted_views: &'s [WeightedView<'a>],
    part: &[bool],
) -> Cow<'s, [WeightedView<'a>]> {
    if part.iter().all(|part| *part) {
        return Cow::Borrowed(weighted_views);
    }
    let pairs = weighted_views.iter().zip(part);
    pairs
        .filter(|(_, part)| **part)
        .map(|(weighted, _)| *weighted)
        .collect()
}

/// Cost and normal equations of each view at the fit; `None` where it would have to show the tag's back.
fn normals<const D: usize>(
    weighted_views: &[WeightedView<'_>],
    part: &[bool],
    fit: &mut Fit<D>,
) -> Vec<Option<ViewEquations>> {
    let at = fit.configuration;
    let mut normals = std::mem::take(&mut fit.views);
    if part.iter().any(|part| !part) {
        let mut fitted = normals.into_iter();
        let normal = |(weighted, part): (&WeightedView<'_>, &bool)| {
            if *part {
                fitted.next().flatten()
            } else {
                weighted.normal(&weighted.view.moving(&at))
            }
        };
        normals = weighted_views.iter().zip(part).map(normal).collect();
    }
    for (weighted, view) in weighted_views.iter().zip(&mut normals) {
        let link = weighted.view.world_from_link(&at);
        if !weighted.faces(&link) {
            *view = None;
        }
    }
    normals
}

fn chi2(normal: &Option<ViewEquations>) -> f64 {
    normal.as_ref().map_or(UNSEEN, |normal| normal.chi2)
}

fn worst_chi2(normals: &[Option<ViewEquations>], part: &[bool]) -> f64 {
    let taking_part = normals.iter().zip(part).filter(|(_, part)| **part);
    taking_part
        .map(|(normal, _)| chi2(normal))
        .fold(0.0, f64::max)
}

fn leave_out(part: &mut [bool], normals: &[Option<ViewEquations>], limit: f64) {
    for (part, normal) in part.iter_mut().zip(normals) {
        *part &= chi2(normal) <= limit;
    }
}

fn complete<const D: usize>(
    prior: &ObjectState,
    fit: &Fit<D>,
    weighted_views: &[WeightedView<'_>],
    normals: &[Option<ViewEquations>],
    part: &[bool],
) -> Option<GroupUpdate> {
    let camera_index = weighted_views[0].camera_index;
    let mut updated_state = update(prior, observation_time(weighted_views), fit)?;
    let seen = updated_state.state.observed::<D>(camera_index);
    let of_base = seen.covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let covariance = |weighted: &WeightedView<'_>| match &weighted.view.chain_link {
        None => of_base,
        Some(chain_link) => chain_link.covariance(&seen.configuration, &seen.covariance),
    };
    let pairs = normals.iter().zip(part).zip(weighted_views);
    let outcomes = pairs
        .map(|((normal, part), weighted)| {
            let covariance = covariance(weighted);
            let mut outcome = outcome(normal.as_ref(), *part, &covariance);
            if *part && weighted.view.distortion_bias.is_some() {
                let link = weighted.view.moving(&fit.configuration);
                outcome.distortion_score = weighted
                    .distortion_score(&link, &covariance)
                    .unwrap_or_default();
            }
            outcome
        })
        .collect();
    let parts = bias_gradients::<D>(&seen.configuration, weighted_views, normals, part);
    if !parts.is_empty() || updated_state.state.considered.is_some() {
        let gain = gain(&updated_state, fit, camera_index);
        updated_state.state.consider(&gain, &parts);
    }
    let fitted = -0.5 * (fit.cost + updated_state.log_shrinkage);
    let state = updated_state.state;
    Some(GroupUpdate {
        state,
        fitted,
        refusal: 0.0,
        vague: false,
        outcomes,
    })
}

/// Gain and rates of an update, as the consider states need them.
fn gain<const D: usize>(
    updated_state: &Updated<D>,
    fit: &Fit<D>,
    camera_index: usize,
) -> UpdateGain<D> {
    let clocks = updated_state.state.clocks.as_deref();
    let slot = clocks.and_then(|clocks| Some((clocks, clocks.slot(camera_index)?)));
    UpdateGain {
        with: updated_state.gain(),
        clock: slot.map(|(clocks, slot)| (slot, clocks.offset_s(slot))),
        rates: updated_state.state.rates(),
        information: fit.information,
    }
}

/// Gradients of the consider parameters by the views that took part.
fn bias_gradients<const D: usize>(
    seen: &Configuration,
    weighted_views: &[WeightedView<'_>],
    normals: &[Option<ViewEquations>],
    part: &[bool],
) -> Vec<BiasGradient<D>> {
    let mut parts: Vec<BiasGradient<D>> = Vec::new();
    let views = weighted_views.iter().zip(normals).zip(part);
    for ((weighted, normal), _) in views.filter(|(_, part)| **part) {
        let Some(normal) = normal else { continue };
        let own = weighted.bias_gradients(seen, normal);
        let chain_link = weighted
            .view
            .chain_link
            .as_ref()
            .filter(|_| !own.is_empty());
        let by_configuration = chain_link.map(|chain_link| chain_link.jacobian::<D>(seen));
        for part in own {
            part.about(by_configuration.as_ref()).join(&mut parts);
        }
    }
    parts
}

fn outcome(normal: Option<&ViewEquations>, part: bool, covariance: &Matrix6<f64>) -> ViewOutcome {
    let Some(normal) = normal else {
        return ViewOutcome::refused();
    };
    // The trace of the product: both are symmetric.
    let updated_state = if part {
        normal.information.dot(covariance)
    } else {
        0.0
    };
    ViewOutcome {
        part,
        expected: part,
        weighted_square: normal.weighted_square,
        redundancy: (8.0 - updated_state).clamp(0.4, 8.0),
        square_px: normal.square_px,
        distortion_score: [0.0; 2],
    }
}
