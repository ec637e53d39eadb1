//! Self-calibration beside the trackers: offers it instants, and applies its corrections to the site.

use std::collections::BTreeMap;

use crate::fusion::RigFusion;
use crate::self_calibration::keyframe_builder::{KeyframeBuilder, TOGETHER_NS};
use crate::self_calibration::{Keyframe, Offered};
use crate::site::ObjectImage;
use crate::time::nanoseconds;
use crate::tracker::timeline::Timeline;
use crate::tracker::track::Track;
use sextant_site_report::ObjectEstimate;

impl RigFusion {
    /// Offers the newest instant of an object that has only just appeared, so that even its first poses are corrected.
    pub(crate) fn self_calibrate_from_start(&mut self, object: usize, capture_ns: u64) {
        if self.self_calibration.is_beginning(object) {
            self.self_calibrate(capture_ns.saturating_add(1));
            self.timelines[object].reprocess(&self.site, &self.options);
        }
    }

    /// Offers the instants before a time, and applies the corrections where there are any.
    ///
    /// The first images of an object are offered at once, since what they contradict is most likely an error of the
    /// files. Later ones wait in quarantine until diagnosis has seen them, and are discarded if a fault is suspected by
    /// then.
    pub(crate) fn self_calibrate(&mut self, before_ns: u64) {
        if self.site.is_exact() {
            return;
        }
        self.offered
            .resize(self.timelines.len(), Offered::default());
        let is_suspect = self.is_suspect();
        for object in 0..self.timelines.len() {
            if self.timelines[object].is_outdated() {
                continue;
            }
            let before_ns = self.offered_before(object, before_ns);
            if is_suspect {
                let offered_ns = &mut self.offered[object].instant_ns;
                *offered_ns = (*offered_ns).max(before_ns.checked_sub(1));
            } else {
                self.offer_instants(object, before_ns);
            }
        }
        if is_suspect {
            self.self_calibration.discard_quarantine();
            return;
        }
        let lag_ns = nanoseconds(self.options.window_s + self.options.diagnosis.window_s);
        let judged_ns = before_ns.saturating_sub(lag_ns);
        self.self_calibration.release_quarantine(judged_ns);
        self.self_calibration.prepare(self.now_ns, &self.site);
        if !self.adjusts_apart || self.self_calibration.is_due_at_once() {
            self.take_adjusted();
        }
    }

    /// Whether what images contradict may be a fault.
    fn is_suspect(&self) -> bool {
        let is_alert = self.diagnosis.is_alert(&self.options) && !self.self_calibration.is_young();
        is_alert || self.contradictions.forbids_learning()
    }

    /// Applies the adjustment that is due. While a fault is suspected it may have been learned, and what is known of
    /// the fault must stay.
    pub(crate) fn take_adjusted(&mut self) {
        if self.is_suspect() {
            self.self_calibration.discard_adjustment();
            return;
        }
        if self.self_calibration.take_adjusted(&mut self.site) {
            self.diagnosis.reset();
            self.contradictions.models_corrected();
            for (object, timeline) in self.timelines.iter_mut().enumerate() {
                let moved = self.self_calibration.moved(object);
                timeline.remodel(moved);
            }
            self.self_calibration.mark_applied();
        }
    }

    /// Processes windows of objects again whose models have been corrected: some of them with each image, so that none
    /// waits for all.
    pub(crate) fn reprocess_outdated(&mut self) {
        let mut n_instants = 0;
        for timeline in &mut self.timelines {
            if n_instants < MOST_REPROCESSED {
                n_instants += timeline.reprocess(&self.site, &self.options);
            }
        }
    }

    /// Up to when instants of an object are offered: all of them while it is new, later those that are about to leave
    /// the fixed lag.
    fn offered_before(&self, object: usize, before_ns: u64) -> u64 {
        if self.is_new(object, before_ns) {
            return before_ns;
        }
        // The images of a whole stretch of time before an instant must be there yet.
        let lag_ns = nanoseconds(self.options.window_s).saturating_sub(STRETCH_NS);
        before_ns.saturating_sub(lag_ns)
    }

    fn is_new(&self, object: usize, time_ns: u64) -> bool {
        let learning_ns = nanoseconds(self.options.learning_s);
        let first_ns = self.self_calibration.first_ns(object);
        first_ns.is_none_or(|first_ns| time_ns < first_ns.saturating_add(learning_ns))
    }

    fn offer_instants(&mut self, object: usize, before_ns: u64) {
        let is_new = self.is_new(object, before_ns);
        if !is_new {
            let last_ns = before_ns.saturating_sub(1);
            self.timelines[object].catch_up(last_ns, &self.site, &self.options);
        }
        let timeline = &self.timelines[object];
        let mut offered = self.offered[object];
        for (track, images) in timeline.between(offered.instant_ns, before_ns) {
            // The newest instant may have further images yet.
            if track.time_ns.saturating_add(1) < before_ns {
                offered.instant_ns = Some(track.time_ns);
            }
            let keyframes = self.keyframes_of(object, track, images, &mut offered);
            for keyframe in keyframes {
                if is_new {
                    self.self_calibration.offer(keyframe);
                } else {
                    self.self_calibration.quarantine(keyframe);
                }
            }
        }
        self.offered[object] = offered;
    }

    /// What is offered of an instant.
    fn keyframes_of(
        &self,
        object: usize,
        track: &Track,
        images: Vec<&ObjectImage>,
        offered: &mut Offered,
    ) -> Vec<Keyframe> {
        let timeline = &self.timelines[object];
        let builder = |track, images| KeyframeBuilder {
            object,
            track,
            images,
            site: &self.site,
            options: &self.options,
        };
        if let [image] = images[..]
            && let Some((track, stretch)) = stretch(timeline, image)
        {
            if image.capture_ns < offered.stretch_ns.saturating_add(STRETCH_NS) {
                return Vec::new();
            }
            offered.stretch_ns = image.capture_ns;
            return builder(track, &stretch[..]).of_stretch();
        }
        let images = with_newest_of_others(timeline, track.time_ns, images);
        builder(track, &images[..]).for_calibration()
    }

    /// The files have changed.
    pub(crate) fn forget_calibration(&mut self) {
        self.self_calibration.reset();
        self.offered.clear();
    }

    /// With the uncertainty of the object's own frame and of the common scale.
    pub(crate) fn with_frame(&self, object: usize, mut estimate: ObjectEstimate) -> ObjectEstimate {
        if let Some(frame) = self.site.frame(object) {
            estimate.covariance += frame.covariance_of(&estimate.world_from_object);
        }
        estimate
    }
}

/// Length of a stretch of time whose images make a keyframe, ns: more than a period of most cameras.
const STRETCH_NS: u64 = 110_000_000;
/// Most images of each camera in it.
const MOST_IMAGES: usize = 3;
/// Instants after which no further object's window is processed again with an image: a few ms.
const MOST_REPROCESSED: usize = 240;

/// The last stretch of time until an image, which no other camera took at once: the track in its middle, and the images
/// camera by camera. `None` where others did, or where no other camera shows the object.
fn stretch<'a>(
    timeline: &'a Timeline,
    last: &'a ObjectImage,
) -> Option<(&'a Track, Vec<&'a ObjectImage>)> {
    let earliest_ns = last.capture_ns.checked_sub(STRETCH_NS)?;
    let instants: Vec<_> = timeline
        .between(Some(earliest_ns), last.capture_ns.saturating_add(1))
        .collect();
    let (middle, _) = instants.get(instants.len() / 2)?;
    if instants.iter().any(|(_, images)| images.len() > 1) {
        return None;
    }
    let mut of_cameras: BTreeMap<usize, Vec<&ObjectImage>> = BTreeMap::new();
    for image in instants.iter().rev().flat_map(|(_, images)| images) {
        let own = of_cameras.entry(image.camera_index).or_default();
        if own.len() < MOST_IMAGES {
            own.push(image);
        }
    }
    let is_joint = of_cameras.len() > 1;
    is_joint.then(|| (*middle, of_cameras.into_values().flatten().collect()))
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
