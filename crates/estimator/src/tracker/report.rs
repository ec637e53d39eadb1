//! Stage 6: what leaves the tracker: estimates of an object as they are published, and the views of instants that no
//! late image can change any more, for fault diagnosis.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use crate::FusionOptions;
use crate::measurement::corners::WeightedView;
use crate::measurement::ray::Ray;
use crate::site::{ModelledSite, ObjectImage};
use crate::time::seconds;
use crate::tracker::associate::weighted_views;
use crate::tracker::hypothesis::{Hypothesis, ViewOutcome};
use crate::tracker::mixture::is_wider;
use crate::tracker::track::{InstantSummary, Track};
use sextant_site_model::{ObjectId, TagId};
use sextant_site_report::{ObjectEstimate, State};

/// The estimate for the time of a stamp, at or after the track's instant, less the seconds by which the clock is ahead;
/// `None` where nothing worth publishing is known.
pub(crate) fn report(
    track: &Track,
    object: &ObjectId,
    stamp_ns: u64,
    ahead_s: f64,
    options: &FusionOptions,
) -> Option<ObjectEstimate> {
    let mut then = track.extrapolated(stamp_ns);
    if ahead_s != 0.0 {
        let summary = then.summary.clone();
        let ahead_ns = (ahead_s * 1e9).round() as i64;
        let capture_ns = stamp_ns.saturating_add_signed(ahead_ns.saturating_neg());
        let mut captured = then.extrapolated(capture_ns).into_owned();
        captured.summary = summary;
        then = Cow::Owned(captured);
    }
    let estimate = then.estimate(object, options)?;
    then.is_publishable(&estimate, options).then_some(estimate)
}

/// The last estimate of an object that is lost at `time_ns`; `None` where it was never known.
pub(crate) fn report_loss(
    track: &Track,
    object: &ObjectId,
    time_ns: u64,
    options: &FusionOptions,
) -> Option<ObjectEstimate> {
    let estimate = track.extrapolated(time_ns).estimate(object, options)?;
    Some(ObjectEstimate {
        state: State::Lost,
        ..estimate
    })
}

impl Track {
    /// The track at an instant of which there may be no image, its joints within their limits.
    fn extrapolated(&self, time_ns: u64) -> Cow<'_, Self> {
        let has_joints = |one: &Hypothesis| one.state.joints.is_some();
        if time_ns == self.time_ns && !self.hypotheses.iter().any(has_joints) {
            return Cow::Borrowed(self);
        }
        let mut then = self.clone();
        if time_ns != self.time_ns {
            let dt = seconds(self.time_ns, time_ns);
            then.time_ns = time_ns;
            then.summary = InstantSummary::default();
            for one in &mut then.hypotheses {
                one.state = one.state.predicted(dt);
            }
        }
        let states = then.hypotheses.iter_mut().map(|one| &mut one.state);
        for joints in states.filter_map(|state| state.joints.as_mut()) {
            joints.keep_within_limits();
        }
        Cow::Owned(then)
    }

    fn estimate(&self, object: &ObjectId, options: &FusionOptions) -> Option<ObjectEstimate> {
        let best = self.hypotheses.first()?;
        let covariance = self.covariance();
        let (world_from_object, twist) = best.state.base();
        Some(ObjectEstimate {
            object: object.clone(),
            capture_ns: self.time_ns,
            world_from_object,
            covariance,
            twist,
            state: self.state(&covariance, options),
            cameras: self.summary.cameras,
            tags: self.summary.tags,
            rms_px: self.summary.rms_px(),
            articulated: self.articulated(),
        })
    }

    /// A prediction is worth publishing while it is sharp, a doubtful attitude when it has been in doubt for long.
    fn is_publishable(&self, estimate: &ObjectEstimate, options: &FusionOptions) -> bool {
        let doubted_for = |since_ns: u64| seconds(since_ns, self.time_ns);
        let long_doubted = |since_ns: u64| doubted_for(since_ns) >= options.patience_s;
        let (position, attitude) = (options.coasting_position, options.coasting_attitude);
        match estimate.state {
            State::Initialising => {
                self.summary.tags > 0 && self.doubtful_since_ns.is_some_and(long_doubted)
            }
            // What the images of this very time contradict is no sharp prediction, whatever its covariance.
            State::Coasting => {
                self.contradicted_since_ns.is_none()
                    && !is_wider(&estimate.covariance, position, attitude)
            }
            State::Tracking | State::Lost => true,
        }
    }
}

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
    /// Outcome of its views; none while the attitude is in doubt.
    pub fn views(&self, site: &ModelledSite, options: &FusionOptions) -> Vec<FinalisedView> {
        let track = &self.track;
        let Some(best) = track.hypotheses.first().filter(|_| track.trusted) else {
            return Vec::new();
        };
        let images: Vec<&ObjectImage> = self.images.values().map(Arc::as_ref).collect();
        let weighted_views = weighted_views(track, &images, site, options);
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
        if outcome.used {
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
