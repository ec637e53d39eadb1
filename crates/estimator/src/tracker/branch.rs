//! Stage 4: what else may have happened where views contradict the prediction: the body was hit, the views are wrong,
//! or the object was put elsewhere while nobody looked.
//!
//! Where nothing is known before, every tag gives two poses (the planar ambiguity). Each of them, as a configuration of
//! the object, is refined on all corners of all cameras and weighed by its evidence.

use std::sync::Arc;

use nalgebra::Vector6;

use crate::FusionOptions;
use crate::filter::covariance::Covariance;
use crate::filter::joint_states::JointStates;
use crate::filter::process_noise::{ProcessNoise, ProcessNoisePsd};
use crate::filter::state::ObjectState;
use crate::kinematics::chain::KinematicChain;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::measurement::planar_poses::{area, branches, is_beside};
use crate::tracker::camera_consistency::CameraConsistency;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::predict::Prediction;
use crate::tracker::update::joint_search::by_branch;
use crate::tracker::update::{image_refusal, refused, update_state};

/// Seconds over which a jolt counts at least: a blow takes no time, and is as hard however soon the next image comes.
const BLOW_S: f64 = 1.0 / 30.0;

/// Half a squared residual for each of eight coordinates: what a view costs where its fault is known.
const USUAL: f64 = 4.0;

/// Jolts are of any size: were only the hardest considered, a wrong tag would often be likelier.
const JOLTS: [f64; 2] = [0.1, 1.0];

/// Views from which attitudes are proposed: the largest ones, enough that a few wrong tags don't matter.
const MOST_SEEDS: usize = 6;
/// Seeds that are refined.
const MOST_GROWN: usize = 4;
/// Metres and radians, one sigma: nothing is known about the pose.
const ANYWHERE: (f64, f64) = (10.0, 3.0);

/// All branches of the hypotheses at an instant, with `updated` of each of them; where there are none, the attitudes
/// that the images allow.
pub(crate) fn branch(
    prediction: &Prediction<'_>,
    updated: Vec<Vec<Hypothesis>>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    if prediction.is_initialisation() {
        return initialise(views, options);
    }
    let is_contradicted = updated.iter().all(Vec::is_empty);
    let parents = &prediction.track.hypotheses;
    let predicted = parents.iter().zip(&prediction.states);
    let mut all = Vec::new();
    for ((parent, state), updated) in predicted.zip(updated) {
        let mut branches = with_jolts(state, prediction.elapsed_s, updated, views, options);
        penalise(&mut branches, -parent.evidence);
        for one in &mut branches {
            one.confirmed_odds = parent.confirmed_odds;
            one.compare_cameras(&parent.consistency, views, options);
        }
        all.extend(branches);
    }
    let is_wrong = |weighted: &WeightedView<'_>| {
        let consistency = &parents[0].consistency;
        consistency.is_wrong(weighted.camera_index)
    };
    if is_contradicted && !views.iter().all(is_wrong) {
        // Put elsewhere while nobody looked: worth its odds if the views agree among themselves.
        let mut elsewhere = initialise(views, options);
        penalise(&mut elsewhere, options.jolt_odds);
        all.extend(elsewhere);
    }
    all
}

/// Branches of a predicted state `elapsed_s` seconds after the last instant. Where views contradict the prediction,
/// either the body was hit or the views are wrong; later images decide. All views of one of several simultaneous images
/// are enough: along its line of sight another camera may agree with anything.
fn with_jolts(
    predicted: &ObjectState,
    elapsed_s: f64,
    updated: Vec<Hypothesis>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let is_contradicted = updated.is_empty();
    let mut branches = updated;
    for strength in JOLTS {
        if !branches.iter().all(|one| one.leaves_out_an_image(views)) {
            break;
        }
        let jolted = jolted(predicted, elapsed_s, strength, options);
        let mut hit = update_state(&jolted, views, options);
        penalise(&mut hit, options.jolt_odds);
        for outcome in hit.iter_mut().flat_map(|one| &mut one.outcomes) {
            outcome.expected = false;
        }
        branches.extend(hit);
    }
    if is_contradicted {
        branches.push(refused(predicted.clone(), views, options));
    }
    branches
}

/// The prediction if the body was hit in the last `dt` seconds, with a share of the hardest jolt.
fn jolted(predicted: &ObjectState, dt: f64, strength: f64, options: &FusionOptions) -> ObjectState {
    let mut jolted = predicted.clone();
    jolted.motion.begin_anew(dt);
    for axis in 0..6 {
        let acceleration = if axis < 3 {
            options.linear_jolt
        } else {
            options.angular_jolt
        };
        let speed = strength * acceleration * dt.max(BLOW_S);
        let step = 0.5 * speed * dt;
        jolted.covariance[(axis, axis)] += step * step;
        jolted.covariance[(axis, axis + 6)] += step * speed;
        jolted.covariance[(axis + 6, axis)] += step * speed;
        // A little more than the perfectly correlated part, so that the covariance stays definite.
        jolted.covariance[(axis + 6, axis + 6)] += speed * speed * 1.1;
    }
    if let Some(joints) = &mut jolted.joints {
        joints.jolt(dt, strength * dt.max(BLOW_S), options);
    }
    jolted
}

/// Lowers the evidence by the logarithm of odds.
fn penalise(hypotheses: &mut [Hypothesis], odds: f64) {
    for one in hypotheses {
        one.evidence -= odds;
    }
}

impl Hypothesis {
    /// Whether no view of one of the images is used.
    fn leaves_out_an_image(&self, views: &[WeightedView<'_>]) -> bool {
        let pairs: Vec<_> = views.iter().zip(&self.outcomes).collect();
        let mut images = pairs.chunk_by(|(a, _), (b, _)| a.camera_index == b.camera_index);
        images.any(|image| !image.iter().any(|(_, outcome)| outcome.used))
    }

    /// Records the cameras of which no view is used. A further such image of a wrong camera costs the odds of a jolt
    /// and of usual residuals.
    fn compare_cameras(
        &mut self,
        before: &CameraConsistency,
        views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) {
        if !before.is_in_doubt() && self.outcomes.iter().all(|outcome| outcome.used) {
            return;
        }
        self.consistency.clone_from(before);
        let pairs: Vec<_> = views.iter().zip(&self.outcomes).collect();
        for image in pairs.chunk_by(|(a, _), (b, _)| a.camera_index == b.camera_index) {
            let camera = image[0].0.camera_index;
            let is_used = image.iter().any(|(_, outcome)| outcome.used);
            if !is_used && self.consistency.is_wrong(camera) {
                let again = options.jolt_odds + USUAL * image.len() as f64;
                self.evidence += (image_refusal(image.len(), options) - again).max(0.0);
            }
            self.consistency.record(camera, is_used);
        }
    }
}

/// The attitudes that the images of one instant allow when nothing is known before, in no order.
fn initialise(views: &[WeightedView<'_>], options: &FusionOptions) -> Vec<Hypothesis> {
    let first = views.first();
    let chain = first.and_then(|weighted| Some(&weighted.view.chain_link.as_ref()?.chain));
    let mut all: Vec<Hypothesis> = Vec::new();
    for seed in likeliest(seeds(views), views) {
        // The tags of an object agree, mostly: one of their seeds is enough.
        let is_beside = |one: &Hypothesis| is_beside(&seed, &one.state.configuration(), views);
        if !all.iter().any(is_beside) {
            all.extend(update_state(
                &unknown(&seed, chain, options),
                views,
                options,
            ));
        }
    }
    all
}
/// The few seeds that explain all views best as they are.
fn likeliest(seeds: Vec<Configuration>, views: &[WeightedView<'_>]) -> Vec<Configuration> {
    let cost = |at: &Configuration| -> f64 { views.iter().map(|weighted| weighted.chi2(at)).sum() };
    let mut scored: Vec<(f64, Configuration)> =
        seeds.into_iter().map(|seed| (cost(&seed), seed)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    scored
        .into_iter()
        .take(MOST_GROWN)
        .map(|(_, seed)| seed)
        .collect()
}

/// The configuration by each branch of the largest views.
fn seeds(views: &[WeightedView<'_>]) -> Vec<Configuration> {
    let mut largest: Vec<&WeightedView<'_>> = views.iter().collect();
    largest.sort_by(|a, b| area(b).total_cmp(&area(a)));
    largest
        .into_iter()
        .take(MOST_SEEDS)
        .flat_map(|weighted| {
            let branches = branches(weighted).into_iter();
            branches.map(|branch| by_branch(weighted, &branch, views))
        })
        .collect()
}

/// An object of which only the start for the search is known.
fn unknown(
    seed: &Configuration,
    chain: Option<&Arc<KinematicChain>>,
    options: &FusionOptions,
) -> ObjectState {
    let mut covariance = Covariance::zeros();
    for axis in 0..3 {
        covariance[(axis, axis)] = ANYWHERE.0.powi(2);
        covariance[(axis + 3, axis + 3)] = ANYWHERE.1.powi(2);
        covariance[(axis + 6, axis + 6)] = options.start_speed.powi(2);
        covariance[(axis + 9, axis + 9)] = options.start_angular_speed.powi(2);
    }
    ObjectState {
        pose: seed.pose,
        twist: Vector6::zeros(),
        covariance,
        clocks: None,
        joints: chain.map(|chain| Box::new(JointStates::unknown(chain, seed, options))),
        considered: None,
        information_gain: 0.0,
        motion: ProcessNoise::new(process_noise_psd(options)),
    }
}

fn process_noise_psd(options: &FusionOptions) -> ProcessNoisePsd {
    ProcessNoisePsd {
        linear: options.linear_acceleration_psd,
        angular: options.angular_acceleration_psd,
        clocks: options.clock_wander,
    }
}
