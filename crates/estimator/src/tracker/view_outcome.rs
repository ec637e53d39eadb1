//! What became of the views of an instant.

use crate::measurement::corners::WeightedView;
/// Squared residuals as which a refused view counts for the noise, of four degrees of freedom: more than usual, so that a
/// noise underestimated at the start does not stay so.
const REFUSED_SCALE: f64 = 6.3;

/// What became of a view in an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ViewOutcome {
    /// Whether it took part.
    pub part: bool,
    /// Whether it did so without a jolt.
    pub expected: bool,
    /// Of its edges' places and directions after the update, as [`ViewEquations::scale`] has it.
    pub scale: [f64; 2],
    /// Degrees of freedom of either that the residuals keep after the update.
    pub redundancy: [f64; 2],
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
            scale: [REFUSED_SCALE; 2],
            redundancy: [4.0; 2],
            square_px: 0.0,
            distortion_score: [0.0; 2],
        }
    }
}

/// What the images of an instant contributed.
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
    pub fn of(outcomes: &[ViewOutcome], weighted_views: &[WeightedView<'_>]) -> Self {
        let pairs = || weighted_views.iter().zip(outcomes);
        let mut cameras: Vec<usize> = pairs()
            .filter(|(_, taken)| taken.part)
            .map(|(weighted, _)| weighted.camera_index)
            .collect();
        cameras.dedup();
        let tags = outcomes.iter().filter(|taken| taken.part).count() as u32;
        let taking_part = outcomes.iter().filter(|taken| taken.part);
        let square_px = taking_part.map(|taken| taken.square_px).sum();
        let refused = pairs()
            .filter(|(_, taken)| !taken.part)
            .map(|(weighted, _)| weighted.camera_index)
            .collect();
        Self {
            cameras: cameras.len() as u32,
            tags,
            square_px,
            refused,
        }
    }

    /// With what other images of the same instant contributed.
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
