//! The machine of a whole site: cameras that stand still, and cameras that objects carry.
//!
//! A carried camera is where the tags of landmarks say: objects that stand still in the world. Seen from its carrier
//! the cameras hold still and the landmarks move as one object, so that the same machine finds `carrier_from_world`
//! with its covariance, estimates clocks and errors of the files, and names faults. Its inverse is the carrier's pose.
//! Where cameras that stand still see the carrier too, both estimates are independent of each other and are combined by
//! their information.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, PoseSigma, Rig, TagId,
};
use sextant_site_report::{ClockOffset, Fault, Imperfection, ObjectEstimate, State};

use crate::fading_counter::FadingCounter;
use crate::fusion::RigFusion;
use crate::fusion::task::SolverTask;
use crate::{FusionOptions, Input, ModelError, Output, Proposal, Statistics};

/// Squared distance of two estimates of one pose, in sigmas, beyond which they contradict each other: one in a thousand
/// by chance.
const CONTRADICTION: f64 = 22.46;
/// Estimates in the last second, and the share of them, from which a contradiction is named.
const FEWEST: f64 = 5.0;
const MOST_CONTRADICTED: f64 = 0.5;

/// Fuses the images of all cameras into one pose per object.
#[derive(Debug)]
pub struct Fusion {
    options: FusionOptions,
    still: RigFusion,
    carriers: Vec<Carrier>,
    outputs: VecDeque<Output>,
}

/// An object that carries cameras.
#[derive(Debug)]
struct Carrier {
    object: ObjectId,
    /// The carried cameras as a rig whose world is the carrier, and the landmarks as its only object.
    fusion: RigFusion,
    landmarks: Landmarks,
    /// Of its poses, those that contradict what cameras that stand still see of it.
    contradicted: FadingCounter,
}

/// All landmarks as one object.
#[derive(Debug, Clone, PartialEq)]
struct Landmarks {
    /// Its frame is the world moved to the middle of the tags: far from them its motion would be that of a long lever.
    model: ObjectModel,
    middle: Vector3<f64>,
    /// The object of each tag.
    owners: BTreeMap<TagId, ObjectId>,
}

impl Fusion {
    /// A machine for these cameras and objects.
    ///
    /// # Errors
    /// When objects share a name or a tag, or an option is outside of its range.
    pub fn new(
        rig: Rig,
        objects: Vec<ObjectModel>,
        options: FusionOptions,
    ) -> Result<Self, ModelError> {
        let mut fusion = Self {
            still: RigFusion::new(rig, objects, options.clone())?,
            options,
            carriers: Vec::new(),
            outputs: VecDeque::new(),
        };
        fusion.take_models();
        Ok(fusion)
    }

    /// From now on the errors of the files are adjusted apart: all but the first, small adjustments wait in
    /// [`Self::task`] until [`Input::Adjusted`] comes, so that no image waits for them. Otherwise each is solved
    /// at once.
    pub fn adjust_apart(&mut self) {
        self.machines_mut().for_each(RigFusion::adjust_apart);
    }

    /// The task that is due, for another thread to solve.
    pub fn task(&self) -> Option<SolverTask> {
        self.machines().find_map(RigFusion::task)
    }

    /// Takes an input in; `now_ns` is the present in ns since the Unix epoch. It goes back with [`Input::ClockStep`]
    /// only.
    pub fn handle(&mut self, now_ns: u64, input: Input) {
        match input {
            Input::Image(image) => self.take_image(now_ns, image),
            Input::Rig(_) | Input::Objects(_) => {
                self.still.handle(now_ns, input);
                self.take_models();
            }
            Input::Adjusted => {
                let mut machines = self.machines_mut();
                if let Some(due) = machines.find(|machine| machine.task().is_some()) {
                    due.handle(now_ns, Input::Adjusted);
                }
            }
            Input::ClockStep { by_ns } => {
                let step = || Input::ClockStep { by_ns };
                self.machines_mut()
                    .for_each(|machine| machine.handle(now_ns, step()));
            }
            Input::Tick => self
                .machines_mut()
                .for_each(|machine| machine.handle(now_ns, Input::Tick)),
        }
        self.collect();
    }

    /// The next output, oldest first.
    pub fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    /// When to call `handle` with [`Input::Tick`] at the latest, if nothing else comes.
    pub fn poll_timeout(&self) -> Option<u64> {
        self.machines().filter_map(RigFusion::poll_timeout).min()
    }

    /// The pose of an object at any time, predicted from the images up to it; `None` where it is unknown or lost by
    /// then.
    pub fn pose_at(&self, object: &ObjectId, time_ns: u64) -> Option<ObjectEstimate> {
        let seen = self.still.pose_at(object, time_ns);
        let mut carriers = self.carriers.iter();
        let carrier = carriers.find(|carrier| carrier.object == *object);
        let carried = carrier.and_then(|carrier| carrier.pose_at(time_ns));
        match (seen, carried) {
            (Some(seen), carried) => Combined::combine(seen, carried).estimate,
            (None, carried) => carried,
        }
    }

    /// Faults of the site.
    pub fn faults(&self) -> Vec<Fault> {
        let mut all = self.still.faults();
        let carriers = self.carriers.iter();
        all.extend(carriers.clone().flat_map(Carrier::faults));
        let now_ns = self.still.present_ns();
        all.extend(carriers.filter_map(|carrier| carrier.contradiction(now_ns)));
        all
    }

    /// Errors of the files of rig and objects, which poses allow for.
    pub fn imperfections(&self) -> Vec<Imperfection> {
        let mut all = self.still.imperfections().to_vec();
        all.extend(self.carriers.iter().flat_map(Carrier::imperfections));
        all
    }

    /// A calibration of what stands still that explains images better than that in force; `None` while there is no
    /// clearly better one, or while a fault of a camera or a tag is named.
    pub fn proposal(&self) -> Option<Proposal> {
        self.still.proposal()
    }

    /// Counts since the start.
    pub fn statistics(&self) -> Statistics {
        let mut all = self.still.statistics().clone();
        for carrier in &self.carriers {
            let of_carrier = carrier.fusion.statistics();
            let cameras = of_carrier.cameras.iter();
            all.cameras
                .extend(cameras.map(|(camera, counts)| (camera.clone(), *counts)));
        }
        all
    }

    /// By how much clocks of cameras are off, and that the offset of others is not known.
    pub fn clock_offsets(&self) -> BTreeMap<CameraId, ClockOffset> {
        self.machines().flat_map(RigFusion::clock_offsets).collect()
    }

    fn machines(&self) -> impl Iterator<Item = &RigFusion> {
        let carried = self.carriers.iter().map(|carrier| &carrier.fusion);
        std::iter::once(&self.still).chain(carried)
    }

    fn machines_mut(&mut self) -> impl Iterator<Item = &mut RigFusion> {
        let carried = self.carriers.iter_mut().map(|carrier| &mut carrier.fusion);
        std::iter::once(&mut self.still).chain(carried)
    }

    fn take_image(&mut self, now_ns: u64, image: ImageObservation) {
        let mut carriers = self.carriers.iter_mut();
        let carrier = carriers.find(|carrier| carrier.has(&image.camera));
        let (machine, others) = match carrier {
            Some(carrier) => (&mut carrier.fusion, Some(&mut self.still)),
            None => (&mut self.still, None),
        };
        machine.handle(now_ns, Input::Image(image));
        // Losses are due whatever comes in.
        if let Some(still) = others {
            still.handle(now_ns, Input::Tick);
        }
    }

    /// Derives the carriers from the models in force. One whose cameras and landmarks are as before goes on.
    fn take_models(&mut self) {
        let (rig, objects) = self.still.models();
        let landmarks = Landmarks::from_objects(objects);
        let mut former = std::mem::take(&mut self.carriers);
        for object in rig.carriers() {
            let Some((rig, landmarks)) = rig_of(object, rig).zip(landmarks.clone()) else {
                continue;
            };
            let same = former.iter().position(|one| {
                one.object == *object && *one.fusion.models().0 == rig && one.landmarks == landmarks
            });
            let carrier = match same {
                Some(same) => Some(former.swap_remove(same)),
                None => Carrier::new(object.clone(), rig, landmarks, &self.still, &self.options),
            };
            self.carriers.extend(carrier);
        }
    }

    /// Takes the outputs of all machines over, poses of one object combined.
    fn collect(&mut self) {
        let mut outputs = Vec::new();
        while let Some(output) = self.still.poll_output() {
            let Output::Pose(seen) = output else {
                outputs.push(output);
                continue;
            };
            let mut carriers = self.carriers.iter_mut();
            let carrier = carriers.find(|carrier| carrier.object == seen.object);
            let combined = match carrier {
                Some(carrier) => carrier.combined(seen),
                None => Some(seen),
            };
            outputs.extend(combined.map(Output::Pose));
        }
        for index in 0..self.carriers.len() {
            while let Some(output) = self.carriers[index].fusion.poll_output() {
                let Output::Pose(seen) = output else {
                    continue;
                };
                let carrier = &mut self.carriers[index];
                let carried = carrier.inverted(&seen);
                let other = self.still.pose_at(&carrier.object, carried.capture_ns);
                let combined = Combined::combine(carried, other);
                carrier.note(&combined, seen.capture_ns);
                outputs.extend(combined.estimate.map(Output::Pose));
            }
        }
        self.outputs.extend(outputs);
    }
}

impl Carrier {
    fn new(
        object: ObjectId,
        rig: Rig,
        landmarks: Landmarks,
        still: &RigFusion,
        options: &FusionOptions,
    ) -> Option<Self> {
        let objects = vec![landmarks.model.clone()];
        // One object with the tags of several, in which each is once: nothing can be wrong with it.
        let mut fusion = RigFusion::new(rig, objects, options.clone()).ok()?;
        if still.adjusts_apart() {
            fusion.adjust_apart();
        }
        Some(Self {
            object,
            fusion,
            landmarks,
            contradicted: FadingCounter::default(),
        })
    }

    fn has(&self, camera: &CameraId) -> bool {
        self.fusion.models().0.camera(camera).is_some()
    }

    fn pose_at(&self, time_ns: u64) -> Option<ObjectEstimate> {
        let seen = self.fusion.pose_at(self.landmarks.model.id(), time_ns)?;
        Some(self.inverted(&seen))
    }

    /// The pose of the carrier in the world from that of the landmarks in the carrier.
    fn inverted(&self, seen: &ObjectEstimate) -> ObjectEstimate {
        let mut world_from_carrier = seen.world_from_object.inverse();
        world_from_carrier.translation.vector += self.landmarks.middle;
        let slopes = slopes_of_inverse(&seen.world_from_object);
        let covariance = slopes * seen.covariance * slopes.transpose();
        ObjectEstimate {
            object: self.object.clone(),
            capture_ns: seen.capture_ns,
            world_from_object: world_from_carrier,
            covariance: (covariance + covariance.transpose()) * 0.5,
            twist: slopes * seen.twist,
            state: seen.state,
            cameras: seen.cameras,
            tags: seen.tags,
            rms_px: seen.rms_px,
            articulated: None,
        }
    }

    /// What cameras that stand still have seen of it, with what its own see at that time.
    fn combined(&mut self, seen: ObjectEstimate) -> Option<ObjectEstimate> {
        let time_ns = seen.capture_ns;
        let combined = Combined::combine(seen, self.pose_at(time_ns));
        self.note(&combined, time_ns);
        combined.estimate
    }

    fn note(&mut self, combined: &Combined, time_ns: u64) {
        if let Some(is_contradicted) = combined.is_contradicted {
            self.contradicted.add(time_ns, is_contradicted);
        }
    }

    /// The fault of poses that contradict what cameras that stand still see.
    fn contradiction(&self, now_ns: u64) -> Option<Fault> {
        let lately = self.contradicted.faded(now_ns);
        let share = lately.share();
        let is_sure = lately.total >= FEWEST && share > MOST_CONTRADICTED;
        is_sure.then(|| Fault::ObjectContradicted {
            object: self.object.clone(),
            share,
        })
    }

    /// Faults of its cameras and of the landmarks, by the names of the site.
    fn faults(&self) -> Vec<Fault> {
        let mut faults = self.fusion.faults();
        for fault in &mut faults {
            match fault {
                Fault::TagMisplaced { object, tag } | Fault::TagSize { object, tag, .. } => {
                    self.landmarks.name(object, tag);
                }
                Fault::TagElsewhere { object, tag, .. } => self.landmarks.name(object, tag),
                _ => {}
            }
        }
        faults
    }

    fn imperfections(&self) -> Vec<Imperfection> {
        let mut all = self.fusion.imperfections().to_vec();
        for one in &mut all {
            match one {
                Imperfection::TagOff { object, tag, .. }
                | Imperfection::SizeOff { object, tag, .. } => self.landmarks.name(object, tag),
                _ => {}
            }
        }
        all
    }
}

impl Landmarks {
    /// `None` where no tag of a landmark has a place.
    fn from_objects(objects: &[ObjectModel]) -> Option<Self> {
        let standing = objects.iter().filter_map(|object| {
            let place = object.world_from_object()?;
            Some((object, place))
        });
        let (mut tags, mut owners) = (Vec::new(), BTreeMap::new());
        let (mut scale_sigma, mut frame_sigma) = (0.0_f64, PoseSigma::NONE);
        let mut first = None;
        for (object, world_from_object) in standing {
            let is_only = object.tags().len() == 1;
            for tag in object.tags() {
                let on_object = tag.object_from_tag.or(is_only.then(Pose::identity));
                let Some(on_object) = on_object else {
                    continue;
                };
                owners.insert(tag.tag, object.id().clone());
                tags.push(ObjectTag {
                    object_from_tag: Some(world_from_object * on_object),
                    ..tag.clone()
                });
            }
            scale_sigma = scale_sigma.max(object.scale_sigma_or_usual());
            if let Some(sigma) = object.frame_sigma() {
                frame_sigma.position_m = frame_sigma.position_m.max(sigma.position_m);
                frame_sigma.orientation_rad =
                    frame_sigma.orientation_rad.max(sigma.orientation_rad);
            }
            first = first.or_else(|| Some(object.id().clone()));
        }
        let places = || tags.iter().filter_map(|tag| tag.object_from_tag);
        let sum: Vector3<f64> = places().map(|place| place.translation.vector).sum();
        let middle = sum / places().count().max(1) as f64;
        for place in tags
            .iter_mut()
            .filter_map(|tag| tag.object_from_tag.as_mut())
        {
            place.translation.vector -= middle;
        }
        let model = ObjectModel::new(first?, tags).ok()?;
        let model = model.with_scale_sigma(Some(scale_sigma)).ok()?;
        let model = model.with_frame_sigma(Some(frame_sigma)).ok()?;
        Some(Self {
            model,
            middle,
            owners,
        })
    }

    /// Writes the object that a tag is on.
    fn name(&self, object: &mut ObjectId, tag: &TagId) {
        if let Some(owner) = self.owners.get(tag) {
            object.clone_from(owner);
        }
    }
}

/// The cameras of a carrier, which is their world; `None` where there are none.
fn rig_of(carrier: &ObjectId, rig: &Rig) -> Option<Rig> {
    let own = rig.cameras().iter().filter_map(|camera| {
        let mount = camera.mount.as_ref()?;
        (mount.carrier == *carrier).then(|| Camera {
            world_from_camera: Some(mount.carrier_from_camera),
            mount: None,
            ..camera.clone()
        })
    });
    Rig::new(own.collect()).ok()
}

/// What two estimates of one pose say together.
#[derive(Debug)]
struct Combined {
    /// `None` where the other one is to be published instead.
    estimate: Option<ObjectEstimate>,
    /// Whether they contradict each other; `None` where there are not two.
    is_contradicted: Option<bool>,
}

impl Combined {
    /// An estimate with another one of the same object and time, which is independent of it.
    fn combine(own: ObjectEstimate, other: Option<ObjectEstimate>) -> Self {
        let is_known =
            |one: &ObjectEstimate| matches!(one.state, State::Tracking | State::Coasting);
        let alone = |estimate| Self {
            estimate,
            is_contradicted: None,
        };
        let Some(other) = other.filter(is_known) else {
            return alone(Some(own));
        };
        if !is_known(&own) {
            // What one of the two still sees is not lost.
            let is_lost = own.state == State::Lost;
            return alone((!is_lost).then_some(other));
        }
        let apart = se3::difference(&other.world_from_object, &own.world_from_object);
        let both = (own.covariance + other.covariance).cholesky();
        let informations = own
            .covariance
            .try_inverse()
            .zip(other.covariance.try_inverse());
        let Some((both, (of_own, of_other))) = both.zip(informations) else {
            return alone(Some(own));
        };
        if apart.dot(&both.solve(&apart)) > CONTRADICTION {
            return Self::contradicted(own, other, &apart);
        }
        let Some(covariance) = (of_own + of_other).try_inverse() else {
            return alone(Some(own));
        };
        let step: Vector6<f64> = covariance * of_other * apart;
        let is_tracking = own.state == State::Tracking || other.state == State::Tracking;
        Self {
            estimate: Some(ObjectEstimate {
                world_from_object: se3::perturb(&own.world_from_object, &step),
                covariance: (covariance + covariance.transpose()) * 0.5,
                state: if is_tracking {
                    State::Tracking
                } else {
                    State::Coasting
                },
                cameras: own.cameras + other.cameras,
                tags: own.tags + other.tags,
                ..own
            }),
            is_contradicted: Some(false),
        }
    }

    /// Which is wrong is not known: the more certain one, wide enough for both.
    fn contradicted(own: ObjectEstimate, other: ObjectEstimate, apart: &Vector6<f64>) -> Self {
        let spread = |one: &ObjectEstimate| one.covariance.fixed_view::<3, 3>(0, 0).trace();
        let surer = if spread(&other) < spread(&own) {
            other
        } else {
            own
        };
        Self {
            estimate: Some(ObjectEstimate {
                covariance: surer.covariance + apart * apart.transpose(),
                ..surer
            }),
            is_contradicted: Some(true),
        }
    }
}

/// How the inverse of a pose moves with it, both steps (dt, dr) in the axes that the poses map into: with p = -R't, p +
/// dp = -R' exp(-dr) (t + dt), dp = -R' dt - R' [t]x dr, and the inverse turns by -R' dr.
fn slopes_of_inverse(pose: &Pose) -> Matrix6<f64> {
    let back: Matrix3<f64> = pose.rotation.inverse().to_rotation_matrix().into_inner();
    let arm = pose.translation.vector.cross_matrix();
    let mut slopes = Matrix6::zeros();
    slopes.fixed_view_mut::<3, 3>(0, 0).copy_from(&-back);
    slopes
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&(-back * arm));
    slopes.fixed_view_mut::<3, 3>(3, 3).copy_from(&-back);
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slopes_of_an_inverse_are_those_of_differences() {
        let pose = se3::exp(&Vector6::new(0.3, -0.2, 1.4, 0.5, -0.9, 0.2));
        let slopes = slopes_of_inverse(&pose);
        for axis in 0..6 {
            let mut step = Vector6::zeros();
            step[axis] = 1e-6;
            let moved = se3::perturb(&pose, &step).inverse();
            let by = se3::difference(&moved, &pose.inverse()) / 1e-6;
            assert!((by - slopes.column(axis)).norm() < 1e-5, "{axis}: {by}");
        }
    }
}
