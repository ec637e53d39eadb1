//! The attitudes that the images of one instant allow when nothing is known before.
//!
//! Every tag gives two poses (the planar ambiguity). Each of them, as a configuration of the object, is refined on all corners of
//! all cameras; the evidence says which are possible.

use std::sync::Arc;

use nalgebra::Vector6;

use crate::FusionOptions;
use crate::filter::covariance::Covariance;
use crate::filter::joint_states::Joints;
use crate::filter::process_noise::{Motion, Restlessness};
use crate::filter::state::Kinematics;
use crate::kinematics::chain::Chain;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::Sight;
use crate::measurement::planar_poses::area;
use crate::measurement::planar_poses::branches;
use crate::tracker::branching::taken_in;
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
pub(crate) fn hypotheses(sights: &[Sight<'_>], options: &FusionOptions) -> Vec<Hypothesis> {
    let chain = sights
        .first()
        .and_then(|sight| Some(&sight.view.limb.as_ref()?.chain));
    let mut all: Vec<Hypothesis> = Vec::new();
    for seed in likeliest(seeds(sights), sights) {
        // The tags of an object agree, mostly: one of their seeds is enough.
        let is_beside = |one: &Hypothesis| is_beside(&seed, &one.state.configuration(), sights);
        if !all.iter().any(is_beside) {
            all.extend(taken_in(&unknown(&seed, chain, options), sights, options));
        }
    }
    for one in &mut all {
        one.settle(0.0, sights, options);
    }
    all
}

/// The few seeds that explain all views best as they are.
fn likeliest(seeds: Vec<Configuration>, sights: &[Sight<'_>]) -> Vec<Configuration> {
    let cost = |at: &Configuration| -> f64 { sights.iter().map(|sight| sight.chi2(at)).sum() };
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
fn seeds(sights: &[Sight<'_>]) -> Vec<Configuration> {
    let mut largest: Vec<&Sight<'_>> = sights.iter().collect();
    largest.sort_by(|a, b| area(b).total_cmp(&area(a)));
    largest
        .into_iter()
        .take(MOST_SEEDS)
        .flat_map(|sight| {
            let branches = branches(sight).into_iter();
            branches.map(|branch| by_branch(sight, &branch, sights))
        })
        .collect()
}

/// An object of which only the start for the search is known.
fn unknown(
    seed: &Configuration,
    chain: Option<&Arc<Chain>>,
    options: &FusionOptions,
) -> Kinematics {
    let mut covariance = Covariance::zeros();
    for axis in 0..3 {
        covariance[(axis, axis)] = ANYWHERE.0.powi(2);
        covariance[(axis + 3, axis + 3)] = ANYWHERE.1.powi(2);
        covariance[(axis + 6, axis + 6)] = options.start_speed.powi(2);
        covariance[(axis + 9, axis + 9)] = options.start_angular_speed.powi(2);
    }
    Kinematics {
        pose: seed.pose,
        twist: Vector6::zeros(),
        covariance,
        clocks: None,
        joints: chain.map(|chain| Box::new(Joints::unknown(chain, seed, options))),
        considered: None,
        news: 0.0,
        motion: Motion::new(restlessness(options)),
    }
}

fn restlessness(options: &FusionOptions) -> Restlessness {
    Restlessness {
        linear: options.linear_restlessness,
        angular: options.angular_restlessness,
        clocks: options.clock_wander,
    }
}
