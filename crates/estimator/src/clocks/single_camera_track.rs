//! Motion of a body as one camera sees it: a track fed by that camera only.
//!
//! A body is a rigid object, or a link of an articulated one: its views are the link's own.

use std::collections::VecDeque;

use nalgebra::Matrix6;
use sextant_geometry::Pose;

use crate::FusionOptions;
use crate::measurement::corners::TagView;
use crate::site::{ClockPrior, ModelledSite, ObjectImage};
use crate::tracker::report::report;
use crate::tracker::track::Track;
use sextant_site_model::ObjectId;
use sextant_site_report::State;

/// Poses that are kept: four seconds at 60 a second.
const REMEMBERED: usize = 240;
/// Nanoseconds between them at least.
const SPACING_NS: u64 = 12_000_000;

/// An object, and one of its links.
pub(crate) type Body = (usize, Option<usize>);

/// Pose of a body by the timestamps of one camera.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    pub stamp_ns: u64,
    pub world_from_body: Pose,
    pub covariance: Matrix6<f64>,
}

/// The track of a body by one camera.
#[derive(Debug, Default)]
pub(crate) struct SingleCameraTrack {
    track: Track,
    samples: VecDeque<Sample>,
}

impl SingleCameraTrack {
    /// In order of their stamps.
    pub fn samples(&self) -> &VecDeque<Sample> {
        &self.samples
    }

    /// Processes an image of the body; one that is out of order is ignored.
    pub fn take(
        &mut self,
        object: &ObjectId,
        image: &ObjectImage,
        site: &ModelledSite,
        options: &FusionOptions,
    ) {
        if image.capture_ns <= self.track.time_ns {
            return;
        }
        let stamp_ns = image.capture_ns;
        self.track = self.track.advance(stamp_ns, &[image], site, options);
        let spaced = self
            .samples
            .back()
            .is_none_or(|last| stamp_ns.saturating_sub(last.stamp_ns) >= SPACING_NS);
        let estimate = report(&self.track, object, stamp_ns, 0.0, options);
        if let Some(estimate) = estimate.filter(|one| spaced && one.state == State::Tracking) {
            if self.samples.len() == REMEMBERED {
                self.samples.pop_front();
            }
            self.samples.push_back(Sample {
                stamp_ns,
                world_from_body: estimate.world_from_object,
                covariance: estimate.covariance,
            });
        }
    }
}

/// The image of an object as images of its bodies; the camera's clock is right by definition.
pub(crate) fn bodies(object: usize, image: &ObjectImage) -> Vec<(Body, ObjectImage)> {
    let link = |view: &TagView| view.chain_link.as_ref().map(|chain_link| chain_link.link);
    let mut links: Vec<Option<usize>> = image.views.iter().map(link).collect();
    links.sort_unstable();
    links.dedup();
    let body = |of: Option<usize>| {
        let views = image.views.iter().filter(|view| link(view) == of);
        let alone = |view: &TagView| TagView {
            chain_link: None,
            ..view.clone()
        };
        let image = ObjectImage {
            clock: ClockPrior::Right,
            views: views.map(alone).collect(),
            ..image.clone()
        };
        ((object, of), image)
    };
    links.into_iter().map(body).collect()
}
