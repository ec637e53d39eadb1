//! One attitude that explains the images: a filter, and the evidence for it.

use nalgebra::Matrix6;
use sextant_geometry::{Pose, se3};

use super::{MOST_HYPOTHESES, mirror, restlessness};
use crate::FusionOptions;
use crate::filter::absorb::{absorb, pose_prior};
use crate::filter::corners::{Normal, Sight};
use crate::filter::kinematics::{Covariance, Kinematics};
use crate::filter::solve::{Fit, UNSEEN, solve};

/// What became of a view in an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Taken {
    /// Whether it took part.
    pub part: bool,
    /// Of its corners after the update.
    pub chi2: f64,
    /// Degrees of freedom that its residuals keep after the update.
    pub redundancy: f64,
    /// Sum of its squared residuals in px².
    pub square_px: f64,
}

/// One attitude.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Hypothesis {
    pub state: Kinematics,
    /// Logarithm of its odds against the likeliest.
    pub evidence: f64,
    /// Logarithm of the odds of the mirrored attitude against this one; minus infinity where it is out of question.
    pub mirrored: f64,
    /// What became of each view at the last instant.
    pub taken: Vec<Taken>,
}

impl Hypothesis {
    /// What becomes of the hypothesis after `dt` seconds with the views of that instant: the attitude expected, and where
    /// the views allow it the mirrored one too. Where no view agrees it is a prediction.
    pub fn followed(&self, dt: f64, sights: &[Sight<'_>], options: &FusionOptions) -> Vec<Self> {
        let predicted = self.state.predicted(dt, restlessness(options));
        let (prior, found) = match agreeing(&predicted, sights, options) {
            Some(found) => (predicted, found),
            None => {
                let jolted = jolted(&predicted, dt, options);
                match agreeing(&jolted, sights, options) {
                    Some(found) => (jolted, found),
                    None => (predicted.clone(), refused(predicted, sights, options)),
                }
            }
        };
        let mut next = with_mirrored(found, &prior, sights, options);
        next.iter_mut()
            .for_each(|one| one.evidence += self.evidence);
        next
    }
}

/// The hypothesis, and the mirrored one where it is a possibility of its own.
pub(crate) fn with_mirrored(
    mut found: Hypothesis,
    prior: &Kinematics,
    sights: &[Sight<'_>],
    options: &FusionOptions,
) -> Vec<Hypothesis> {
    let Some(mirrored) = mirror::worth_trying(prior, &found.state.pose, sights, options) else {
        return vec![found];
    };
    found.mirrored = mirrored.odds;
    let other = updated(prior, &mirrored.pose, sights, options);
    std::iter::once(found).chain(other).collect()
}

/// The update from the prediction, if a view takes part in it.
fn agreeing(
    prior: &Kinematics,
    sights: &[Sight<'_>],
    options: &FusionOptions,
) -> Option<Hypothesis> {
    updated(prior, &prior.pose, sights, options)
        .filter(|one| one.taken.iter().any(|taken| taken.part))
}

/// The prediction if the body was hit in the meantime.
fn jolted(predicted: &Kinematics, dt: f64, options: &FusionOptions) -> Kinematics {
    let mut jolted = predicted.clone();
    for axis in 0..6 {
        let acceleration = if axis < 3 {
            options.linear_jolt
        } else {
            options.angular_jolt
        };
        let (way, speed) = (0.5 * acceleration * dt * dt, acceleration * dt);
        jolted.covariance[(axis, axis)] += way * way;
        jolted.covariance[(axis, axis + 6)] += way * speed;
        jolted.covariance[(axis + 6, axis)] += way * speed;
        // A little more than the perfectly correlated part, so that the covariance stays definite.
        jolted.covariance[(axis + 6, axis + 6)] += speed * speed * 1.1;
    }
    jolted
}

/// The state with all views refused.
fn refused(state: Kinematics, sights: &[Sight<'_>], options: &FusionOptions) -> Hypothesis {
    let taken = Taken {
        part: false,
        chi2: options.tag_gate,
        redundancy: 8.0,
        square_px: 0.0,
    };
    let evidence = -0.5 * options.tag_gate * sights.len() as f64;
    Hypothesis {
        state,
        evidence,
        mirrored: f64::NEG_INFINITY,
        taken: vec![taken; sights.len()],
    }
}

/// A hypothesis from the prior state and the views that agree with it and with each other: the worst view is left out
/// until all that are left pass their gates. `None` where none does.
pub(crate) fn updated(
    prior: &Kinematics,
    start: &Pose,
    sights: &[Sight<'_>],
    options: &FusionOptions,
) -> Option<Hypothesis> {
    let (pose_prior, _) = pose_prior(prior)?;
    let mut part = vec![true; sights.len()];
    loop {
        let active: Vec<Sight<'_>> = sights
            .iter()
            .zip(&part)
            .filter(|(_, part)| **part)
            .map(|(sight, _)| *sight)
            .collect();
        if active.is_empty() {
            return None;
        }
        let fit = solve(&pose_prior, &active, start)?;
        let normals: Vec<_> = sights.iter().map(|sight| seen(sight, &fit.pose)).collect();
        let worst = worst_view(&normals, &part)?;
        let worst_chi2 = normals[worst].as_ref().map_or(UNSEEN, |normal| normal.chi2);
        if worst_chi2 > options.tag_gate {
            part[worst] = false;
        } else if fit.surprise > options.prediction_gate {
            return None;
        } else {
            return complete(prior, &fit, &normals, &part, options);
        }
    }
}

/// Cost and normal equations of a view that shows the tag's face.
fn seen(sight: &Sight<'_>, pose: &Pose) -> Option<Normal> {
    sight.faces(pose).then(|| sight.normal(pose)).flatten()
}

fn worst_view(normals: &[Option<Normal>], part: &[bool]) -> Option<usize> {
    let cost = |index: &usize| {
        normals[*index]
            .as_ref()
            .map_or(UNSEEN, |normal| normal.chi2)
    };
    (0..normals.len())
        .filter(|index| part[*index])
        .max_by(|a, b| cost(a).total_cmp(&cost(b)))
}

fn complete(
    prior: &Kinematics,
    fit: &Fit,
    normals: &[Option<Normal>],
    part: &[bool],
    options: &FusionOptions,
) -> Option<Hypothesis> {
    let absorbed = absorb(prior, fit)?;
    let covariance = absorbed
        .state
        .covariance
        .fixed_view::<6, 6>(0, 0)
        .into_owned();
    let taken: Vec<Taken> = normals
        .iter()
        .zip(part)
        .map(|(normal, part)| taken(normal.as_ref(), *part, &covariance, options))
        .collect();
    let refused = part.iter().filter(|part| !**part).count();
    let evidence = -0.5 * (fit.cost + absorbed.narrowing + options.tag_gate * refused as f64);
    Some(Hypothesis {
        state: absorbed.state,
        evidence,
        mirrored: f64::NEG_INFINITY,
        taken,
    })
}

fn taken(
    normal: Option<&Normal>,
    part: bool,
    covariance: &Matrix6<f64>,
    options: &FusionOptions,
) -> Taken {
    let Some(normal) = normal else {
        return Taken {
            part: false,
            chi2: options.tag_gate,
            redundancy: 8.0,
            square_px: 0.0,
        };
    };
    let absorbed = if part {
        (normal.information * covariance).trace()
    } else {
        0.0
    };
    Taken {
        part,
        chi2: normal.chi2,
        redundancy: (8.0 - absorbed).clamp(0.5, 8.0),
        square_px: normal.square_px,
    }
}

/// Sorts by evidence, merges what has run together, gives up what is hopeless; the likeliest has evidence zero.
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

/// Whether two hypotheses are nearer than their uncertainty lets them be told apart.
fn is_same(a: &Hypothesis, b: &Hypothesis) -> bool {
    let off = se3::difference(&a.state.pose, &b.state.pose);
    let covariance: Covariance = a.state.covariance;
    let inverse = covariance.fixed_view::<6, 6>(0, 0).into_owned().cholesky();
    inverse.is_some_and(|factor| off.dot(&factor.solve(&off)) < 1.0)
}
