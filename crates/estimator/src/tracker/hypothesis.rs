//! One attitude that explains the images: a filter state and its evidence.

use nalgebra::Vector6;
use sextant_geometry::Pose;

use crate::FusionOptions;
use crate::filter::state::ObjectState;
use crate::measurement::corners::WeightedView;
use crate::tracker::camera_consistency::CameraConsistency;
use crate::tracker::planar_ambiguity;
use crate::tracker::view_outcome::ViewOutcome;

/// One attitude.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Hypothesis {
    pub state: ObjectState,
    /// Logarithm of its odds against the likeliest.
    pub evidence: f64,
    /// Whether the attitude is so vague that the cost of this instant's corners may be no parabola about the fit.
    pub vague: bool,
    /// Logarithm of the odds of the mirrored attitude against this one; minus infinity where it is out of question.
    pub mirrored: f64,
    /// Logarithm of the odds against the mirrored attitude by the corners of all images so far; counted until it is
    /// trusted.
    pub confirmed_odds: f64,
    /// The step to the mirrored attitude, while that is not settled.
    pub to_mirrored: Option<Vector6<f64>>,
    /// Which cameras go on to contradict it.
    pub consistency: CameraConsistency,
    /// What became of each view at the last instant.
    pub outcomes: Vec<ViewOutcome>,
}

impl Hypothesis {
    /// Pose of the same root link by another hypothesis.
    pub fn root_of(&self, other: &Self) -> Pose {
        match &other.state.joints {
            None => self.state.pose,
            Some(joints) => {
                let at = self.state.configuration();
                joints.chain.world_from_link(&at, joints.root)
            }
        }
    }

    /// Whether another hypothesis has another attitude.
    pub fn is_turned_from(&self, other: &Self, options: &FusionOptions) -> bool {
        let turn = self
            .state
            .pose
            .rotation
            .angle_to(&other.root_of(self).rotation);
        turn > options.vague_attitude
    }

    /// The mirrored attitude as a step and its weight against this one, while it is not settled.
    pub fn twin(&self) -> Option<(Vector6<f64>, f64)> {
        Some((self.to_mirrored?, (-self.confirmed_odds.max(0.0)).exp()))
    }

    /// Adds the odds of the views that took part against the mirrored attitude to those of earlier ones.
    pub fn confirm(
        &mut self,
        before: f64,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) {
        self.confirmed_odds = before;
        self.to_mirrored = None;
        if before < options.trusted_odds {
            let pairs = weighted_views.iter().zip(&self.outcomes);
            let part: Vec<_> = pairs
                .filter(|(_, outcome)| outcome.part)
                .map(|(weighted, _)| weighted)
                .collect();
            let at = self.state.configuration();
            self.confirmed_odds += planar_ambiguity::odds_against_mirrored(&at, &part);
            self.to_mirrored = planar_ambiguity::step_to_mirrored(&at, &part);
        }
    }
}
