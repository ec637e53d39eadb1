//! Mistakes of the files and in the room: found, mended in the models, reported.

use std::collections::BTreeSet;

use crate::contradictions::TrackDoubts;
use crate::fusion::RigFusion;
use crate::mended::MendedModels;
use crate::site::AssociatedImage;
use crate::site::indexed_site::IndexedSite;
use crate::tracker::timeline::Timeline;
use sextant_mistakes::Mistake;
use sextant_site_model::{ImageObservation, ObjectModel, Rig};
use sextant_site_report::{Fault, ObjectEstimate, State};

impl RigFusion {
    /// Compares an image with the models, and mends the mistakes that explain what contradicts; returns the image by
    /// the models in force then.
    pub(crate) fn check_mistakes(
        &mut self,
        image: &ImageObservation,
        associated: AssociatedImage,
    ) -> AssociatedImage {
        for (object, seen) in &associated.objects {
            let doubts = self.track_doubts(*object, seen.camera_index);
            self.contradictions
                .take(*object, seen, &doubts, &self.site, &self.options);
        }
        // Adjustments come first: images would contradict a site that waits for one.
        if self.self_calibration.due().is_none() {
            self.contradictions.prepare(&self.site);
        }
        let is_due = self.contradictions.due().is_some();
        if !is_due || self.adjusts_apart || !self.take_found() {
            return associated;
        }
        match self.site.camera(&image.camera) {
            Some((camera_index, _)) => self.site.associate(camera_index, image, &self.options),
            None => associated,
        }
    }

    /// Mends what the search that is due has found; whether the models have changed by it.
    pub(crate) fn take_found(&mut self) -> bool {
        let Some((mut mistakes, search)) = self.contradictions.take_found() else {
            return false;
        };
        mistakes.retain(|mistake| {
            let mut cameras = mistake.cameras().into_iter();
            !cameras.any(|camera| self.is_clock_in_question(camera))
        });
        if !mistakes.is_empty() {
            self.mend(&mistakes, search.indexed());
        }
        !mistakes.is_empty()
    }

    /// Whether what a camera shows may be due to its clock.
    pub(crate) fn is_clock_in_question(&self, camera: usize) -> bool {
        self.offset_search.is_young(self.now_ns) || self.offset_search.is_out_of_step(camera)
    }

    fn track_doubts(&self, object: usize, camera_index: usize) -> TrackDoubts {
        let track = self.timelines[object].at(u64::MAX);
        let best = track.hypotheses.first().filter(|_| track.trusted);
        let doubted = best.map_or(&[][..], |best| best.consistency.doubted());
        TrackDoubts {
            is_any: !track.summary.refused.is_empty()
                || !doubted.is_empty()
                || track.contradicted_since_ns.is_some()
                || track.refused_share(self.present_ns()).is_some(),
            cameras: doubted.to_vec(),
            ahead_s: self.ahead_s(object, camera_index),
        }
    }

    /// Takes over what is right if some mistakes were made. What was learned with them means nothing now, and tracks
    /// that they have misled start anew.
    fn mend(&mut self, mistakes: &[Mistake], indexed: &IndexedSite) {
        for mistake in mistakes {
            self.models.mend(mistake, indexed, &self.site);
        }
        let is_of_cameras = mistakes.iter().any(|one| !one.cameras().is_empty());
        let tags = mistakes.iter().flat_map(|one| one.tags(&indexed.site));
        let concerned: BTreeSet<usize> =
            tags.map(|tag| indexed.object(indexed.body(tag))).collect();
        let (rig, objects) = self.models.in_force();
        let (rig, objects) = (rig.clone(), objects.to_vec());
        self.put_in_force(&rig, &objects);
        self.restart_tracks(|object| is_of_cameras || concerned.contains(&object));
        self.forget_calibration();
        self.diagnosis.reset();
        self.offset_search.models_changed();
        self.contradictions.models_mended(&indexed.site);
    }

    /// Takes the models of the files over again: what was mended with other files means nothing with new ones.
    pub(crate) fn return_to_files(&mut self) {
        if !self.models.is_mended() {
            return;
        }
        let (rig, objects) = self.models.files();
        let (rig, objects) = (rig.clone(), objects.to_vec());
        self.put_in_force(&rig, &objects);
        self.models = MendedModels::new(rig, objects);
        self.restart_tracks(|_| true);
    }

    fn put_in_force(&mut self, rig: &Rig, objects: &[ObjectModel]) {
        self.site.set_rig(rig);
        // The tags are those of the files, so that objects contradict each other no more than these do.
        let is_taken = self.site.set_objects(objects).is_ok();
        debug_assert!(is_taken, "objects of the same tags");
    }

    fn restart_tracks(&mut self, is_misled: impl Fn(usize) -> bool) {
        for (object, timeline) in self.timelines.iter_mut().enumerate() {
            if is_misled(object) {
                *timeline = Timeline::new(timeline.object().clone());
            }
        }
    }

    /// The faults of the mistakes that are mended, and of two cameras that may as well be the one or the other.
    pub(crate) fn mistakes(&self) -> Vec<Fault> {
        let mut all = self.models.faults().to_vec();
        let ids = self
            .contradictions
            .pair()
            .map(|pair| pair.map(|index| self.site.camera_id(index)));
        if let Some([Some(a), Some(b)]) = ids {
            all.push(Fault::CamerasDisagree {
                a: a.clone().min(b.clone()),
                b: a.max(b),
            });
        }
        all
    }

    /// The estimate of an object on whose pose no majority of its cameras or tags agrees is not tracked; its covariance
    /// spans what they say.
    pub(crate) fn with_doubt(&self, object: usize, mut estimate: ObjectEstimate) -> ObjectEstimate {
        let doubt = self.contradictions.doubt(object, estimate.capture_ns);
        if let Some(apart) = doubt.filter(|_| estimate.state == State::Tracking) {
            estimate.state = State::Initialising;
            let variance = apart.variance();
            for axis in 0..6 {
                estimate.covariance[(axis, axis)] += variance[axis];
            }
        }
        estimate
    }
}
