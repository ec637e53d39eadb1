//! Stage 5: the branches that remain, likeliest first, and what the track learns from the views of the likeliest.

use std::borrow::Cow;

use nalgebra::Vector6;
use sextant_geometry::{Pose, se3};

use crate::FusionOptions;
use crate::filter::covariance::Covariance;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::measurement::planar_poses::{area, branches, largest, mirrored};
use crate::tracker::hypothesis::{Hypothesis, ViewOutcome};
use crate::tracker::noise_scales::NoiseScales;
use crate::tracker::predict::Prediction;
use crate::tracker::track::{InstantSummary, Track};
use sextant_site_report::State;

/// Most attitudes followed at a time.
const MOST_HYPOTHESES: usize = 4;
/// Squared Mahalanobis distance of hypotheses that have run together.
const NEAR: f64 = 0.1;
/// Residual of a tag's corners over its edge from which on it contradicts, whatever the noise estimated for its camera;
/// less than a pixel never does.
const MOST_OFF: f64 = 0.06;

/// The track at the instant of a prediction by the likeliest of the branches. One that is initialised keeps of the
/// track before what [`Track::reset`] does.
pub(crate) fn prune(
    prediction: &Prediction<'_>,
    mut hypotheses: Vec<Hypothesis>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Track {
    weigh(&mut hypotheses, options);
    for one in &mut hypotheses {
        one.confirm(views, options);
    }
    let is_initialisation = prediction.is_initialisation();
    let before = if is_initialisation {
        Cow::Owned(prediction.track.reset())
    } else {
        Cow::Borrowed(&*prediction.track)
    };
    let mut next = Track {
        time_ns: prediction.time_ns,
        hypotheses,
        noise: before.noise.clone(),
        trusted: before.trusted,
        timing: before.timing.clone(),
        participation: before.participation.clone(),
        views: before.views,
        ..Track::default()
    };
    if !next.hypotheses.is_empty() {
        next.learn(&before, views, options);
    }
    if !is_initialisation && !next.uses_views {
        next.contradicted_since_ns = before.contradicted_since_ns.or(Some(next.time_ns));
    }
    next
}

/// Sorts by evidence, merges equal hypotheses and drops hopeless ones. The likeliest then has evidence zero.
fn weigh(hypotheses: &mut Vec<Hypothesis>, options: &FusionOptions) {
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

impl Hypothesis {
    /// Adds the odds of the views that are used against the mirrored attitude to those of earlier ones.
    fn confirm(&mut self, views: &[WeightedView<'_>], options: &FusionOptions) {
        if self.confirmed_odds < options.trusted_odds {
            let used: Vec<_> = self.used(views).collect();
            let at = self.state.configuration();
            let odds = odds_against_mirrored(&at, &used);
            self.to_mirrored = step_to_mirrored(&at, &used);
            self.confirmed_odds += odds;
        }
    }

    /// Noise scales after the views of this instant.
    fn noise_after(
        &self,
        mut noise: NoiseScales,
        views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> NoiseScales {
        let pairs = || views.iter().zip(&self.outcomes);
        for (weighted, outcome) in pairs() {
            let same_image = |other: &WeightedView<'_>| other.camera_index == weighted.camera_index;
            let image = || pairs().filter(|(other, _)| same_image(other));
            let n_used = image().filter(|(_, outcome)| outcome.used).count();
            let may_be_noise = || {
                let link = weighted.view.moving(&self.state.configuration());
                NoiseScales::can_explain(weighted, &link)
            };
            // Wrong among right ones is no noise, nor is what is off by more than noise again and again while others
            // are right.
            let is_fault = || {
                2 * n_used > image().count()
                    || self.consistency.is_wrong(weighted.camera_index) && !may_be_noise()
            };
            if !outcome.used && is_fault() {
                continue;
            }
            noise.learn(weighted, outcome, options);
        }
        noise
    }
}

/// The step to the mirrored attitude of the largest view.
fn step_to_mirrored(at: &Configuration, views: &[&WeightedView<'_>]) -> Option<Vector6<f64>> {
    let largest = largest(views.iter().copied())?;
    Some(se3::difference(&mirrored(largest, at).pose, &at.pose))
}

/// Logarithm of the odds of the images of one instant against the mirrored attitude, by their corners alone. The motion
/// does not count: a mirrored motion is as smooth as the true one.
fn odds_against_mirrored(at: &Configuration, views: &[&WeightedView<'_>]) -> f64 {
    let Some(largest) = largest(views.iter().copied()) else {
        return 0.0;
    };
    if views.len() > 1 {
        let all = |at: &Configuration| -> f64 { views.iter().map(|one| one.chi2(at)).sum() };
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

impl Track {
    /// Takes in what the likeliest hypothesis says of the views of this instant; `before` is the track before them.
    fn learn(&mut self, before: &Self, views: &[WeightedView<'_>], options: &FusionOptions) {
        let best = &self.hypotheses[0];
        for (weighted, outcome) in views.iter().zip(&best.outcomes) {
            let most_square_px = 8.0 * (MOST_OFF.powi(2) * area(weighted)).max(1.0);
            let agrees = outcome.used && outcome.square_px <= most_square_px;
            self.views.add(self.time_ns, !agrees);
        }
        let summary = summarise(&best.outcomes, views);
        let cameras: Vec<usize> = best.used(views).map(|one| one.camera_index).collect();
        self.uses_views = summary.tags > 0;
        self.record_participation(&cameras);
        let same_instant = before.time_ns == self.time_ns && !before.hypotheses.is_empty();
        self.summary = if same_instant {
            before.summary.joined(summary)
        } else {
            summary
        };
        self.seen_ns = if self.uses_views {
            self.time_ns
        } else {
            before.seen_ns
        };
        // What was hit or not is no doubt about which corners are which.
        if self.is_of_one_attitude(options) {
            let noise = std::mem::take(&mut self.noise);
            self.noise = self.hypotheses[0].noise_after(noise, views, options);
        }
        let state = self.state(&self.covariance(), options);
        self.trusted |= state == State::Tracking && !self.is_ambiguous(options);
        let is_doubtful = state == State::Initialising;
        let since_ns = before.doubtful_since_ns.unwrap_or(self.time_ns);
        self.doubtful_since_ns = is_doubtful.then_some(since_ns);
    }

    /// Records when cameras were last used; successive views of one camera are one entry.
    fn record_participation(&mut self, cameras: &[usize]) {
        let earlier = |(camera, _): &(usize, u64)| !cameras.contains(camera);
        self.participation.retain(earlier);
        for &camera in cameras {
            let last = self.participation.last();
            if last.is_none_or(|(last, _)| *last != camera) {
                self.participation.push((camera, self.time_ns));
            }
        }
    }
}

/// Contribution of the views of an instant.
fn summarise(outcomes: &[ViewOutcome], views: &[WeightedView<'_>]) -> InstantSummary {
    let pairs = || views.iter().zip(outcomes);
    let (used, refused): (Vec<_>, Vec<_>) = pairs().partition(|(_, outcome)| outcome.used);
    let mut cameras: Vec<usize> = used.iter().map(|(one, _)| one.camera_index).collect();
    cameras.dedup();
    InstantSummary {
        cameras: cameras.len() as u32,
        tags: used.len() as u32,
        square_px: used.iter().map(|(_, outcome)| outcome.square_px).sum(),
        refused: refused.iter().map(|(one, _)| one.camera_index).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::process_noise::{ProcessNoise, ProcessNoisePsd};
    use crate::filter::state::ObjectState;
    use nalgebra::Vector3;

    /// At a place of its own, with evidence from the corners alone.
    fn hypothesis(metres: f64, evidence: f64) -> Hypothesis {
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
            ..Hypothesis::refused(state, 0.0, 0)
        }
    }

    #[test]
    fn sharp_attitudes_are_weighed_by_all_that_the_corners_say() {
        let mut both = vec![hypothesis(0.0, -44.0), hypothesis(1.0, -31.0)];
        weigh(&mut both, &FusionOptions::default());
        assert_eq!(both[1].evidence, -13.0);
    }
}
