//! The state machine: images in, poses out. It has no clock and no socket; the same inputs give the same outputs.

pub(crate) mod blindness;
pub(crate) mod calibration;
pub(crate) mod clock_corrections;
pub(crate) mod faults;
pub(crate) mod intake;
pub(crate) mod mistakes;
pub(crate) mod tag_hosts;
pub(crate) mod task;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use crate::clocks::offset_search::{Arrival, OffsetSearch};
use crate::contradictions::Contradictions;
use crate::diagnosis::blind_cameras::BlindCameras;
use crate::diagnosis::frozen_cameras::FrozenCameras;
use crate::diagnosis::{Action, Diagnosis, Models};
use crate::fusion::intake::ImageIntake;
use crate::fusion::task::SolverTask;
use crate::mended::MendedModels;
use crate::self_calibration::{Offered, SelfCalibration};
use crate::site::corrections::Corrections;
use crate::site::{AssociatedImage, ModelledSite, ObjectImage};
use crate::tracker::report::{FinalisedInstant, FinalisedView};
use crate::tracker::timeline::Timeline;
use crate::{FusionOptions, ModelError, Proposal, Statistics};
use sextant_site_model::{ImageObservation, ObjectId, ObjectModel, ObjectTag, Rig};
use sextant_site_report::{Fault, Imperfection, ObjectEstimate};

/// Most cameras, those of former rigs included; when there are more, everything begins anew.
const MOST_CAMERAS: usize = 1024;

/// An input of [`crate::Fusion`].
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// An image's corners.
    Image(ImageObservation),
    /// The cameras have changed: taken whole.
    Rig(Rig),
    /// The objects have changed: taken whole or refused whole.
    Objects(Vec<ObjectModel>),
    /// The clock behind `now_ns` was set: all times before it are by another clock.
    ClockStep {
        /// By how many ns it was set forward; below zero where it was set back.
        by_ns: i64,
    },
    /// The task that is due applies ([`crate::Fusion::task`]); it is solved now unless it has been. Means
    /// nothing where none is due.
    Adjusted,
    /// Time has passed.
    Tick,
}

/// An output of [`crate::Fusion`].
#[derive(Debug, Clone, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are poses; a box would be an allocation each"
)]
pub enum Output {
    /// An object's pose at the capture time of an image.
    Pose(ObjectEstimate),
    /// New objects contradict each other; the old ones stay.
    Refused(ModelError),
    /// The clock was set: all tracks and windows start anew.
    ClockStep {
        /// By how many ns it was set forward; below zero where it was set back.
        by_ns: i64,
    },
}

/// Fuses the images of cameras that hold still to one another into one pose per object.
#[derive(Debug)]
pub(crate) struct RigFusion {
    site: ModelledSite,
    options: FusionOptions,
    models: MendedModels,
    timelines: Vec<Timeline>,
    intake: ImageIntake,
    diagnosis: Diagnosis,
    contradictions: Contradictions,
    frozen_cameras: FrozenCameras,
    blind_cameras: BlindCameras,
    offset_search: OffsetSearch,
    self_calibration: SelfCalibration,
    /// Whether [`Input::Adjusted`] says when an adjustment applies.
    adjusts_apart: bool,
    /// By object index.
    offered: Vec<Offered>,
    /// The latest time given, ns.
    now_ns: u64,
    /// When the clock offsets of the filters are evaluated next, ns.
    next_offsets_ns: u64,
    /// By object index.
    emitted: Vec<Emitted>,
    outputs: VecDeque<Output>,
    /// Actions of diagnosis that are not applied yet.
    actions: Vec<Action>,
}

/// What has been published of an object beside the poses of its images.
#[derive(Debug, Clone, Copy, Default)]
struct Emitted {
    /// When it was last seen before it was published as lost, ns.
    loss_ns: u64,
    /// Capture time of the last prediction, ns.
    prediction_ns: u64,
}

impl RigFusion {
    /// A machine for these cameras and objects.
    ///
    /// # Errors
    /// When objects share a name or a tag, or an option is outside of its range.
    pub fn new(
        rig: Rig,
        objects: Vec<ObjectModel>,
        options: FusionOptions,
    ) -> Result<Self, ModelError> {
        options.validate()?;
        let site = ModelledSite::new(&rig, &objects)?;
        let timelines: Vec<_> = site.objects().iter().cloned().map(Timeline::new).collect();
        let emitted = vec![Emitted::default(); timelines.len()];
        let intake = ImageIntake::new(&site);
        Ok(Self {
            site,
            options,
            models: MendedModels::new(rig, objects),
            timelines,
            intake,
            diagnosis: Diagnosis::default(),
            contradictions: Contradictions::default(),
            frozen_cameras: FrozenCameras::default(),
            blind_cameras: BlindCameras::default(),
            offset_search: OffsetSearch::default(),
            self_calibration: SelfCalibration::default(),
            adjusts_apart: false,
            offered: Vec::new(),
            now_ns: 0,
            next_offsets_ns: 0,
            emitted,
            outputs: VecDeque::new(),
            actions: Vec::new(),
        })
    }

    /// From now on the errors of the files are adjusted apart: all but the first, small adjustments wait in
    /// [`Self::task`] until [`Input::Adjusted`] comes, so that no image waits for them. Otherwise each is solved
    /// at once.
    pub fn adjust_apart(&mut self) {
        self.adjusts_apart = true;
    }

    /// Whether adjustments wait for [`Input::Adjusted`].
    pub fn adjusts_apart(&self) -> bool {
        self.adjusts_apart
    }

    /// The task that is due, for another thread to solve.
    pub fn task(&self) -> Option<SolverTask> {
        let search = self.contradictions.due().cloned();
        let adjustment = || self.self_calibration.due().cloned();
        search
            .map(SolverTask::Mistakes)
            .or_else(|| adjustment().map(SolverTask::Adjustment))
    }

    /// Takes an input in; `now_ns` is the present in ns since the Unix epoch. It goes back with [`Input::ClockStep`]
    /// only.
    pub fn handle(&mut self, now_ns: u64, input: Input) {
        self.now_ns = match input {
            Input::ClockStep { .. } => now_ns,
            _ => self.now_ns.max(now_ns),
        };
        let now_ns = self.now_ns;
        match input {
            Input::Image(image) => self.take_image(now_ns, &image),
            Input::Rig(rig) => self.take_rig(&rig),
            Input::Objects(objects) => self.take_objects(objects),
            Input::ClockStep { by_ns } => self.take_clock_step(by_ns),
            Input::Adjusted => self.take_solved(),
            Input::Tick => {}
        }
        self.emit_losses(self.present_ns());
    }

    /// Applies the task that is due: a search for mistakes before an adjustment.
    fn take_solved(&mut self) {
        if self.contradictions.due().is_some() {
            self.take_found();
        } else {
            self.take_adjusted();
        }
    }

    /// The next output, oldest first.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When to call `handle` with [`Input::Tick`] at the latest, if nothing else comes.
    pub fn poll_timeout(&self) -> Option<u64> {
        let losses = (0..self.timelines.len()).filter_map(|object| self.loss_ns(object));
        let host_offset_ns = self.offset_search.host_offset_ns();
        let losses = losses.map(|ns| ns.saturating_add_signed(host_offset_ns));
        losses.chain(self.intake.next_gone_ns(self.now_ns)).min()
    }

    /// The pose of an object at any time, predicted from the images up to it; `None` where it is unknown or lost by
    /// then.
    pub fn pose_at(&self, object: &ObjectId, time_ns: u64) -> Option<ObjectEstimate> {
        let timeline = self
            .timelines
            .iter()
            .find(|timeline| timeline.object() == object)?;
        let estimate = timeline.estimate(time_ns, &self.site, &self.options)?;
        let index = self.site.objects().iter().position(|id| id == object)?;
        let estimate = self.with_doubt(index, self.with_frame(index, estimate));
        Some(estimate).filter(ObjectEstimate::is_finite)
    }

    /// Faults of the site.
    pub fn faults(&self) -> Vec<Fault> {
        let mut all = faults::all(
            &self.site,
            &self.diagnosis,
            &self.clock_offsets(),
            &self.offset_search,
            self.now_ns,
        );
        for mistake in self.mistakes() {
            if !all.contains(&mistake) {
                all.push(mistake);
            }
        }
        let frozen = self.frozen_cameras.frozen();
        let blind = self.blind_cameras.blind(self.now_ns);
        let of_cameras = faults::of_cameras(&self.site, frozen, blind, &self.diagnosis);
        all.extend(of_cameras);
        all.extend(faults::of_sizes(&self.site, self.intake.other_sizes()));
        all.retain(|fault| {
            let camera = faults::camera_of_images(fault);
            camera.is_none_or(|camera| self.intake.is_present(camera, self.now_ns))
        });
        // Of two cameras that contradict each other nobody knows which views are right.
        let is_explained = all
            .iter()
            .any(|fault| matches!(fault, Fault::CamerasDisagree { .. }));
        let of_objects = faults::of_objects(&self.site, &self.models, |object| {
            self.timelines[object]
                .at(u64::MAX)
                .refused_share(self.present_ns())
        });
        all.extend(
            of_objects.into_iter().filter(|fault| {
                !(is_explained && matches!(fault, Fault::ObjectContradicted { .. }))
            }),
        );
        all
    }

    /// Errors of the files of rig and objects, which poses allow for.
    pub fn imperfections(&self) -> &[Imperfection] {
        self.self_calibration.imperfections()
    }

    /// A calibration that explains images better than the files: mistakes mended, and errors taken off. `None` while
    /// there is no clearly better one, or while a fault of a camera or a tag is named that is not mended.
    pub fn proposal(&self) -> Option<Proposal> {
        let spoils_nothing = |fault: &Fault| {
            matches!(
                fault,
                Fault::ClockOff { .. }
                    | Fault::Untimely { .. }
                    | Fault::HostClockOff { .. }
                    | Fault::CameraFrozen { .. }
                    | Fault::CameraBlind { .. }
                    | Fault::ImageSize { .. }
                    | Fault::ObjectScaled { .. }
                    | Fault::ObjectUnplaced { .. }
            ) || self.models.faults().contains(fault)
        };
        let by_mending = || self.contradictions.judged_mended();
        let (corrections, held_back) = match self.self_calibration.proposal() {
            Some((corrections, held_back)) => (corrections.clone(), *held_back),
            None => (Corrections::default(), by_mending()?),
        };
        let proposal = Proposal::new(&self.models, &corrections, held_back, &self.site);
        let is_sound = self.contradictions.is_closed() && self.faults().iter().all(spoils_nothing);
        is_sound.then_some(proposal)
    }

    /// The cameras and objects of the files in force.
    pub fn models(&self) -> (&Rig, &[ObjectModel]) {
        self.models.files()
    }

    /// Counts since the start.
    pub fn statistics(&self) -> &Statistics {
        self.intake.statistics()
    }

    fn take_image(&mut self, now_ns: u64, image: &ImageObservation) {
        self.intake.note_arrival(now_ns, &image.camera, &self.site);
        if self.intake.is_of_other_size(image, &self.site)
            || self
                .intake
                .is_from_before_step(now_ns, image, &self.options)
        {
            return;
        }
        let Some(image) = self.correct_timestamp(now_ns, image) else {
            return;
        };
        let image = &image;
        self.self_calibrate(image.capture_ns);
        self.reprocess_outdated();
        let Some(associated) =
            self.intake
                .admit(self.present_ns(), image, &self.site, &self.options)
        else {
            return;
        };
        let Some((camera_index, _)) = self.site.camera(&image.camera) else {
            return;
        };
        self.frozen_cameras.record(camera_index, now_ns, image);
        if self.frozen_cameras.is_left_behind(camera_index, now_ns) {
            self.refuse(image, &associated);
            return;
        }
        self.note_blindness(camera_index, image);
        let tags = image.tags.iter().map(|seen| seen.tag);
        self.diagnosis
            .record_duplicates(camera_index, image.capture_ns, tags);
        let associated = self.check_mistakes(image, associated);
        if self.contradictions.is_suspended(camera_index)
            && !self.is_clock_in_question(camera_index)
        {
            self.refuse(image, &associated);
            for object in 0..self.timelines.len() {
                self.take_absence(object, image.capture_ns);
            }
            return;
        }
        let mut timely = Arrival::Yes;
        for object in 0..self.timelines.len() {
            match associated.objects.get(&object) {
                Some(seen) => {
                    if self.take_object_image(object, image, seen) == Arrival::No {
                        timely = Arrival::No;
                    }
                }
                None => self.take_absence(object, image.capture_ns),
            }
        }
        self.update_clock_search(camera_index, &associated, timely);
        self.apply_actions();
        self.move_far_offsets();
    }

    /// Counts all views of an image as rejected.
    fn refuse(&mut self, image: &ImageObservation, associated: &AssociatedImage) {
        let n_views = associated.objects.values().map(|seen| seen.views.len());
        let n_views = n_views.sum();
        self.intake.count_views(&image.camera, n_views, n_views);
    }

    fn take_object_image(
        &mut self,
        object: usize,
        image: &ImageObservation,
        seen: &Arc<ObjectImage>,
    ) -> Arrival {
        let timeline = &mut self.timelines[object];
        let is_past = image.capture_ns < timeline.newest_ns();
        if is_past && self.offset_search.is_behind(seen.camera_index, &self.site) {
            self.intake.count_late(&image.camera);
            return Arrival::No;
        }
        let finalised = timeline.insert(seen.clone(), &self.site, &self.options);
        let Ok(finalised) = finalised else {
            self.intake.count_late(&image.camera);
            return Arrival::No;
        };
        self.take_finalised(object, &finalised);
        let timeline = &mut self.timelines[object];
        timeline.catch_up(image.capture_ns, &self.site, &self.options);
        self.self_calibrate_from_start(object, image.capture_ns);
        let timeline = &mut self.timelines[object];
        let summary = &timeline.at(image.capture_ns).summary;
        let refused = summary
            .refused
            .iter()
            .filter(|camera| **camera == seen.camera_index)
            .count();
        self.intake
            .count_views(&image.camera, seen.views.len(), refused);
        let ahead_s = self.ahead_s(object, seen.camera_index);
        self.emit(object, image.capture_ns, ahead_s);
        Arrival::Yes
    }

    /// Diagnoses instants that no late image can change any more, and applies what diagnosis asks for.
    fn take_finalised(&mut self, object: usize, finalised: &[FinalisedInstant]) {
        let mut diagnosis = std::mem::take(&mut self.diagnosis);
        for instant in finalised {
            let host = |view: &FinalisedView| self.host(object, instant.track.time_ns, view);
            let models = Models {
                self_calibration: &self.self_calibration,
                site: &self.site,
                options: &self.options,
            };
            let actions = diagnosis.take(object, instant, host, models);
            self.actions.extend(actions);
        }
        self.diagnosis = diagnosis;
    }

    /// An image without the tags of an object does not contradict a pose that others have just seen. Otherwise it gives
    /// a prediction, unless another image has just given one: their rate does not grow with the number of cameras.
    fn take_absence(&mut self, object: usize, capture_ns: u64) {
        let is_recent =
            |other_ns: u64| capture_ns.abs_diff(other_ns) as f64 * 1e-9 <= self.options.coasting_s;
        if is_recent(self.emitted[object].prediction_ns) {
            return;
        }
        self.timelines[object].catch_up(capture_ns, &self.site, &self.options);
        let seen_ns = self.timelines[object].at(capture_ns).seen_ns;
        if capture_ns > seen_ns && !is_recent(seen_ns) {
            self.emitted[object].prediction_ns = capture_ns;
            self.emit(object, capture_ns, 0.0);
        }
    }

    /// Publishes the pose after an image whose timestamp is ahead of the reference clock by `ahead_s` seconds, at the
    /// time of its capture.
    fn emit(&mut self, object: usize, stamp_ns: u64, ahead_s: f64) {
        let timeline = &self.timelines[object];
        let estimate = timeline.estimate_ahead(stamp_ns, ahead_s, &self.site, &self.options);
        let estimate = estimate.map(|estimate| self.with_frame(object, estimate));
        let estimate = estimate.map(|estimate| self.with_doubt(object, estimate));
        self.outputs
            .extend(estimate.filter(ObjectEstimate::is_finite).map(Output::Pose));
    }

    fn take_rig(&mut self, rig: &Rig) {
        if self.site.n_cameras_with(rig) > MOST_CAMERAS {
            self.forget_all(rig);
        }
        self.catch_up();
        self.return_to_files();
        let before = self.site.cameras().to_vec();
        self.site.set_rig(rig);
        let (_, objects) = self.models.files();
        self.models = MendedModels::new(rig.clone(), objects.to_vec());
        self.contradictions.models_changed();
        self.forget_calibration();
        self.diagnosis.reset();
        self.offset_search.models_changed();
        self.intake.rig_changed(&self.site);
        for timeline in &mut self.timelines {
            timeline.discard_images();
            timeline.take_rig(&before, &self.site);
        }
    }

    /// Forgets everything, tracks included: too many cameras have come and gone.
    fn forget_all(&mut self, rig: &Rig) {
        let (_, objects) = self.models.files();
        let anew = Self::new(rig.clone(), objects.to_vec(), self.options.clone());
        // The objects and the options are in force already, so that nothing can be wrong with them.
        if let Ok(anew) = anew {
            *self = Self {
                now_ns: self.now_ns,
                adjusts_apart: self.adjusts_apart,
                outputs: std::mem::take(&mut self.outputs),
                ..anew
            };
        }
    }

    fn take_objects(&mut self, objects: Vec<ObjectModel>) {
        self.catch_up();
        self.return_to_files();
        if let Err(error) = self.site.set_objects(&objects) {
            self.outputs.push_back(Output::Refused(error));
            return;
        }
        self.contradictions.forget();
        self.forget_calibration();
        self.diagnosis.reset();
        self.offset_search.models_changed();
        let mut old: BTreeMap<ObjectId, (ObjectModel, Timeline, Emitted)> = BTreeMap::new();
        let (rig, before) = self.models.files();
        let parts = before
            .iter()
            .cloned()
            .zip(self.timelines.drain(..))
            .zip(self.emitted.drain(..));
        old.extend(
            parts.map(|((model, timeline), emitted)| {
                (model.id().clone(), (model, timeline, emitted))
            }),
        );
        for model in &objects {
            let (timeline, emitted) = match old.remove(model.id()) {
                Some((before, timeline, emitted)) if before == *model => (timeline, emitted),
                Some((before, mut timeline, emitted)) if have_one_frame(&before, model) => {
                    timeline.discard_images();
                    (timeline, emitted)
                }
                _ => (Timeline::new(model.id().clone()), Emitted::default()),
            };
            self.timelines.push(timeline);
            self.emitted.push(emitted);
        }
        self.models = MendedModels::new(rig.clone(), objects);
    }

    /// Timestamps before and after the step cannot be compared, and which cameras share the clock is unknown: clock
    /// offsets start anew.
    fn take_clock_step(&mut self, by_ns: i64) {
        self.forget_times();
        self.offset_search = OffsetSearch::default();
        self.frozen_cameras = FrozenCameras::default();
        self.blind_cameras = BlindCameras::default();
        self.intake.clock_stepped(self.now_ns);
        self.outputs.push_back(Output::ClockStep { by_ns });
    }

    /// Tracks and windows start anew. Objects that were known are lost until they are seen again.
    fn forget_times(&mut self) {
        self.catch_up();
        for object in 0..self.timelines.len() {
            if self.loss_ns(object).is_some() {
                self.emit_lost(object, self.timelines[object].newest_ns());
            }
        }
        self.begin_anew(|_| true);
        self.intake.forget_times();
        self.self_calibration.forget_times();
        self.offered.clear();
        self.next_offsets_ns = 0;
        self.emitted.fill(Emitted::default());
    }

    /// Processes all late images.
    fn catch_up(&mut self) {
        for timeline in &mut self.timelines {
            timeline.catch_up(u64::MAX, &self.site, &self.options);
        }
    }

    /// When the object is lost, if it is not seen again, ns.
    fn loss_ns(&self, object: usize) -> Option<u64> {
        let seen_ns = self.timelines[object].at(u64::MAX).seen_ns;
        (seen_ns > self.emitted[object].loss_ns)
            .then(|| seen_ns.saturating_add((self.options.lost_s * 1e9) as u64))
    }

    fn emit_losses(&mut self, present_ns: u64) {
        for object in 0..self.timelines.len() {
            let is_lost = |loss_ns: &u64| present_ns >= *loss_ns;
            if self.loss_ns(object).filter(is_lost).is_none() {
                continue;
            }
            self.timelines[object].catch_up(u64::MAX, &self.site, &self.options);
            let Some(loss_ns) = self.loss_ns(object).filter(is_lost) else {
                continue;
            };
            self.emitted[object].loss_ns = self.timelines[object].at(u64::MAX).seen_ns;
            self.emit_lost(object, loss_ns);
        }
    }

    fn emit_lost(&mut self, object: usize, time_ns: u64) {
        let lost = self.timelines[object].last_estimate(time_ns, &self.options);
        self.outputs
            .extend(lost.filter(ObjectEstimate::is_finite).map(Output::Pose));
    }
}

/// Whether the object's frame is the same before and after a change: a tag of the same size and pose holds it, whatever
/// its priors.
fn have_one_frame(before: &ObjectModel, after: &ObjectModel) -> bool {
    let place = |tag: &ObjectTag| (tag.tag, tag.size_m, tag.object_from_tag);
    let mut placed = before.tags().iter();
    let stays = |tag: &ObjectTag| after.tags().iter().any(|other| place(other) == place(tag));
    before.articulation() == after.articulation()
        && placed.any(|tag| tag.object_from_tag.is_some() && stays(tag))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::{Intrinsics, Lens};
    use sextant_site_model::{Camera, CameraId};

    #[test]
    fn a_flood_of_rigs_ends_at_the_bound() {
        let lens = Lens::pinhole(Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 319.5,
            cy: 239.5,
        })
        .unwrap();
        let rig = |n: usize| {
            let camera = |k: usize| {
                Camera::new(
                    CameraId::new(&format!("c{n}-{k}")).unwrap(),
                    [640, 480],
                    lens,
                    None,
                )
            };
            Rig::new((0..256).map(camera).collect()).unwrap()
        };
        let mut fusion = RigFusion::new(rig(0), Vec::new(), FusionOptions::default()).unwrap();
        for n in 1..10 * MOST_CAMERAS / 256 {
            fusion.handle(n as u64, Input::Rig(rig(n)));
            assert!(fusion.site.cameras().len() <= MOST_CAMERAS);
            assert!(fusion.site.camera(&rig(n).cameras()[255].id).is_some());
        }
        assert_eq!(fusion.statistics().cameras.len(), 256);
    }
}
