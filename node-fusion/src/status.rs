//! What a fusion node says about itself once a second: what came in, what was dropped and why, how the objects fare, what
//! is wrong with the site and which changes of it were refused.

use crate::intake::Intake;
use crate::notices::{Kind, Notices};
use crate::outlet::Unpublished;
use crate::proposing;
use crate::refusals::Refusals;
use sextant_estimator::{
    Fault, Fusion, HeldBack, ObjectEstimate, ObjectId, ObjectModel, State, Statistics,
};
use sextant_proto::{CameraIntake, FusionStatus, NodeId, ObjectHealth, limits};
use std::collections::BTreeMap;

/// Collects between two statuses.
#[derive(Debug)]
pub struct StatusBook {
    node: NodeId,
    started_ns: u64,
    last_ns: u64,
    objects: BTreeMap<ObjectId, ObjectCount>,
    /// Changes that were refused of late.
    pub refusals: Refusals,
    /// Hosts of other fusion nodes of the same name.
    pub namesakes: Vec<String>,
    /// What a refined calibration is worth that may be put in force.
    pub proposed: Option<HeldBack>,
    notices: Notices,
    /// What was lost until the last status.
    losses: Losses,
}

/// What was lost since the process started.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Losses {
    /// Observations dropped unread.
    pub unread: u64,
    /// Messages that could not be published.
    pub unpublished: Unpublished,
}

#[derive(Debug, Clone, Copy)]
struct ObjectCount {
    state: State,
    poses: u64,
}

impl StatusBook {
    /// A book that begins at `now_ns`, by the monotonic clock as all times here; every object is lost until it is seen.
    #[must_use]
    pub fn new(node: NodeId, objects: &[ObjectModel], now_ns: u64) -> Self {
        let mut book = Self {
            node,
            started_ns: now_ns,
            last_ns: now_ns,
            objects: BTreeMap::new(),
            refusals: Refusals::default(),
            namesakes: Vec::new(),
            proposed: None,
            notices: Notices::default(),
            losses: Losses::default(),
        };
        book.take_objects(objects);
        book
    }

    /// The site has other objects now; those that stay keep their state.
    pub fn take_objects(&mut self, objects: &[ObjectModel]) {
        let before = std::mem::take(&mut self.objects);
        let counts = |object: &ObjectModel| {
            let known = before.get(object.id()).copied();
            (object.id().clone(), known.unwrap_or(ObjectCount::UNSEEN))
        };
        self.objects = objects.iter().map(counts).collect();
    }

    /// Counts a pose that was published.
    pub fn count(&mut self, estimate: &ObjectEstimate) {
        if let Some(object) = self.objects.get_mut(&estimate.object) {
            object.state = estimate.state;
            object.poses += 1;
        }
    }

    /// The clock of this host was set forward by so many ns, or back.
    pub fn clock_stepped(&mut self, by_ns: i64, now_ns: u64) {
        let way = if by_ns < 0 { "back" } else { "forward" };
        let seconds = by_ns.unsigned_abs() as f64 * 1e-9;
        let words = format!(
            "the clock of this machine was set {way} by {seconds:.3} s: tracking starts anew"
        );
        self.notices.give(Kind::ClockStep, words, now_ns);
    }

    /// The status at `now_ns`; rates are over the time since the last one.
    pub fn status(
        &mut self,
        intake: &mut Intake,
        machine: &Fusion,
        losses: Losses,
        now_ns: u64,
    ) -> FusionStatus {
        if let Some(words) = intake.too_old() {
            self.notices.give(Kind::TooOld, words, now_ns);
        }
        self.note_losses(losses, now_ns);
        let elapsed_s = now_ns.saturating_sub(self.last_ns) as f64 / 1e9;
        self.last_ns = now_ns;
        let cameras = intake.cameras(elapsed_s).into_iter();
        let cameras = cameras.map(|camera| with_statistics(camera, machine.statistics()));
        let cameras = cameras.collect();
        let mut others = self.others(intake, now_ns);
        let imperfections = machine.imperfections().iter().map(ToString::to_string);
        others.extend(imperfections.take(limits::MAX_SENTENCES / 4));
        others.extend(self.proposed.as_ref().map(proposing::sentence));
        FusionStatus {
            node: self.node.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_s: now_ns.saturating_sub(self.started_ns) / 1_000_000_000,
            cameras,
            foreign: intake.foreign(),
            objects: self
                .objects
                .iter_mut()
                .map(|(id, object)| object.health(id, elapsed_s))
                .collect(),
            faults: sentences(&machine.faults(), others),
        }
    }
}

impl StatusBook {
    fn note_losses(&mut self, losses: Losses, now_ns: u64) {
        let unread = losses.unread - self.losses.unread;
        if unread > 0 {
            let words = format!(
                "overload: {unread} observations dropped unread ({} since the start). Fewer images a second, fewer cameras or a faster machine help",
                losses.unread
            );
            self.notices.give(Kind::Overload, words, now_ns);
        }
        let Unpublished { messages, cause } = &losses.unpublished;
        if *messages > self.losses.unpublished.messages {
            let words = format!("{messages} messages could not be published, last: {cause}");
            self.notices.give(Kind::Unpublished, words, now_ns);
        }
        self.losses = losses;
    }

    /// Cameras that fell silent, at most half of the sentences, what happened to this node, and changes that were refused.
    fn others(&mut self, intake: &Intake, now_ns: u64) -> Vec<String> {
        let mut words = intake.silences();
        words.truncate(limits::MAX_SENTENCES / 2);
        words.extend(self.notices.sentences(now_ns));
        words.extend(self.refusals.sentences(now_ns));
        if !self.namesakes.is_empty() {
            let (node, hosts) = (&self.node, self.namesakes.join(", "));
            words.push(format!(
                "fusion node {node} also runs on host {hosts}: end one of them"
            ));
        }
        words
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

/// What is wrong with the site and what else there is to say, in as many sentences as a status may have; the last of the first
/// counts those left out.
fn sentences(faults: &[Fault], others: Vec<String>) -> Vec<String> {
    let room = limits::MAX_SENTENCES.saturating_sub(others.len());
    let left_out = faults.len().saturating_sub(room);
    let shown = faults.len().min(room) - usize::from(left_out > 0 && room > 0);
    let mut sentences: Vec<String> = faults[..shown].iter().map(Fault::to_string).collect();
    if left_out > 0 {
        sentences.push(format!("and {} faults more", faults.len() - shown));
    }
    sentences.extend(others);
    sentences
        .iter()
        .map(|sentence| limits::clipped(sentence, limits::MAX_SENTENCE_BYTES))
        .collect()
}

/// What the estimator counted of a camera joins what the intake counted.
fn with_statistics(mut camera: CameraIntake, statistics: &Statistics) -> CameraIntake {
    if let Some(counts) = statistics.cameras.get(&camera.camera) {
        camera.unknown_tags = counts.unknown_tags;
        camera.late = camera.late.saturating_add(counts.late);
        camera.gated = counts.gated_tags;
        camera.last_capture_ns = counts.last_capture_ns;
    }
    camera
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_estimator::CameraId;

    fn moved(n: usize) -> Vec<Fault> {
        let camera = |k: usize| CameraId::new(&format!("camera{k}")).unwrap();
        (0..n)
            .map(|k| Fault::CameraMoved { camera: camera(k) })
            .collect()
    }

    #[test]
    fn every_fault_is_told_or_counted() {
        const MOST: usize = limits::MAX_SENTENCES;
        assert!(sentences(&[], vec![]).is_empty());
        assert_eq!(sentences(&moved(MOST), vec![]).len(), MOST);
        let many = sentences(&moved(MOST + 3), vec![]);
        assert_eq!(many.len(), MOST);
        assert_eq!(many.last().map(String::as_str), Some("and 4 faults more"));
        let both = sentences(&moved(MOST), vec!["refused".to_owned()]);
        assert_eq!(both.len(), MOST);
        assert_eq!(both[MOST - 2..], ["and 2 faults more", "refused"]);
    }
}
