//! Branches of a hypothesis at an instant: updated by the views, hit in the meantime, or with all views rejected; and
//! their weighing.

use sextant_geometry::se3;

use crate::FusionOptions;
use crate::filter::covariance::Covariance;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::tracker::camera_consistency::CameraConsistency;
use crate::tracker::gating::{image_refusal, refused, updated};
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::{joint_search, planar_ambiguity};
use sextant_site_model::MOST_JOINTS;

/// Most attitudes followed at a time.
const MOST_HYPOTHESES: usize = 4;

impl Hypothesis {
    /// Branches of the hypothesis after `dt` seconds with the views of that instant. Where views contradict the
    /// prediction, either the body was hit or the views are wrong; later images decide. All views of one of several
    /// simultaneous images are enough: along its line of sight another camera may agree with anything.
    pub fn followed(
        &self,
        dt: f64,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> Branches {
        let chain_links = weighted_views
            .iter()
            .filter_map(|weighted| weighted.view.chain_link.as_ref());
        let predicted = self.state.predicted(dt);
        let predicted = predicted.reanchored_to_best(chain_links.map(|chain_link| chain_link.link));
        let mut ways = updates(&predicted, weighted_views, options);
        let contradicted = ways.is_empty();
        for strength in JOLTS {
            if !ways
                .iter()
                .all(|way| way.leaves_out_an_image(weighted_views))
            {
                break;
            }
            let mut hit = updates(
                &jolted(&predicted, dt, strength, options),
                weighted_views,
                options,
            );
            penalise(&mut hit, options.jolt_odds);
            let outcome = hit.iter_mut().flat_map(|way| &mut way.outcomes);
            outcome.for_each(|outcome| outcome.expected = false);
            ways.extend(hit);
        }
        if contradicted {
            ways.push(refused(predicted, weighted_views, options));
        }
        penalise(&mut ways, -self.evidence);
        for way in &mut ways {
            way.doubt(&self.consistency, weighted_views, options);
            way.confirm(self.confirmed_odds, weighted_views, options);
        }
        Branches { ways, contradicted }
    }

    /// Whether no view of one of the images took part.
    pub(crate) fn leaves_out_an_image(&self, weighted_views: &[WeightedView<'_>]) -> bool {
        let pairs: Vec<_> = weighted_views.iter().zip(&self.outcomes).collect();
        let mut images = pairs.chunk_by(|(a, _), (b, _)| a.camera_index == b.camera_index);
        images.any(|image| !image.iter().any(|(_, outcome)| outcome.part))
    }

    /// Remembers the cameras without a view that took part. A further such image of a wrong camera costs the odds of a
    /// jolt and of usual residuals.
    pub(crate) fn doubt(
        &mut self,
        before: &CameraConsistency,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) {
        if !before.is_in_doubt() && self.outcomes.iter().all(|outcome| outcome.part) {
            return;
        }
        self.consistency.clone_from(before);
        let pairs: Vec<_> = weighted_views.iter().zip(&self.outcomes).collect();
        for image in pairs.chunk_by(|(a, _), (b, _)| a.camera_index == b.camera_index) {
            let camera = image[0].0.camera_index;
            let part = image.iter().any(|(_, outcome)| outcome.part);
            if !part && self.consistency.is_wrong(camera) {
                let again = options.jolt_odds + USUAL * image.len() as f64;
                self.evidence += (image_refusal(image.len(), options) - again).max(0.0);
            }
            self.consistency.note(camera, part);
        }
    }
}

/// Branches of a hypothesis at the next instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Branches {
    pub ways: Vec<Hypothesis>,
    /// Whether no view agrees with the prediction.
    pub contradicted: bool,
}

/// Lowers the evidence by the logarithm of odds.
pub(crate) fn penalise(hypotheses: &mut [Hypothesis], odds: f64) {
    for one in hypotheses {
        one.evidence -= odds;
    }
}

/// The updates that the views allow, one for each attitude that is a possibility of its own; none where no view agrees
/// with the prior.
pub(crate) fn updates(
    prior: &ObjectState,
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let rolling = weighted_views
        .iter()
        .any(|weighted| weighted.view.after_s.is_some());
    match (
        rolling,
        prior.joints.as_ref().map_or(0, |joints| joints.moving),
    ) {
        (false, 0) => updates_of_size::<6>(prior, weighted_views, options),
        (false, 1..=2) => updates_of_size::<8>(prior, weighted_views, options),
        (false, _) => updates_of_size::<{ 6 + MOST_JOINTS }>(prior, weighted_views, options),
        (true, 0) => updates_of_size::<12>(prior, weighted_views, options),
        (true, _) => updates_of_size::<{ 2 * (6 + MOST_JOINTS) }>(prior, weighted_views, options),
    }
}

/// The same with the size of a configuration.
fn updates_of_size<const D: usize>(
    prior: &ObjectState,
    weighted_views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let update =
        |start: Option<&Configuration>| updated::<D>(prior, start, weighted_views, options);
    let searched =
        joint_search::start(prior, weighted_views).and_then(|start| update(Some(&start)));
    let (found, second) = match (update(None), searched) {
        (Some(found), Some(other)) if other.evidence > found.evidence => (other, Some(found)),
        (Some(found), other) => (found, other),
        (None, Some(other)) => (other, None),
        (None, None) => return Vec::new(),
    };
    let at = found.state.configuration();
    let others = planar_ambiguity::others::<D>(prior, &at, weighted_views, options);
    let mut all: Vec<Hypothesis> = others
        .starts
        .iter()
        .filter_map(|start| update(Some(start)))
        .chain(second)
        .collect();
    all.push(Hypothesis {
        mirrored: others.mirrored_odds,
        ..found
    });
    all
}

/// Seconds over which a jolt counts at least: a blow takes no time, and is as hard however soon the next image comes.
pub(crate) const BLOW_S: f64 = 1.0 / 30.0;

/// Half a squared residual for each of eight coordinates: what a view costs where its fault is known.
const USUAL: f64 = 4.0;

/// Jolts are of any size: were only the hardest thought of, a wrong tag would often be likelier.
const JOLTS: [f64; 2] = [0.1, 1.0];

/// The prediction if the body was hit in the meantime, with a share of the hardest jolt.
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
        let way = 0.5 * speed * dt;
        jolted.covariance[(axis, axis)] += way * way;
        jolted.covariance[(axis, axis + 6)] += way * speed;
        jolted.covariance[(axis + 6, axis)] += way * speed;
        // A little more than the perfectly correlated part, so that the covariance stays definite.
        jolted.covariance[(axis + 6, axis + 6)] += speed * speed * 1.1;
    }
    if let Some(joints) = &mut jolted.joints {
        joints.jolt(dt, strength * dt.max(BLOW_S), options);
    }
    jolted
}

/// Sorts by evidence, merges equal hypotheses and drops hopeless ones. The likeliest then has evidence zero.
pub(crate) fn weigh(hypotheses: &mut Vec<Hypothesis>, options: &FusionOptions) {
    hypotheses.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let Some(best) = hypotheses.first().map(|one| one.evidence) else {
        return;
    };
    let mut kept: Vec<Hypothesis> = Vec::new();
    for mut one in hypotheses.drain(..) {
        one.evidence -= best;
        let hopeless = one.evidence.is_nan() || one.evidence < -options.hopeless_odds;
        if !hopeless
            && kept.len() < MOST_HYPOTHESES
            && !kept.iter().any(|other| is_same(other, &one))
        {
            kept.push(one);
        }
    }
    *hypotheses = kept;
}

/// Squared Mahalanobis distance of hypotheses that have run together.
const NEAR: f64 = 0.1;

/// Whether two hypotheses are the same: nearer than a third of their uncertainty. Two branches of a vague tag may lie
/// within one standard deviation and still be two.
fn is_same(a: &Hypothesis, b: &Hypothesis) -> bool {
    let off = se3::difference(&a.state.pose, &b.root_of(a));
    let covariance: Covariance = a.state.covariance;
    let inverse = covariance.fixed_view::<6, 6>(0, 0).into_owned().cholesky();
    inverse.is_some_and(|factor| off.dot(&factor.solve(&off)) < NEAR) && same_joints(a, b)
}

fn same_joints(a: &Hypothesis, b: &Hypothesis) -> bool {
    let pair = a.state.joints.as_ref().zip(b.state.joints.as_ref());
    pair.is_none_or(|(a, b)| {
        let off = |slot: usize| a.values[slot] - b.values[slot];
        (0..a.moving).all(|slot| off(slot).powi(2) < NEAR * a.sigma(slot).powi(2))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::process_noise::{ProcessNoise, ProcessNoisePsd};
    use nalgebra::Vector3;
    use nalgebra::Vector6;
    use sextant_geometry::Pose;

    /// At a place of its own, with evidence from the corners alone.
    pub(crate) fn hypothesis(metres: f64, evidence: f64, vague: bool) -> Hypothesis {
        let state = ObjectState {
            pose: Pose::from_parts(Vector3::x().scale(metres).into(), Default::default()),
            twist: Vector6::zeros(),
            covariance: Covariance::identity() * 1e-6,
            clocks: None,
            joints: None,
            considered: None,
            information_gain: 0.0,
            motion: ProcessNoise::new(ProcessNoisePsd {
                linear: 1.0,
                angular: 1.0,
                clocks: 1.0,
            }),
        };
        Hypothesis {
            evidence,
            vague,
            ..refused(state, &[], &FusionOptions::default())
        }
    }

    #[test]
    pub(crate) fn sharp_attitudes_are_weighed_by_all_that_the_corners_say() {
        let mut both = vec![hypothesis(0.0, -44.0, false), hypothesis(1.0, -31.0, false)];
        weigh(&mut both, &FusionOptions::default());
        assert_eq!(both[1].evidence, -13.0);
    }
}
