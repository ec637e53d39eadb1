//! The status that a fusion node publishes once a second: messages received and dropped, states of the objects, faults
//! of the site, and what happened to the node itself.

use crate::intake::Intake;
use crate::notices::Notices;
use crate::outbox::Unpublished;
use crate::proposing;
use crate::refusals::{Refusals, detail};
use sextant_estimator::{Fusion, HeldBack, Statistics};
use sextant_proto::{CameraIntake, FusionStatus, NodeId, Notice, ObjectHealth, limits};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::{Fault, ObjectEstimate, State};
use std::collections::BTreeMap;

/// Collects what the next status reports.
#[derive(Debug)]
pub struct StatusReporter {
    node: NodeId,
    started_ns: u64,
    last_ns: u64,
    objects: BTreeMap<ObjectId, ObjectCount>,
    /// Changes refused in the last minute.
    pub refusals: Refusals,
    /// Newest epoch of the poses that this node publishes; none while it publishes none.
    pub epoch: Option<u64>,
    /// Hosts of other fusion nodes of this name.
    pub namesakes: Vec<String>,
    /// What is wrong with the models of this node and of others.
    pub models: Vec<Notice>,
    /// Figures of the refined calibration that is proposed.
    pub proposed: Option<HeldBack>,
    notices: Notices,
    /// Observations that were too old because this node has read them late.
    late_here: u64,
    /// Losses up to the last status.
    losses: Losses,
}

/// Messages lost since the process started.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Losses {
    /// Observations dropped unread.
    pub unread: u64,
    /// Poses held up in the node until they were too old.
    pub held_up: u64,
    /// Messages that could not be published.
    pub unpublished: Unpublished,
}

#[derive(Debug, Clone, Copy)]
struct ObjectCount {
    state: State,
    poses: u64,
}

impl StatusReporter {
    /// A reporter from `now_ns` on, by the monotonic clock as all times here; every object is lost until it is seen.
    #[must_use]
    pub fn new(node: NodeId, objects: Vec<ObjectId>, now_ns: u64) -> Self {
        let mut reporter = Self {
            node,
            started_ns: now_ns,
            last_ns: now_ns,
            objects: BTreeMap::new(),
            refusals: Refusals::default(),
            epoch: None,
            namesakes: Vec::new(),
            models: Vec::new(),
            proposed: None,
            notices: Notices::default(),
            late_here: 0,
            losses: Losses::default(),
        };
        reporter.take_objects(objects);
        reporter
    }

    /// The site has other objects now; those that stay keep their state.
    pub fn take_objects(&mut self, objects: Vec<ObjectId>) {
        let before = std::mem::take(&mut self.objects);
        let counts = |id: ObjectId| {
            let known = before.get(&id).copied();
            (id, known.unwrap_or(ObjectCount::UNSEEN))
        };
        self.objects = objects.into_iter().map(counts).collect();
    }

    /// Counts a pose that was published.
    pub fn count(&mut self, estimate: &ObjectEstimate) {
        self.note_state(estimate);
        if let Some(object) = self.objects.get_mut(&estimate.object) {
            object.poses += 1;
        }
    }

    /// Notes the state of an object whose pose another fusion node publishes.
    pub fn note_state(&mut self, estimate: &ObjectEstimate) {
        if let Some(object) = self.objects.get_mut(&estimate.object) {
            object.state = estimate.state;
        }
    }

    /// The clock of this host was set by so many ns, below zero where it was set back.
    pub fn clock_stepped(&mut self, by_ns: i64, now_ns: u64) {
        let by_s = by_ns as f64 * 1e-9;
        self.notices.add(Notice::ClockStepped { by_s }, now_ns);
    }

    /// The status at `now_ns`; rates are over the time since the last one.
    pub fn status(
        &mut self,
        intake: &mut Intake,
        machine: &Fusion,
        losses: Losses,
        now_ns: u64,
    ) -> FusionStatus {
        self.note_losses(losses, intake, now_ns);
        let elapsed_s = now_ns.saturating_sub(self.last_ns) as f64 / 1e9;
        self.last_ns = now_ns;
        let cameras = intake.cameras(elapsed_s).into_iter();
        let statistics = machine.statistics();
        let cameras = cameras.map(|camera| with_statistics(camera, &statistics));
        let cameras = cameras.collect();
        let mut faults = machine.faults();
        let recorded: Vec<CameraId> = intake.recorded_cameras().cloned().collect();
        faults.retain(|fault| !is_of_recording(fault, &recorded));
        let faults_left_out = faults.len().saturating_sub(limits::MAX_FAULTS);
        faults.truncate(limits::MAX_FAULTS);
        let imperfections = machine.imperfections();
        FusionStatus {
            node: self.node.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_s: now_ns.saturating_sub(self.started_ns) / 1_000_000_000,
            epoch: self.epoch,
            cameras,
            foreign: intake.foreign(),
            objects: self
                .objects
                .iter_mut()
                .map(|(id, object)| object.health(id, elapsed_s))
                .collect(),
            faults,
            faults_left_out: u32::try_from(faults_left_out).unwrap_or(u32::MAX),
            imperfections: (imperfections.iter())
                .take(limits::MAX_IMPERFECTIONS)
                .cloned()
                .collect(),
            notices: self.all_notices(intake, now_ns),
        }
    }
}

impl StatusReporter {
    /// What was dropped, and why. While the node is late itself, so is all that it reads, whoever sent it.
    fn note_losses(&mut self, losses: Losses, intake: &Intake, now_ns: u64) {
        self.late_here = self.late_here.saturating_add(intake.late_here());
        let lost = |losses: &Losses| losses.unread + losses.held_up;
        let late_here = intake.late_here();
        let dropped = lost(&losses) - lost(&self.losses) + late_here;
        if dropped > 0 {
            let total = lost(&losses) + self.late_here;
            self.notices.drop_late();
            self.notices
                .add(Notice::Overload { dropped, total }, now_ns);
        } else if !self.notices.has_overload(now_ns) {
            for late in intake.late_cameras() {
                self.notices.add(late, now_ns);
            }
        }
        let Unpublished { messages, cause } = &losses.unpublished;
        if *messages > self.losses.unpublished.messages {
            let unpublished = Notice::Unpublished {
                total: *messages,
                detail: detail(cause),
            };
            self.notices.add(unpublished, now_ns);
        }
        self.losses = losses;
    }

    /// Everything to be shown, the most urgent first.
    fn all_notices(&mut self, intake: &Intake, now_ns: u64) -> Vec<Notice> {
        let namesakes = self.namesakes.iter().map(|host| Notice::NameTaken {
            host: limits::clipped(host, limits::MAX_NAME_BYTES),
        });
        let mut notices: Vec<Notice> = namesakes.take(1).collect();
        notices.extend(self.models.iter().cloned());
        notices.extend(self.notices.notices(now_ns));
        notices.extend(self.refusals.notices(now_ns));
        notices.extend(self.proposed.as_ref().map(proposing::notice));
        notices.extend(intake.silent_cameras());
        notices.truncate(limits::MAX_NOTICES);
        notices
    }
}

/// Whether a fault is about the clock of images that were taken long ago: played again, they have the stamps of then.
fn is_of_recording(fault: &Fault, recorded: &[CameraId]) -> bool {
    match fault {
        Fault::HostClockOff { .. } => !recorded.is_empty(),
        Fault::ClockOff { camera, .. } | Fault::Untimely { camera, .. } => {
            recorded.contains(camera)
        }
        _ => false,
    }
}

impl ObjectCount {
    const UNSEEN: Self = Self {
        state: State::Lost,
        poses: 0,
    };

    fn health(&mut self, id: &ObjectId, elapsed_s: f64) -> ObjectHealth {
        let poses = std::mem::take(&mut self.poses);
        let rate_hz = if elapsed_s > 0.0 {
            (poses as f64 / elapsed_s) as f32
        } else {
            0.0
        };
        ObjectHealth {
            object: id.clone(),
            state: self.state,
            rate_hz,
        }
    }
}

/// Adds what the estimator counted of a camera to what the intake counted.
fn with_statistics(mut camera: CameraIntake, statistics: &Statistics) -> CameraIntake {
    if let Some(counts) = statistics.cameras.get(&camera.camera) {
        camera.unknown_tags = counts.unknown_tags;
        camera.late = camera.late.saturating_add(counts.late);
        camera.gated = counts.gated_tags;
        camera.last_capture_ns = counts.last_capture_ns;
    }
    camera
}
