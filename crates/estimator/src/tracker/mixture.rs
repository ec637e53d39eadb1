//! The mixture of a track's hypotheses: mean of the likeliest, covariance of all, of the object and of its links and
//! joints.

use nalgebra::{Matrix6, SMatrix};
use sextant_geometry::se3;

use crate::FusionOptions;
use crate::filter::covariance::{is_wider_than, symmetric};
use crate::filter::joint_states::JointStates;
use crate::kinematics::chain::KinematicChain;
use crate::kinematics::configuration::Configuration;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::track::Track;
use sextant_site_model::MOST_JOINTS;
use sextant_site_report::{ArticulatedEstimate, JointEstimate, LinkEstimate, State};

/// Of a configuration.
const SIZE: usize = 6 + MOST_JOINTS;

/// An attitude that is possible.
struct MixtureComponent {
    at: Configuration,
    covariance: SMatrix<f64, SIZE, SIZE>,
    weight: f64,
}

impl Track {
    /// Of all that is possible, about the likeliest: the second moments of the mixture.
    pub fn covariance(&self) -> Matrix6<f64> {
        if let Some(covariance) = self.covariance_of_base() {
            return covariance;
        }
        let mut sum = Matrix6::zeros();
        let mut weights = 0.0;
        for one in &self.hypotheses {
            let weight = one.evidence.exp();
            let off = se3::difference(&one.state.pose, &self.hypotheses[0].state.pose);
            let own = one.state.pose_covariance();
            sum += (own + off * off.transpose()) * weight;
            weights += weight;
            if let Some((step, odds)) = one.twin() {
                let off = off + step;
                sum += (own + off * off.transpose()) * (weight * odds);
                weights += weight * odds;
            }
        }
        symmetric(&(sum / weights))
    }

    pub fn state(&self, covariance: &Matrix6<f64>, options: &FusionOptions) -> State {
        let vague = is_wider(covariance, options.vague_position, options.vague_attitude);
        if vague || self.refused_share(self.time_ns).is_some() {
            State::Initialising
        } else if self.summary.tags == 0 {
            State::Coasting
        } else {
            State::Tracking
        }
    }

    /// Whether all that is followed has about the same attitude.
    pub(crate) fn is_of_one_attitude(&self, options: &FusionOptions) -> bool {
        let mut pairs = self.hypotheses.iter().zip(self.hypotheses.iter().skip(1));
        pairs.all(|(a, b)| !a.is_turned_from(b, options))
    }

    /// Whether another attitude, followed or merely possible, is not unlikely enough.
    pub(crate) fn is_ambiguous(&self, options: &FusionOptions) -> bool {
        let Some(best) = self.hypotheses.first() else {
            return false;
        };
        if best.confirmed_odds < options.trusted_odds {
            return true;
        }
        let others = self.hypotheses.iter().skip(1);
        let rivals = others
            .filter(|other| best.is_turned_from(other, options))
            .map(|other| other.evidence);
        rivals
            .chain([best.mirrored])
            .any(|evidence| evidence > -options.trusted_odds)
    }

    /// Links and joints; `None` where the object is rigid.
    pub fn articulated(&self) -> Option<Box<ArticulatedEstimate>> {
        let best = self.hypotheses.first()?;
        let joints = best.state.joints.as_deref()?;
        let possible: Vec<MixtureComponent> = self.hypotheses.iter().flat_map(possible).collect();
        let links = (0..joints.chain.articulation.links().len())
            .map(|link| link_estimate(&joints.chain, link, &possible));
        let joints = joints.chain.moving().enumerate().map(|(slot, joint)| {
            let (variance, velocity_variance) = variances(&self.hypotheses, joints, slot);
            JointEstimate {
                joint: joint.id.clone(),
                value: joints.values[slot],
                variance,
                velocity: joints.speeds[slot],
                velocity_variance,
            }
        });
        Some(Box::new(ArticulatedEstimate {
            links: links.collect(),
            joints: joints.collect(),
        }))
    }

    /// Of the link that is the object's pose; `None` where the object is rigid.
    fn covariance_of_base(&self) -> Option<Matrix6<f64>> {
        let joints = self.hypotheses.first()?.state.joints.as_deref()?;
        let possible: Vec<MixtureComponent> = self.hypotheses.iter().flat_map(possible).collect();
        let base = joints.chain.articulation.base();
        Some(link_estimate(&joints.chain, base, &possible).covariance)
    }
}

/// A hypothesis, and the mirrored attitude while that is not settled.
fn possible(one: &Hypothesis) -> Vec<MixtureComponent> {
    let own = one.state.observed::<SIZE>(usize::MAX).covariance;
    let covariance = own * one.state.covariance_inflation() + one.state.bias_covariance();
    let (at, weight) = (one.state.configuration(), one.evidence.exp());
    let mut all = vec![MixtureComponent {
        at,
        covariance,
        weight,
    }];
    if let Some((step, odds)) = one.twin() {
        all.push(MixtureComponent {
            at: Configuration {
                pose: se3::perturb(&at.pose, &step),
                ..at
            },
            covariance,
            weight: weight * odds,
        });
    }
    all
}

fn link_estimate(
    chain: &KinematicChain,
    link: usize,
    possible: &[MixtureComponent],
) -> LinkEstimate {
    let world_from_link = chain.world_from_link(&possible[0].at, link);
    let mut sum = Matrix6::zeros();
    let mut weights = 0.0;
    for one in possible {
        let off = se3::difference(&chain.world_from_link(&one.at, link), &world_from_link);
        let jacobian = chain.jacobian::<SIZE>(&one.at, link);
        let own = jacobian * one.covariance * jacobian.transpose();
        sum += (own + off * off.transpose()) * one.weight;
        weights += one.weight;
    }
    LinkEstimate {
        link: chain.articulation.links()[link].clone(),
        world_from_link,
        covariance: symmetric(&(sum / weights)),
    }
}

/// Of a joint's value and velocity.
fn variances(hypotheses: &[Hypothesis], best: &JointStates, slot: usize) -> (f64, f64) {
    let (mut value, mut velocity, mut weights) = (0.0, 0.0, 0.0);
    for one in hypotheses {
        let Some(joints) = &one.state.joints else {
            continue;
        };
        let (weight, inflation) = (one.evidence.exp(), one.state.covariance_inflation());
        let speed = MOST_JOINTS + slot;
        let off_value = joints.values[slot] - best.values[slot];
        let off_speed = joints.speeds[slot] - best.speeds[slot];
        let lasting = one.state.bias_covariance::<SIZE>()[(6 + slot, 6 + slot)];
        value += weight * (inflation * joints.own[(slot, slot)] + lasting + off_value.powi(2));
        velocity += weight * (inflation * joints.own[(speed, speed)] + off_speed.powi(2));
        weights += weight;
    }
    (value / weights, velocity / weights)
}

/// Whether one sigma along the worst axis exceeds the metres or the radians.
pub(crate) fn is_wider(covariance: &Matrix6<f64>, position: f64, attitude: f64) -> bool {
    let block = |from: usize| covariance.fixed_view::<3, 3>(from, from).into_owned();
    is_wider_than(&block(0), position.powi(2)) || is_wider_than(&block(3), attitude.powi(2))
}
