//! One attitude that explains the images: a filter state, its evidence, and the outcome of each view.

use nalgebra::Vector6;
use sextant_geometry::Pose;

use crate::FusionOptions;
use crate::filter::state::ObjectState;
use crate::measurement::corners::WeightedView;
use crate::tracker::camera_consistency::CameraConsistency;

/// One attitude.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Hypothesis {
    pub state: ObjectState,
    /// Logarithm of its odds against the likeliest.
    pub evidence: f64,
    /// Logarithm of the odds of the mirrored attitude against this one; minus infinity where it is out of question.
    pub mirrored: f64,
    /// Logarithm of the odds against the mirrored attitude by the corners of all images so far; counted until it is
    /// trusted.
    pub confirmed_odds: f64,
    /// The step to the mirrored attitude, while that is not settled.
    pub to_mirrored: Option<Vector6<f64>>,
    /// Which cameras go on to contradict it.
    pub consistency: CameraConsistency,
    /// Outcome of each view of the last instant.
    pub outcomes: Vec<ViewOutcome>,
}

impl Hypothesis {
    /// A state by which all views are refused.
    pub fn refused(state: ObjectState, evidence: f64, n_views: usize) -> Self {
        Self {
            state,
            evidence,
            mirrored: f64::NEG_INFINITY,
            confirmed_odds: 0.0,
            to_mirrored: None,
            consistency: CameraConsistency::default(),
            outcomes: vec![ViewOutcome::refused(); n_views],
        }
    }

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

    /// The views that are used among those of the last instant.
    pub fn used<'s, 'a>(
        &'s self,
        views: &'s [WeightedView<'a>],
    ) -> impl Iterator<Item = &'s WeightedView<'a>> {
        let pairs = views.iter().zip(&self.outcomes);
        let used = pairs.filter(|(_, outcome)| outcome.used);
        used.map(|(weighted, _)| weighted)
    }
}

/// Coordinates of the corners of a view.
const COORDINATES: f64 = 8.0;
/// Squared whitened residuals as which a rejected view counts for the noise: more than usual, so that a noise
/// underestimated at the start does not stay so.
const REJECTED_SQUARE: f64 = 12.6;

/// Outcome of a view in an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ViewOutcome {
    /// Whether the view is used.
    pub used: bool,
    /// Whether it is without a jolt.
    pub expected: bool,
    /// Sum of its squared whitened residuals after the update, by the view's weight.
    pub weighted_square: f64,
    /// Degrees of freedom that the residuals keep after the update.
    pub redundancy: f64,
    /// Sum of its squared residuals in px².
    pub square_px: f64,
    /// As [`WeightedView::distortion_score`] has it.
    pub distortion_score: [f64; 2],
}

impl ViewOutcome {
    pub fn refused() -> Self {
        Self {
            used: false,
            expected: false,
            weighted_square: REJECTED_SQUARE,
            redundancy: COORDINATES,
            square_px: 0.0,
            distortion_score: [0.0; 2],
        }
    }
}
