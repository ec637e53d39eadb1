//! What became of the views of an instant once no late image can change it any more.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::FusionOptions;
use crate::measurement::corners::WeightedView;
use crate::measurement::ray::Ray;
use crate::site::{ModelledSite, ObjectImage};
use crate::tracker::track::Track;
use crate::tracker::view_outcome::ViewOutcome;
use sextant_site_model::TagId;

/// Ratio of the corners' residuals to their distances from the tag's centre from which on a tag is not loose but
/// somewhere else.
const FAR: f64 = 2.5;

/// An instant that has left the fixed lag.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FinalisedInstant {
    /// The track after its images.
    pub track: Box<Track>,
    /// By camera index.
    pub images: BTreeMap<usize, Arc<ObjectImage>>,
}

/// A view of a finalised instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FinalisedView {
    pub camera_index: usize,
    pub tag: TagId,
    /// Whether it agreed with the track.
    pub agreed: bool,
    /// The ray on which it is seen, if that is far from where its object has it.
    pub ray: Option<Ray>,
}

impl FinalisedInstant {
    /// What became of its views; none while the attitude is in doubt.
    pub fn views(&self, site: &ModelledSite, options: &FusionOptions) -> Vec<FinalisedView> {
        let track = &self.track;
        let Some(best) = track.hypotheses.first().filter(|_| track.trusted) else {
            return Vec::new();
        };
        let images: Vec<&ObjectImage> = self.images.values().map(Arc::as_ref).collect();
        let weighted_views = track.weighted_views(&images, site, options);
        let pairs = weighted_views.iter().zip(&best.outcomes);
        let view = pairs.map(|(weighted, outcome)| FinalisedView {
            camera_index: weighted.camera_index,
            tag: weighted.view.tag,
            agreed: outcome.expected,
            ray: track.ray_if_far(weighted, outcome),
        });
        view.collect()
    }
}

impl Track {
    /// The ray to a rejected view that shows its tag far from its place.
    fn ray_if_far(&self, weighted: &WeightedView<'_>, outcome: &ViewOutcome) -> Option<Ray> {
        if outcome.part {
            return None;
        }
        let (index, camera, view) = (weighted.camera_index, weighted.camera, weighted.view);
        let at = self.hypotheses.first()?.state.configuration_seen_by(index);
        let share = self.noise.distortion_share(index);
        let residual = camera.relative_residual(view, share, &at);
        let is_far = residual.is_none_or(|residual| residual >= FAR);
        is_far.then(|| camera.ray_to(view)).flatten()
    }
}
