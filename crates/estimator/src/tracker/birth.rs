//! Attitudes that the images of one instant allow when nothing is known before.
//!
//! Every tag gives two poses (the planar ambiguity). Each of them, as a configuration of the object, is refined on all
//! corners of all cameras and weighed by its evidence.

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
use crate::measurement::planar_poses::{area, branches};
use crate::tracker::branching::updates;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::joint_search::by_branch;
use crate::tracker::planar_ambiguity::is_beside;

/// Views from which attitudes are proposed: the largest ones, enough that a few wrong tags don't matter.
const MOST_SEEDS: usize = 6;
/// Seeds that are refined.
const MOST_GROWN: usize = 4;
/// Metres and radians, one sigma: nothing is known about the pose.
const ANYWHERE: (f64, f64) = (10.0, 3.0);

/// The possible attitudes, in no order.
pub(crate) fn hypotheses(
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let chain = weighted_views
        .first()
        .and_then(|weighted| Some(&weighted.view.chain_link.as_ref()?.chain));
    let mut all: Vec<Hypothesis> = Vec::new();
    for seed in likeliest(seeds(weighted_views), weighted_views) {
        // The tags of an object agree, mostly: one of their seeds is enough.
        let is_beside =
            |one: &Hypothesis| is_beside(&seed, &one.state.configuration(), weighted_views);
        if !all.iter().any(is_beside) {
            all.extend(updates(
                &unknown(&seed, chain, options),
                weighted_views,
                options,
            ));
        }
    }
    for one in &mut all {
        one.confirm(0.0, weighted_views, options);
    }
    all
}

/// The few seeds that explain all views best as they are.
fn likeliest(seeds: Vec<Configuration>, weighted_views: &[WeightedView<'_>]) -> Vec<Configuration> {
    let cost = |at: &Configuration| -> f64 {
        weighted_views
            .iter()
            .map(|weighted| weighted.chi2(at))
            .sum()
    };
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
fn seeds(weighted_views: &[WeightedView<'_>]) -> Vec<Configuration> {
    let mut largest: Vec<&WeightedView<'_>> = weighted_views.iter().collect();
    largest.sort_by(|a, b| area(b).total_cmp(&area(a)));
    largest
        .into_iter()
        .take(MOST_SEEDS)
        .flat_map(|weighted| {
            let branches = branches(weighted).into_iter();
            branches.map(|branch| by_branch(weighted, &branch, weighted_views))
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
