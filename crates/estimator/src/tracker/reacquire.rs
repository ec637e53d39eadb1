//! What is tried when the views of an instant contradict a track: the object initialised anew, or noisier corners.

use crate::FusionOptions;
use crate::measurement::corners::WeightedView;
use crate::time::seconds;
use crate::tracker::branch::branch;
use crate::tracker::predict::Prediction;
use crate::tracker::prune::prune;
use crate::tracker::track::{LATELY_NS, Track};
use crate::tracker::update::update;

/// Factors on the variance of corners by which tags are tried to agree: blur and vibration come with a hit.
const MORE_NOISE: [f64; 2] = [10.0, 100.0];

/// The track that explains the views of an instant, where `next`, which follows from the prediction, does not: the
/// object by two or more tags of an image that agree with one another, with as much more noise as they need for that,
/// as it moved before, or else anew.
pub(crate) fn reacquire(
    prediction: &Prediction<'_>,
    next: Track,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Track {
    if prediction.is_initialisation() || next.agrees_with_most(views) {
        return next;
    }
    let anew = prediction.initialisation();
    if !next.uses_views && next.is_contradicted(options) {
        return posterior(&anew, views, options);
    }
    let same_camera = |pair: &[WeightedView<'_>]| pair[0].camera_index == pair[1].camera_index;
    if next.others_agree_lately(views)
        || !views.windows(2).any(same_camera)
        || next.has_agreeing_tags(views)
    {
        return next;
    }
    let noisier = MORE_NOISE
        .iter()
        .flat_map(|noise| [(prediction, *noise), (&anew, *noise)]);
    let mut others = std::iter::once((&anew, 1.0)).chain(noisier);
    let agreed = others.find_map(|(prediction, noise)| {
        let views: Vec<_> = views
            .iter()
            .map(|weighted| weighted.noisier(noise))
            .collect();
        let other = posterior(prediction, &views, options);
        other.has_agreeing_tags(&views).then_some(other)
    });
    agreed
        .filter(|other| other.summary.tags > next.summary.tags)
        .unwrap_or(next)
}

fn posterior(
    prediction: &Prediction<'_>,
    views: &[WeightedView<'_>],
    options: &FusionOptions,
) -> Track {
    let updated = update(prediction, views, options);
    let branches = branch(prediction, updated, views, options);
    prune(prediction, branches, views, options)
}

impl Track {
    /// Whether the views that are used are more than the others.
    fn agrees_with_most(&self, views: &[WeightedView<'_>]) -> bool {
        let best = self.hypotheses.first();
        2 * best.map_or(0, |best| best.used(views).count()) > views.len()
    }

    /// Whether the images have contradicted for long enough to start anew; at once if nothing was certain yet.
    fn is_contradicted(&self, options: &FusionOptions) -> bool {
        let is_long = |since_ns| seconds(since_ns, self.time_ns) >= options.contradiction_s;
        !self.trusted || self.contradicted_since_ns.is_some_and(is_long)
    }

    /// Whether a camera without a view in this instant has lately agreed with the track and still does.
    fn others_agree_lately(&self, views: &[WeightedView<'_>]) -> bool {
        let Some(best) = self.hypotheses.first() else {
            return false;
        };
        self.participation.iter().any(|(camera, used_ns)| {
            used_ns.saturating_add(LATELY_NS) >= self.time_ns
                && !best.consistency.doubts(*camera)
                && !views
                    .iter()
                    .any(|weighted| weighted.camera_index == *camera)
        })
    }

    /// Whether two tags of one image agree with one another.
    fn has_agreeing_tags(&self, views: &[WeightedView<'_>]) -> bool {
        let best = self.hypotheses.iter().take(1);
        let used = best.flat_map(|best| best.used(views));
        let mut cameras: Vec<usize> = used.map(|weighted| weighted.camera_index).collect();
        cameras.sort_unstable();
        cameras.windows(2).any(|pair| pair[0] == pair[1])
    }
}
