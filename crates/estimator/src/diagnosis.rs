//! Fault detection and isolation: which camera was moved, which tag is misplaced, of another size or printed twice,
//! which clock is off.
//!
//! Works on instants that no late image can change any more. Keyframes of the last second are linearised about the
//! models in force ([`window`]), exactly as self-calibration does it; a fault is an error of one camera or tag that is
//! larger than what is known of it ([`fault_model`]), found by its likelihood ratio ([`likelihood_ratio`],
//! [`isolation`]). Tags that are nowhere near their place are counted instead ([`misplaced_tags`]). Nothing here edits
//! a track: [`Diagnosis::take`] returns the actions for [`crate::Fusion`] to apply.

pub(crate) mod blind_cameras;
pub(crate) mod fault_model;
pub(crate) mod frozen_cameras;
pub(crate) mod isolation;
pub(crate) mod likelihood_ratio;
pub(crate) mod misplaced_tags;
pub(crate) mod pacing;
pub(crate) mod window;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::diagnosis::fault_model::FaultHypothesis;
use crate::diagnosis::isolation::Isolation;
use crate::diagnosis::misplaced_tags::{MisplacedTags, SeenOn};
use crate::diagnosis::pacing::Pacing;
use crate::diagnosis::window::Window;
use crate::fading_counter::FadingCounter;
use crate::self_calibration::SelfCalibration;
use crate::self_calibration::keyframe_builder::{KeyframeBuilder, TOGETHER_NS};
use crate::site::{ModelledSite, ObjectImage};
use crate::time::nanoseconds;
use crate::tracker::report::{FinalisedInstant, FinalisedView};
use crate::{DiagnosisOptions, FusionOptions};
use sextant_site_model::TagId;

/// Views of a camera, fading, from which on the share of the rejected ones means something.
const FEWEST_VIEWS: f64 = 3.0;
/// Share of rejected views from which on a camera contradicts the tracks.
const CONTRADICTING_SHARE: f64 = 0.5;
/// How long a tag that was seen twice in an image is reported, ns.
const DUPLICATE_NS: u64 = 2_000_000_000;
/// Most tags seen twice at one time; further ones are passed over.
const MOST_DUPLICATES: usize = 1024;
/// After this long no question about clocks keeps a moved camera from being named, ns.
const CERTAIN_NS: u64 = 1_000_000_000;
/// Least time between two restarts of the same clock estimate, ns.
const CLOCK_PAUSE_NS: u64 = 1_000_000_000;

/// A camera that is not where the rig says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MovedCamera {
    pub camera: usize,
    /// The only other camera that it contradicts: it may be that one as well.
    pub or: Option<usize>,
    /// Whether its clock is out of question.
    pub is_timely: bool,
}

/// What the caller is to do about a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Action {
    /// Estimate the offset of a camera's clock anew.
    RestartClock(usize),
}

/// What diagnosis works with besides the views.
#[derive(Clone, Copy)]
pub(crate) struct Models<'a> {
    pub self_calibration: &'a SelfCalibration,
    pub site: &'a ModelledSite,
    pub options: &'a FusionOptions,
}

/// The state of diagnosis for a site.
#[derive(Debug, Default)]
pub(crate) struct Diagnosis {
    /// Views of each camera and those that its track rejected.
    cameras: BTreeMap<usize, FadingCounter>,
    misplaced_tags: MisplacedTags,
    /// When a tag was last in an image twice, by camera index.
    duplicates_ns: BTreeMap<(usize, TagId), u64>,
    /// The newest finalised image of each object by each camera.
    images: BTreeMap<(usize, usize), Arc<ObjectImage>>,
    window: Window,
    pacing: Pacing,
    isolation: Isolation,
    /// When faults were last isolated, ns.
    isolated_ns: u64,
    /// When a clock estimate was last restarted, ns.
    restarted_ns: BTreeMap<usize, u64>,
    newest_ns: u64,
}

impl Diagnosis {
    /// Takes a finalised instant of an object with its views; `host` tells on what other object a view far from its
    /// place is.
    pub fn take(
        &mut self,
        object: usize,
        instant: &FinalisedInstant,
        host: impl Fn(&FinalisedView) -> Option<SeenOn>,
        models: Models<'_>,
    ) -> Vec<Action> {
        let time_ns = instant.track.time_ns;
        let views = instant.views(models.site, models.options);
        for view in &views {
            let camera = self.cameras.entry(view.camera_index).or_default();
            camera.add(time_ns, !view.agreed);
            if !view.agreed {
                self.misplaced_tags
                    .reject(object, time_ns, view, host(view));
            }
        }
        let cameras = &self.cameras;
        self.misplaced_tags
            .judge(time_ns, |camera| Some(cameras.get(&camera)?.faded(time_ns)));
        for (camera, image) in &instant.images {
            self.images.insert((object, *camera), image.clone());
        }
        if views.is_empty() {
            return Vec::new();
        }
        let options = &models.options.diagnosis;
        let interval_ns = nanoseconds(self.interval_s(options));
        let spacing_ns = nanoseconds(options.window_s / window::MAX_KEYFRAMES as f64);
        if self.pacing.take(object, time_ns, interval_ns, spacing_ns) {
            self.sample(object, instant, &views, models);
        }
        if time_ns.abs_diff(self.isolated_ns) < interval_ns {
            return Vec::new();
        }
        self.isolated_ns = time_ns;
        self.isolate(time_ns, models)
    }

    /// Seconds between two isolations of faults, and between tested instants of an object.
    fn interval_s(&self, options: &DiagnosisOptions) -> f64 {
        let is_suspecting = self.is_suspecting(options.suspected_odds)
            || self.contradicting_cameras().next().is_some();
        match is_suspecting {
            true => options.alert_interval_s,
            false => options.quiet_interval_s,
        }
    }

    /// Puts an instant into the window, with the images of other cameras just before it.
    fn sample(
        &mut self,
        object: usize,
        instant: &FinalisedInstant,
        views: &[FinalisedView],
        models: Models<'_>,
    ) {
        let time_ns = instant.track.time_ns;
        let oldest_ns = time_ns.saturating_sub(TOGETHER_NS);
        let others = self.images.range((object, 0)..(object + 1, 0));
        let others = others.filter(|((_, camera), image)| {
            image.capture_ns >= oldest_ns && !instant.images.contains_key(camera)
        });
        let images = instant
            .images
            .values()
            .chain(others.map(|(_, image)| image));
        let images: Vec<&ObjectImage> = images.map(Arc::as_ref).collect();
        let is_far = |camera, tag| {
            let mut views = views.iter();
            views.any(|one| (one.camera_index, one.tag) == (camera, tag) && one.ray.is_some())
        };
        let builder = KeyframeBuilder {
            object,
            track: &instant.track,
            images: &images,
            site: models.site,
            options: models.options,
        };
        let window_ns = nanoseconds(models.options.diagnosis.window_s);
        for keyframe in builder.for_diagnosis(|camera, tag| !is_far(camera, tag)) {
            let linearised = models.self_calibration.linearised(keyframe, models.site);
            self.window.push(linearised, window_ns);
        }
    }

    fn isolate(&mut self, time_ns: u64, models: Models<'_>) -> Vec<Action> {
        let options = &models.options.diagnosis;
        let is_quiet = self.window.strongest_pull() < options.suspected_odds;
        if is_quiet && self.isolation.named.is_empty() {
            self.isolation.suspicion = 0.0;
            return Vec::new();
        }
        let equations = self.window.equations();
        let clocks = self
            .isolation
            .judge(time_ns, &equations, models.site, options);
        let mut actions = Vec::new();
        for camera in clocks {
            let restarted_ns = self.restarted_ns.get(&camera).copied().unwrap_or(0);
            if time_ns >= restarted_ns.saturating_add(CLOCK_PAUSE_NS) {
                self.restarted_ns.insert(camera, time_ns);
                self.window.forget_camera(camera);
                actions.push(Action::RestartClock(camera));
            }
        }
        actions
    }

    /// Whether a fault is named, or is more likely than the logarithm of these odds.
    fn is_suspecting(&self, odds: f64) -> bool {
        self.isolation.suspicion > odds || !self.isolation.named.is_empty()
    }

    /// Whether errors of the site may be faults, which self-calibration is not to learn.
    pub fn is_alert(&self, options: &FusionOptions) -> bool {
        self.is_suspecting(options.diagnosis.margin_odds)
    }

    /// Notes the tags that an image has more than once.
    pub fn record_duplicates(
        &mut self,
        camera_index: usize,
        time_ns: u64,
        tags: impl Iterator<Item = TagId>,
    ) {
        let mut seen = BTreeSet::new();
        self.newest_ns = self.newest_ns.max(time_ns);
        for tag in tags {
            let key = (camera_index, tag);
            let has_room =
                self.duplicates_ns.len() < MOST_DUPLICATES || self.duplicates_ns.contains_key(&key);
            if !seen.insert(tag) && has_room {
                self.duplicates_ns.insert(key, time_ns);
            }
        }
        let oldest_ns = self.newest_ns.saturating_sub(DUPLICATE_NS);
        self.duplicates_ns.retain(|_, at_ns| *at_ns >= oldest_ns);
    }

    /// The tags that a camera has lately seen twice.
    pub fn duplicate_tags(&self) -> impl Iterator<Item = (usize, TagId)> {
        self.duplicates_ns.keys().copied()
    }

    /// Forgets everything: the models have changed.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Forgets the images so far: timestamps mean something else now.
    pub fn forget_images(&mut self) {
        self.images.clear();
        self.window.clear();
    }

    /// The tags that are seen where their objects can't have them, by object index, and the object that they are seen
    /// on.
    pub fn misplaced_tags(&self) -> impl Iterator<Item = (usize, TagId, Option<usize>)> {
        self.misplaced_tags
            .found()
            .map(|((object, tag), on)| (object, tag, on))
    }

    /// The cameras most of whose views are rejected, by index: for whatever cause.
    pub fn contradicting_cameras(&self) -> impl Iterator<Item = usize> {
        let is_contradicting = |count: &FadingCounter| {
            count.total >= FEWEST_VIEWS && count.share() > CONTRADICTING_SHARE
        };
        let cameras = self.cameras.iter();
        cameras
            .filter(move |(_, count)| is_contradicting(count))
            .map(|(camera, _)| *camera)
    }

    /// The cameras that are not where the rig says.
    pub fn moved_cameras(&self) -> impl Iterator<Item = MovedCamera> {
        self.isolation.named.iter().filter_map(|(fault, named)| {
            let is_old = self.newest_ns.saturating_sub(named.since_ns) > CERTAIN_NS;
            Some(MovedCamera {
                camera: fault.moved_camera()?,
                or: named.or,
                is_timely: named.is_timely || is_old,
            })
        })
    }

    /// The cameras that bend what they see otherwise than the rig says, by index.
    pub fn wrong_lenses(&self) -> impl Iterator<Item = usize> {
        let named = self.isolation.named.keys();
        named.filter_map(|fault| match fault {
            FaultHypothesis::Lens(model) => Some(model.camera),
            _ => None,
        })
    }

    /// The tags that are not as the models say; with the ratio of sizes where that explains it.
    pub fn wrong_tags(&self) -> impl Iterator<Item = (TagId, Option<f64>)> {
        let named = self.isolation.named.iter();
        let wrong = named.filter_map(|(fault, named)| match fault {
            FaultHypothesis::TagSize(model) => Some((model.tag, Some(named.parameters[0].exp()))),
            FaultHypothesis::TagPose(model) => Some((model.tag, None)),
            _ => None,
        });
        wrong.filter(|(tag, _)| !self.misplaced_tags.contains(tag))
    }
}
