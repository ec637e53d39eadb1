//! Self-calibration beside the trackers: instants go to it, its corrections go into the site and into what is known of the objects.

use std::collections::BTreeMap;

use crate::fusion::Fusion;
use crate::self_calibration::keyframes::{Keyframe, KeyframeView, RelativeMotion};
use crate::site::{ObjectImage, Site};
use crate::tracker::timeline::Timeline;
use crate::tracker::track::Track;
use crate::{FusionOptions, ObjectEstimate};

/// Images no further apart than this, ns, make one keyframe: less than a period of most cameras.
const TOGETHER_NS: u64 = 25_000_000;

impl Fusion {
    /// Offers the newest instant of an object that has only just appeared, so that even its first poses are corrected.
    pub(crate) fn self_calibrate_from_start(&mut self, object: usize, capture_ns: u64) {
        if self.self_calibration.is_beginning(object) {
            self.self_calibrate(capture_ns.saturating_add(1));
            let timeline = &mut self.timelines[object];
            timeline.catch_up(capture_ns, &self.site, &self.options);
        }
    }

    /// Offers the instants before a time; takes the corrections over where there are any.
    pub(crate) fn self_calibrate(&mut self, before_ns: u64) {
        // What may be a fault is no imperfection: it is named before it is learned.
        let is_suspect = self.health.is_alert() && !self.self_calibration.is_young();
        if self.site.is_exact() || is_suspect {
            return;
        }
        self.offered_ns.resize(self.timelines.len(), None);
        for object in 0..self.timelines.len() {
            self.offer_instants(object, before_ns);
        }
        if let Some(corrections) = self.self_calibration.adjust(&self.site) {
            self.site.correct(&corrections);
            self.health.reset();
            for (object, timeline) in self.timelines.iter_mut().enumerate() {
                let newest = self.self_calibration.newest(object);
                let moved = newest.map(|newest| (newest.before, newest.pose));
                timeline.remodel(moved, &self.site, &self.options);
            }
            self.self_calibration.settle();
        }
    }

    fn offer_instants(&mut self, object: usize, before_ns: u64) {
        let timeline = &self.timelines[object];
        let mut offered_ns = self.offered_ns[object];
        for (track, images) in timeline.between(offered_ns, before_ns) {
            // The newest instant may have further images yet.
            if track.time_ns.saturating_add(1) < before_ns {
                offered_ns = Some(track.time_ns);
            }
            let images = with_newest_of_others(timeline, track.time_ns, images);
            for keyframe in keyframes(object, (track, &images), &self.site, &self.options) {
                self.self_calibration.offer(keyframe, &self.site);
            }
        }
        self.offered_ns[object] = offered_ns;
    }

    /// The files have changed.
    pub(crate) fn forget_calibration(&mut self) {
        self.self_calibration.reset();
        self.offered_ns.clear();
    }

    /// With the uncertainty of the object's own frame and of the common scale.
    pub(crate) fn with_frame(&self, object: usize, mut estimate: ObjectEstimate) -> ObjectEstimate {
        if let Some(frame) = self.site.frame(object) {
            estimate.covariance += frame.covariance_of(&estimate.world_from_object);
        }
        estimate
    }
}

/// The images of an instant, and of other cameras those taken last before it.
fn with_newest_of_others<'a>(
    timeline: &'a Timeline,
    time_ns: u64,
    mut images: Vec<&'a ObjectImage>,
) -> Vec<&'a ObjectImage> {
    let earliest_ns = time_ns.checked_sub(TOGETHER_NS);
    let earlier = timeline.between(earliest_ns, time_ns);
    let mut newest: BTreeMap<usize, &ObjectImage> = BTreeMap::new();
    for image in earlier.flat_map(|(_, images)| images) {
        newest.insert(image.camera_index, image);
    }
    newest.retain(|camera, _| !images.iter().any(|image| image.camera_index == *camera));
    images.extend(newest.into_values());
    images
}

/// An instant as self-calibration takes it, a keyframe for each rigid body: the object, or each of its links. None of what cannot tell
/// anything.
fn keyframes(
    object: usize,
    (track, images): (&Track, &[&ObjectImage]),
    site: &Site,
    options: &FusionOptions,
) -> Vec<Keyframe> {
    let Some(motion) = track.for_calibration() else {
        return Vec::new();
    };
    let mut bodies: BTreeMap<usize, Keyframe> = BTreeMap::new();
    for image in images {
        for view in &image.views {
            let way = motion.between([images[0], image], view, options);
            let way = way.map(|(step, covariance)| RelativeMotion { step, covariance });
            if way.as_ref().is_some_and(RelativeMotion::is_vague) {
                continue;
            }
            let Some(whitened) = site.for_calibration(view, options) else {
                continue;
            };
            let link = view
                .chain_link
                .as_ref()
                .map_or(0, |chain_link| chain_link.link);
            let keyframe = bodies.entry(link).or_insert_with(|| {
                let pose = motion.pose(view);
                Keyframe {
                    object,
                    link,
                    time_ns: track.time_ns,
                    pose,
                    before: pose,
                    views: Vec::new(),
                }
            });
            keyframe.views.push(KeyframeView {
                camera_index: image.camera_index,
                view: whitened,
                distortion_share: motion.distortion_share(image.camera_index),
                twist: view.after_s.map(|_| motion.twist(view)),
                way,
            });
        }
    }
    let bodies = bodies.into_values();
    bodies.filter(|body| body.views.len() > 1).collect()
}
