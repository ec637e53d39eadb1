//! Stage 3: measurement update of the predicted states by the views of an instant: groups of cameras that share a time,
//! gates, robust fit, in each minimum of the cost.
//!
//! Cameras whose clocks are right see the same pose and are fitted jointly. A camera whose offset is estimated sees the
//! pose of another moment; such cameras follow one by one, in the order of the rig.

pub(crate) mod curvature;
pub(crate) mod joint_search;
pub(crate) mod planar_ambiguity;

use std::borrow::Cow;

use nalgebra::Matrix6;

use crate::FusionOptions;
use crate::filter::consider::UpdateGain;
use crate::filter::least_squares::{Fit, solve};
use crate::filter::observed_configuration::ObservationTime;
use crate::filter::state::ObjectState;
use crate::filter::update::{Updated, update as update_by_fit};
use crate::kinematics::configuration::Configuration;
use crate::measurement::biases::BiasGradient;
use crate::measurement::corners::{WeightedView, unseen_cost};
use crate::measurement::view_equations::ViewEquations;
use crate::tracker::hypothesis::{Hypothesis, ViewOutcome};
use crate::tracker::predict::Prediction;
use sextant_site_model::MOST_JOINTS;

/// Views whose chi-square is at least this share of the worst one's are left out with it, so that many wrong views cost
/// few fits.
const ALMOST_AS_BAD: f64 = 0.5;

/// How much a further wrong view counts in an image whose views are all wrong.
const WITH_OTHERS: f64 = 1.0 / 6.0;

/// The posteriors of each predicted state, as [`update_state`] gives them.
pub(crate) fn update(
    prediction: &Prediction<'_>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Vec<Hypothesis>> {
    let states = prediction.states.iter();
    states
        .map(|state| update_state(state, views, options))
        .collect()
}

/// The posteriors of a prior state, one for each minimum that is a possibility of its own; none where no view agrees
/// with the prior.
pub(crate) fn update_state(
    prior: &ObjectState,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let is_rolling = views.iter().any(|weighted| weighted.view.after_s.is_some());
    let n_joints = prior.joints.as_ref().map_or(0, |joints| joints.moving);
    match (is_rolling, n_joints) {
        (false, 0) => minima::<6>(prior, views, options),
        (false, 1..=2) => minima::<8>(prior, views, options),
        (false, _) => minima::<{ 6 + MOST_JOINTS }>(prior, views, options),
        (true, 0) => minima::<12>(prior, views, options),
        (true, _) => minima::<{ 2 * (6 + MOST_JOINTS) }>(prior, views, options),
    }
}

/// The same with the size of a configuration.
fn minima<const D: usize>(
    prior: &ObjectState,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let update = |start: Option<&Configuration>| update_from::<D>(prior, start, views, options);
    let (found, searched) = (update(None), joint_search::start(prior, views));
    let (found, second) = match (found, searched.and_then(|start| update(Some(&start)))) {
        (Some(found), Some(other)) if other.evidence > found.evidence => (other, Some(found)),
        (Some(found), other) => (found, other),
        (None, Some(other)) => (other, None),
        (None, None) => return Vec::new(),
    };
    let at = found.state.configuration();
    let others = planar_ambiguity::others::<D>(prior, &at, views, options);
    let starts = others.starts.iter();
    let mut all: Vec<Hypothesis> = starts.filter_map(|start| update(Some(start))).collect();
    all.extend(second);
    all.push(Hypothesis {
        mirrored: others.mirrored_odds,
        ..found
    });
    all
}

/// The posterior in the minimum that a search from `start`, or from the prior's pose, leads to, by the views that agree
/// with the prior; `None` where none does.
fn update_from<const D: usize>(
    prior: &ObjectState,
    mut start: Option<&Configuration>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Option<Hypothesis> {
    let mut sum = refused(prior.clone(), views, options);
    for group in groups(views) {
        let members = members(views, &group);
        if let Some(prior) = members[0].clock {
            sum.state.know_clock(members[0].camera_index, prior);
        }
        if let Some(update) = update_by_group::<D>(&sum.state, start.take(), &members, options) {
            let nothing = vec![false; members.len()];
            sum.evidence += update.fitted - update.refusal + refusal(&members, &nothing, options);
            for (index, outcome) in group.iter().zip(&update.outcomes) {
                sum.outcomes[*index] = *outcome;
            }
            sum.state = update.state;
        }
    }
    let is_any_used = sum.outcomes.iter().any(|outcome| outcome.used);
    is_any_used.then_some(sum)
}

/// The state with all views refused.
pub(crate) fn refused(
    state: ObjectState,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Hypothesis {
    let evidence = -refusal(views, &vec![false; views.len()], options);
    Hypothesis::refused(state, evidence, views.len())
}

/// Logarithm of the odds against the views that are left out. Wrong tags are rare and independent; but one cause, a
/// moved camera, makes all views of an image wrong at once.
fn refusal(views: &[WeightedView<'_>], used: &[bool], options: &FusionOptions) -> f64 {
    let mut odds = 0.0;
    let pairs: Vec<(usize, bool)> = views
        .iter()
        .map(|weighted| weighted.camera_index)
        .zip(used.iter().copied())
        .collect();
    for image in pairs.chunk_by(|a, b| a.0 == b.0) {
        let refused = image.iter().filter(|(_, used)| !used).count();
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
fn groups(views: &[WeightedView<'_>]) -> Vec<Vec<usize>> {
    let (right, other): (Vec<usize>, Vec<usize>) =
        (0..views.len()).partition(|index| views[*index].clock.is_none());
    let by_camera = other.chunk_by(|a, b| views[*a].camera_index == views[*b].camera_index);
    let mut groups: Vec<Vec<usize>> = by_camera.map(<[usize]>::to_vec).collect();
    if !right.is_empty() {
        groups.insert(0, right);
    }
    groups
}

/// Camera and time of simultaneous views.
fn observation_time(views: &[WeightedView<'_>]) -> ObservationTime {
    let rows = views.iter().filter_map(|weighted| weighted.view.after_s);
    let of_all: f64 = rows.flatten().map(f64::abs).sum();
    ObservationTime {
        camera_index: views[0].camera_index,
        apart_s: of_all / (4 * views.len()) as f64,
    }
}

struct GroupUpdate {
    state: ObjectState,
    /// Logarithm of the odds that the corners give.
    fitted: f64,
    /// Logarithm of the odds against the views that are left out.
    refusal: f64,
    outcomes: Vec<ViewOutcome>,
}

/// The worst view is left out until all others pass their gates; `None` where none does, or where the prediction
/// contradicts them all.
fn update_by_group<const D: usize>(
    prior: &ObjectState,
    start: Option<&Configuration>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Option<GroupUpdate> {
    let expected = prior.observed_from::<D>(observation_time(views));
    let seen_prior = expected.prior()?;
    let mut used = vec![true; views.len()];
    loop {
        let active = chosen(views, &used);
        if active.is_empty() {
            return None;
        }
        let mut fit = solve(
            &seen_prior,
            &active,
            start.unwrap_or(&expected.configuration),
        )?;
        let normals = normals(views, &used, &mut fit);
        let worst = worst_chi2(&normals, &used);
        if worst > options.tag_gate {
            // Just below the worst, so that at least that one goes.
            let limit = options.tag_gate.max(worst * ALMOST_AS_BAD);
            leave_out(&mut used, &normals, limit);
        } else if fit.nis > options.prediction_gate {
            return None;
        } else {
            let mut update = complete(prior, &fit, views, &normals, &used)?;
            if active.iter().all(|weighted| weighted.clock.is_none()) {
                curvature::widen(&mut update.state, &seen_prior, &active, &fit);
            }
            update.refusal = refusal(views, &used, options);
            return Some(update);
        }
    }
}

/// The views of a group; nearly always all.
fn members<'s, 'a>(views: &'s [WeightedView<'a>], group: &[usize]) -> Cow<'s, [WeightedView<'a>]> {
    if group.len() == views.len() {
        return Cow::Borrowed(views);
    }
    group.iter().map(|index| views[*index]).collect()
}

/// The views that are used; nearly always all.
fn chosen<'s, 'a>(views: &'s [WeightedView<'a>], used: &[bool]) -> Cow<'s, [WeightedView<'a>]> {
    if used.iter().all(|used| *used) {
        return Cow::Borrowed(views);
    }
    let pairs = views.iter().zip(used);
    pairs
        .filter(|(_, used)| **used)
        .map(|(weighted, _)| *weighted)
        .collect()
}

/// Cost and normal equations of each view at the fit; `None` where it would have to show the tag's back.
fn normals<const D: usize>(
    views: &[WeightedView<'_>],
    used: &[bool],
    fit: &mut Fit<D>,
) -> Vec<Option<ViewEquations>> {
    let at = fit.configuration;
    let mut normals = std::mem::take(&mut fit.views);
    if used.iter().any(|used| !used) {
        let mut fitted = normals.into_iter();
        let normal = |(weighted, used): (&WeightedView<'_>, &bool)| {
            if *used {
                fitted.next().flatten()
            } else {
                weighted.normal(&weighted.view.moving(&at))
            }
        };
        normals = views.iter().zip(used).map(normal).collect();
    }
    for (weighted, view) in views.iter().zip(&mut normals) {
        let link = weighted.view.world_from_link(&at);
        if !weighted.faces(&link) {
            *view = None;
        }
    }
    normals
}

fn chi2(normal: &Option<ViewEquations>) -> f64 {
    normal
        .as_ref()
        .map_or_else(unseen_cost, |normal| normal.chi2)
}

fn worst_chi2(normals: &[Option<ViewEquations>], used: &[bool]) -> f64 {
    let used = normals.iter().zip(used).filter(|(_, used)| **used);
    used.map(|(normal, _)| chi2(normal)).fold(0.0, f64::max)
}

fn leave_out(used: &mut [bool], normals: &[Option<ViewEquations>], limit: f64) {
    for (used, normal) in used.iter_mut().zip(normals) {
        *used &= chi2(normal) <= limit;
    }
}

fn complete<const D: usize>(
    prior: &ObjectState,
    fit: &Fit<D>,
    views: &[WeightedView<'_>],
    normals: &[Option<ViewEquations>],
    used: &[bool],
) -> Option<GroupUpdate> {
    let camera_index = views[0].camera_index;
    let mut updated_state = update_by_fit(prior, observation_time(views), fit)?;
    let seen = updated_state.state.observed::<D>(camera_index);
    let of_base = seen.covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let covariance = |weighted: &WeightedView<'_>| match &weighted.view.chain_link {
        None => of_base,
        Some(chain_link) => chain_link.covariance(&seen.configuration, &seen.covariance),
    };
    let pairs = normals.iter().zip(used).zip(views);
    let outcomes = pairs
        .map(|((normal, used), weighted)| {
            let covariance = covariance(weighted);
            let mut outcome = outcome(normal.as_ref(), *used, &covariance);
            if *used && weighted.view.distortion_bias.is_some() {
                let link = weighted.view.moving(&fit.configuration);
                outcome.distortion_score = weighted
                    .distortion_score(&link, &covariance)
                    .unwrap_or_default();
            }
            outcome
        })
        .collect();
    let gradients = bias_gradients::<D>(&seen.configuration, views, normals, used);
    if !gradients.is_empty() || updated_state.state.considered.is_some() {
        let gain = gain(&updated_state, fit, camera_index);
        updated_state.state.consider(&gain, &gradients);
    }
    let fitted = -0.5 * (fit.cost + updated_state.log_shrinkage);
    let state = updated_state.state;
    Some(GroupUpdate {
        state,
        fitted,
        refusal: 0.0,
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

/// Gradients of the consider parameters by the views that are used.
fn bias_gradients<const D: usize>(
    seen: &Configuration,
    views: &[WeightedView<'_>],
    normals: &[Option<ViewEquations>],
    used: &[bool],
) -> Vec<BiasGradient<D>> {
    let mut gradients: Vec<BiasGradient<D>> = Vec::new();
    let views = views.iter().zip(normals).zip(used);
    for ((weighted, normal), _) in views.filter(|(_, used)| **used) {
        let Some(normal) = normal else { continue };
        let own = weighted.bias_gradients(seen, normal);
        let chain_link = weighted
            .view
            .chain_link
            .as_ref()
            .filter(|_| !own.is_empty());
        let by_configuration = chain_link.map(|chain_link| chain_link.jacobian::<D>(seen));
        for gradient in own {
            gradient
                .about(by_configuration.as_ref())
                .join(&mut gradients);
        }
    }
    gradients
}

fn outcome(normal: Option<&ViewEquations>, used: bool, covariance: &Matrix6<f64>) -> ViewOutcome {
    let Some(normal) = normal else {
        return ViewOutcome::refused();
    };
    // The trace of the product: both are symmetric.
    let updated_state = if used {
        normal.information.dot(covariance)
    } else {
        0.0
    };
    ViewOutcome {
        used,
        expected: used,
        weighted_square: normal.weighted_square,
        redundancy: (8.0 - updated_state).clamp(0.4, 8.0),
        square_px: normal.square_px,
        distortion_score: [0.0; 2],
    }
}
