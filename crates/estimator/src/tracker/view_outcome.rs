//! Outcome of the views of an instant.

use crate::measurement::corners::WeightedView;

/// Coordinates of the corners of a view.
const COORDINATES: f64 = 8.0;
/// Squared whitened residuals as which a rejected view counts for the noise: more than usual, so that a noise
/// underestimated at the start does not stay so.
const REJECTED_SQUARE: f64 = 12.6;

/// Outcome of a view in an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ViewOutcome {
    /// Whether it took part.
    pub part: bool,
    /// Whether it did so without a jolt.
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
            part: false,
            expected: false,
            weighted_square: REJECTED_SQUARE,
            redundancy: COORDINATES,
            square_px: 0.0,
            distortion_score: [0.0; 2],
        }
    }
}

/// Contribution of the images of an instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct InstantSummary {
    /// Cameras that took part.
    pub cameras: u32,
    /// Views that took part.
    pub tags: u32,
    /// Sum of their squared residuals in px².
    pub(crate) square_px: f64,
    /// Camera index of each view that was refused.
    pub refused: Vec<usize>,
}

impl InstantSummary {
    pub fn new(outcomes: &[ViewOutcome], weighted_views: &[WeightedView<'_>]) -> Self {
        let pairs = || weighted_views.iter().zip(outcomes);
        let mut cameras: Vec<usize> = pairs()
            .filter(|(_, outcome)| outcome.part)
            .map(|(weighted, _)| weighted.camera_index)
            .collect();
        cameras.dedup();
        let tags = outcomes.iter().filter(|outcome| outcome.part).count() as u32;
        let taking_part = outcomes.iter().filter(|outcome| outcome.part);
        let square_px = taking_part.map(|outcome| outcome.square_px).sum();
        let refused = pairs()
            .filter(|(_, outcome)| !outcome.part)
            .map(|(weighted, _)| weighted.camera_index)
            .collect();
        Self {
            cameras: cameras.len() as u32,
            tags,
            square_px,
            refused,
        }
    }

    /// Joined with that of other images of the same instant.
    pub fn joined(&self, mut other: Self) -> Self {
        other.cameras += self.cameras;
        other.tags += self.tags;
        other.square_px += self.square_px;
        other.refused.extend(&self.refused);
        other
    }

    /// Root mean square of the residuals in pixels, over both axes.
    pub fn rms_px(&self) -> f64 {
        let residuals = 8.0 * f64::from(self.tags.max(1));
        (self.square_px / residuals).sqrt()
    }
}
