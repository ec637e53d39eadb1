//! A fusion node's process in simulated time: [`FusionCore`] with queues, a disk and a clock as `node_fusion::run` gives it.

use crate::disk::Disk;
use crate::host::ProcessClock;
use crate::plan::{MS, S};
use node_fusion::{
    Action, FusionConfig, FusionCore, HostState, InitialState, KeepJob, Payloads, Publication, Put,
};
use sextant_election::{Link, Moment};
use sextant_estimator::AdjustmentTask;
use sextant_process::ClockQuality;
use sextant_proto::NodeId;
use sextant_zenoh_bus::{Item, Presence};
use std::collections::VecDeque;
use std::sync::Arc;

/// As the node's: observations, heartbeats and changes that wait, the longest wait of an observation, and the longest sleep.
const OBSERVATIONS: usize = 2048;
const HEARTBEATS: usize = 3840;
const CHANGES: usize = 256;
const LONGEST_WAIT_NS: u64 = 100 * MS;
/// How long another fusion node may take to hand over its models.
const MODELS_WAIT_NS: u64 = 3 * S;
/// What a turn takes, and an image.
const TURN_NS: u64 = 20_000;
const IMAGE_NS: u64 = 300_000;
/// What an adjustment takes in its thread.
const ADJUSTMENT_NS: u64 = 200 * MS;

/// Sees everything that a node publishes, at that moment.
pub type Observer<'a> = dyn FnMut(&Put, &FusionCore, &Disk) + 'a;

/// What the world has to do for a process.
#[derive(Debug)]
pub enum Effect {
    /// Deliver it to its subscribers.
    Publish(Put),
    /// Ask a node for its models.
    Ask(NodeId),
}

/// What a process meets in a turn.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    /// True time.
    pub at_ns: u64,
    /// The wall clock.
    pub wall_ns: u64,
    /// Whether a router answers.
    pub is_linked: bool,
    /// Until when writing a file that begins now takes; none where it fails.
    pub disk_ns: Option<u64>,
    /// What an image takes beyond the usual.
    pub overload_ns: u64,
}

/// Another node is asked for its models.
struct Question {
    node: NodeId,
    /// Until when it is waited for.
    due_ns: u64,
    answers: Option<Vec<Item>>,
}

/// The process.
pub struct Process {
    /// The node.
    pub core: FusionCore,
    clock: ProcessClock,
    observations: VecDeque<(u64, Item)>,
    heartbeats: VecDeque<Item>,
    changes: VecDeque<Item>,
    presence: VecDeque<Presence>,
    unread: u64,
    max_age_ns: u64,
    /// A job that is being written, when it is done, and whether it succeeds.
    writing: Option<(KeepJob, u64, u64, bool)>,
    question: Option<Question>,
    solving: Option<(Arc<AdjustmentTask>, u64)>,
    /// The models of this node, for other fusion nodes, and their root.
    pub shelf: Option<(String, Payloads)>,
    busy_until_ns: u64,
}

impl Process {
    /// Starts from what is on the disk.
    ///
    /// # Panics
    /// If the estimator refuses the models.
    #[must_use]
    pub fn start(
        config: &FusionConfig,
        disk: &Disk,
        others: Vec<NodeId>,
        at: Surroundings,
    ) -> Self {
        let clock = ProcessClock::new(at.wall_ns, at.at_ns);
        let initial = InitialState {
            models: disk.models.clone(),
            formers: Default::default(),
            record: disk.record.clone().filter(|_| config.keep_changes),
            others,
            clock: ClockQuality::default(),
        };
        let now = clock.moment(at.at_ns);
        let core = FusionCore::new(config, initial, now).expect("models that were in force");
        Self {
            core,
            clock,
            observations: VecDeque::new(),
            heartbeats: VecDeque::new(),
            changes: VecDeque::new(),
            presence: VecDeque::new(),
            unread: 0,
            max_age_ns: (config.max_age_s * 1e9) as u64,
            writing: None,
            question: None,
            solving: None,
            shelf: None,
            busy_until_ns: at.at_ns,
        }
    }

    /// An observation of a camera arrives; when the process wakes for it.
    pub fn observation(&mut self, item: Item, at_ns: u64) -> u64 {
        self.core.arrivals().count(&item.key);
        self.observations.push_back((at_ns, item));
        if self.observations.len() > OBSERVATIONS {
            self.observations.pop_front();
            self.unread += 1;
        }
        self.busy_until_ns.max(at_ns)
    }

    /// A heartbeat arrives.
    pub fn heartbeat(&mut self, item: Item) {
        self.heartbeats.push_back(item);
        self.heartbeats
            .drain(..self.heartbeats.len().saturating_sub(HEARTBEATS));
    }

    /// A message under a key of the configuration arrives.
    pub fn change(&mut self, item: Item) {
        self.changes.push_back(item);
        self.changes
            .drain(..self.changes.len().saturating_sub(CHANGES));
    }

    /// A token appears or is gone.
    pub fn presence(&mut self, change: Presence) {
        self.presence.push_back(change);
    }

    /// The models of a node that was asked arrive.
    pub fn answered(&mut self, node: &NodeId, items: Vec<Item>) {
        if let Some(question) = &mut self.question
            && question.node == *node
        {
            question.answers = Some(items);
        }
    }

    /// Now, by the clocks of the process.
    #[must_use]
    pub fn now(&self, at_ns: u64) -> Moment {
        self.clock.moment(at_ns)
    }

    /// A turn; what is effects of the world, and when the next is due.
    pub fn turn(
        &mut self,
        at: Surroundings,
        disk: &mut Disk,
        observer: &mut Observer<'_>,
    ) -> (Vec<Effect>, u64) {
        let mut effects = Vec::new();
        let item = self.next_observation(at.at_ns);
        let stepped = self.clock.take_step(at.wall_ns, at.at_ns);
        let now = self.now(at.at_ns);
        if let Some(by_ns) = stepped {
            self.core.clock_stepped(by_ns, now);
        }
        let link = match at.is_linked {
            true => Link::Up,
            false => Link::Down,
        };
        self.core.link(link, now);
        for change in self.presence.drain(..) {
            self.core.presence(&change, now);
        }
        for item in self.heartbeats.drain(..) {
            self.core.heartbeat(&item, now);
        }
        self.core.update_duty(now);
        self.act(now, at, disk, observer, &mut effects);
        let mut ends_ns = at.at_ns + TURN_NS;
        if let Some(item) = item {
            self.core.observation(&item, now);
            ends_ns += IMAGE_NS + at.overload_ns;
        }
        let ended = self.now(ends_ns);
        self.act(ended, at, disk, observer, &mut effects);
        self.update_models(ended, at, disk, observer, &mut effects);
        if self
            .solving
            .as_ref()
            .is_some_and(|(_, due_ns)| *due_ns <= at.at_ns)
            && let Some((task, _)) = self.solving.take()
        {
            task.solve();
        }
        self.core.tick(ended);
        if self.core.is_report_due(ended) {
            let host = HostState {
                clock: ClockQuality::default(),
                namesakes: Vec::new(),
                unread: self.unread,
            };
            self.core.report(host, ended);
        }
        self.act(ended, at, disk, observer, &mut effects);
        if let Some(task) = self.core.adjustment()
            && self.solving.is_none()
        {
            self.solving = Some((task.clone(), ends_ns + ADJUSTMENT_NS));
        }
        self.busy_until_ns = ends_ns;
        (effects, self.next_turn_ns(ended, ends_ns))
    }

    fn next_observation(&mut self, at_ns: u64) -> Option<Item> {
        while let Some((arrived_ns, item)) = self.observations.pop_front() {
            if at_ns - arrived_ns <= self.max_age_ns {
                return Some(item);
            }
            self.unread += 1;
        }
        None
    }

    fn next_turn_ns(&self, now: Moment, ends_ns: u64) -> u64 {
        if !self.observations.is_empty() {
            return ends_ns;
        }
        let wait_ns = self.core.poll_timeout(now).saturating_sub(now.monotonic_ns);
        ends_ns + wait_ns.clamp(100_000, LONGEST_WAIT_NS)
    }

    fn update_models(
        &mut self,
        now: Moment,
        at: Surroundings,
        disk: &mut Disk,
        observer: &mut Observer<'_>,
        effects: &mut Vec<Effect>,
    ) {
        if self
            .writing
            .as_ref()
            .is_some_and(|(_, _, done_ns, _)| *done_ns <= at.at_ns)
            && let Some((job, _, _, succeeds)) = self.writing.take()
        {
            let outcome = match succeeds {
                true => {
                    disk.write(&job, Disk::steps(&job));
                    Ok(())
                }
                false => Err("no space left on device".to_owned()),
            };
            self.core.kept(outcome, now);
        }
        let is_over =
            |question: &Question| question.answers.is_some() || question.due_ns <= at.at_ns;
        if self.question.as_ref().is_some_and(is_over)
            && let Some(Question { node, answers, .. }) = self.question.take()
        {
            self.core.follow(&node, &answers.unwrap_or_default(), now);
        }
        for _ in 0..CHANGES {
            if !self.core.takes_requests(now) {
                break;
            }
            let Some(item) = self.changes.pop_front() else {
                break;
            };
            self.core.config(&item, now);
            self.act(now, at, disk, observer, effects);
        }
    }

    fn act(
        &mut self,
        now: Moment,
        at: Surroundings,
        disk: &Disk,
        observer: &mut Observer<'_>,
        effects: &mut Vec<Effect>,
    ) {
        while let Some(action) = self.core.poll(now) {
            match action {
                Action::Publish(Publication::Message(put)) => {
                    observer(&put, &self.core, disk);
                    effects.push(Effect::Publish(put));
                }
                Action::Publish(Publication::Models(root, payloads)) => {
                    self.shelf = Some((root, payloads))
                }
                // Late joiners are not simulated.
                Action::Publish(Publication::Withdrawal(_)) => {}
                Action::Keep(job) => {
                    let steps = Disk::steps(&job) as u64;
                    let (each_ns, succeeds) = match at.disk_ns {
                        Some(each_ns) => (each_ns, true),
                        None => (MS, false),
                    };
                    self.writing = Some((job, at.at_ns, at.at_ns + steps * each_ns, succeeds));
                }
                Action::Ask(_) if self.question.is_some() => {}
                Action::Ask(node) => {
                    self.question = Some(Question {
                        node: node.clone(),
                        due_ns: at.at_ns + MODELS_WAIT_NS,
                        answers: None,
                    });
                    effects.push(Effect::Ask(node));
                }
            }
        }
    }

    /// The process is killed: what of a job was written stays.
    pub fn kill(self, at_ns: u64, disk: &mut Disk) {
        if let Some((job, begun_ns, done_ns, true)) = self.writing {
            let share = (at_ns - begun_ns) as f64 / (done_ns - begun_ns).max(1) as f64;
            let n_written = (share * Disk::steps(&job) as f64) as usize;
            disk.write(&job, n_written);
        }
    }
}

/// A message as those receive it who subscribe to it.
#[must_use]
pub fn item_of(put: &Put) -> Item {
    Item {
        key: put.key.clone(),
        payload: sextant_zenoh_bus::Payload::Bytes(put.payload.clone()),
        sender: put.sender.clone(),
    }
}
