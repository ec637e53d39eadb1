//! A fusion node's process in simulated time: [`FusionCore`] with queues, a disk and a clock as `node_fusion::run`
//! gives it.

use crate::disk::Disk;
use crate::host::ProcessClock;
use crate::plan::{MS, S};
use node_fusion::{
    Action, Environment, FusionConfig, FusionCore, HostState, InitialState, KeepJob, MOST_REQUESTS,
    Payloads, Publication, Put,
};
use sextant_election::{Link, Moment};
use sextant_estimator::SolverTask;
use sextant_process::ClockQuality;
use sextant_proto::NodeId;
use sextant_zenoh_bus::{Item, Presence};
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

/// As the node's: observations and heartbeats that wait, and the longest sleep.
const OBSERVATIONS: usize = 2048;
const HEARTBEATS: usize = 3840;
const LONGEST_WAIT_NS: u64 = 100 * MS;
/// How long another fusion node may take to hand over its models.
const MODELS_WAIT_NS: u64 = 3 * S;
/// What a turn takes, and an image.
const TURN_NS: u64 = 20_000;
const IMAGE_NS: u64 = 300_000;
/// What an adjustment takes in its thread.
const ADJUSTMENT_NS: u64 = 200 * MS;

/// What a node does, as it does it.
pub enum Step<'a> {
    /// It reads a heartbeat of another node.
    Reads(&'a Item),
    /// It publishes a message.
    Publishes(&'a Put, &'a FusionCore, &'a Disk),
}

/// Sees every step of a node.
pub type Observer<'a> = dyn FnMut(Step<'_>) + 'a;

/// What a process does to others.
#[derive(Debug)]
pub enum Effect {
    /// Publishes a message.
    Publish(Put),
    /// Asks a node for its models.
    Ask(NodeId),
}

/// Conditions at the beginning of a turn.
#[derive(Debug, Clone, Copy)]
pub struct Conditions {
    /// True time.
    pub at_ns: u64,
    /// The wall clock.
    pub wall_ns: u64,
    /// Whether a router answers.
    pub is_linked: bool,
    /// Time that writing a file takes; none where it fails.
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

/// Files that are being written.
struct Writing {
    job: KeepJob,
    begun_ns: u64,
    done_ns: u64,
    succeeds: bool,
}

/// The process.
pub struct Process {
    /// The node.
    pub core: FusionCore,
    host: ProcessState,
    busy_until_ns: u64,
}

/// The process around the node.
struct ProcessState {
    clock: ProcessClock,
    observations: VecDeque<(u64, Item)>,
    heartbeats: VecDeque<Item>,
    changes: VecDeque<Item>,
    presence: VecDeque<Presence>,
    unread: u64,
    max_age_ns: u64,
    writing: Option<Writing>,
    question: Option<Question>,
    solving: Option<(SolverTask, u64)>,
    /// The models of this node, for other fusion nodes, and their root.
    shelf: Option<(String, Payloads)>,
    /// What those who join late get.
    kept: BTreeMap<String, Item>,
}

/// The process during a turn.
struct Turn<'a> {
    host: &'a mut ProcessState,
    conditions: Conditions,
    /// True time, which goes on as work is done.
    now_ns: u64,
    disk: &'a mut Disk,
    observer: &'a mut Observer<'a>,
    effects: Vec<(u64, Effect)>,
}

impl Process {
    /// Starts from what is on the disk.
    ///
    /// # Panics
    /// If the estimator refuses the models.
    #[must_use]
    pub fn start(
        config: &FusionConfig,
        disk: &mut Disk,
        others: Vec<NodeId>,
        at: Conditions,
    ) -> Self {
        disk.complete_interrupted();
        let clock = ProcessClock::new(at.wall_ns, at.at_ns);
        let initial = InitialState {
            models: disk.models.clone(),
            formers: Default::default(),
            record: disk.record.clone().filter(|_| config.keep_changes),
            unwritten: Vec::new(),
            others,
            clock: ClockQuality::default(),
        };
        let now = clock.moment(at.at_ns);
        let core = FusionCore::new(config, initial, now).expect("models that were in force");
        let host = ProcessState {
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
            kept: BTreeMap::new(),
        };
        Self {
            core,
            host,
            busy_until_ns: at.at_ns,
        }
    }

    /// An observation of a camera arrives; when the process wakes for it.
    pub fn observation(&mut self, item: Item, at_ns: u64) -> u64 {
        self.core.arrivals().count(&item.key);
        self.host.observations.push_back((at_ns, item));
        if self.host.observations.len() > OBSERVATIONS {
            self.host.observations.pop_front();
            self.host.unread += 1;
        }
        self.busy_until_ns.max(at_ns)
    }

    /// A heartbeat arrives.
    pub fn heartbeat(&mut self, item: Item) {
        self.host.heartbeats.push_back(item);
        self.host
            .heartbeats
            .drain(..self.host.heartbeats.len().saturating_sub(HEARTBEATS));
    }

    /// A message under a key of the configuration arrives.
    pub fn change(&mut self, item: Item) {
        self.host.changes.push_back(item);
        self.host
            .changes
            .drain(..self.host.changes.len().saturating_sub(MOST_REQUESTS));
    }

    /// A token appears or is gone.
    pub fn presence(&mut self, change: Presence) {
        self.host.presence.push_back(change);
    }

    /// The models of a node that was asked arrive.
    pub fn answered(&mut self, node: &NodeId, items: Vec<Item>) {
        if let Some(question) = &mut self.host.question
            && question.node == *node
        {
            question.answers = Some(items);
        }
    }

    /// The models of this node, for other fusion nodes, and their root.
    #[must_use]
    pub fn shelf(&self) -> Option<&(String, Payloads)> {
        self.host.shelf.as_ref()
    }

    /// What those who join late get.
    pub fn kept(&self) -> impl Iterator<Item = &Item> {
        self.host.kept.values()
    }

    /// A turn; its effects with their times, and when the next is due.
    pub fn turn<'a>(
        &'a mut self,
        conditions: Conditions,
        disk: &'a mut Disk,
        observer: &'a mut Observer<'a>,
    ) -> (Vec<(u64, Effect)>, u64) {
        self.host.solve_what_is_due(conditions.at_ns);
        let mut turn = Turn {
            host: &mut self.host,
            conditions,
            now_ns: conditions.at_ns,
            disk,
            observer,
            effects: Vec::new(),
        };
        let Ok(()) = self.core.turn(&mut turn);
        let (effects, ends_ns) = (turn.effects, turn.now_ns + TURN_NS);
        self.busy_until_ns = ends_ns;
        let waits = self.host.observations.is_empty();
        let now = self.host.clock.moment(ends_ns);
        let wait_ns = self.core.poll_timeout(now).saturating_sub(now.monotonic_ns);
        let wait_ns = if waits {
            wait_ns.clamp(100_000, LONGEST_WAIT_NS)
        } else {
            0
        };
        (effects, ends_ns + wait_ns)
    }

    /// The process is killed: what of a job was written stays.
    pub fn kill(self, at_ns: u64, disk: &mut Disk) {
        if let Some(writing) = self.host.writing.filter(|writing| writing.succeeds) {
            let (done_ns, whole_ns) =
                (at_ns - writing.begun_ns, writing.done_ns - writing.begun_ns);
            let share = done_ns as f64 / whole_ns.max(1) as f64;
            let n_written = (share * Disk::steps(&writing.job) as f64) as usize;
            disk.write(&writing.job, n_written);
        }
    }
}

impl ProcessState {
    fn solve_what_is_due(&mut self, at_ns: u64) {
        let is_due = |(_, due_ns): &mut (SolverTask, u64)| *due_ns <= at_ns;
        if let Some((task, _)) = self.solving.take_if(is_due) {
            task.solve();
        }
    }
}

impl Environment for Turn<'_> {
    type Error = Infallible;

    fn now(&self) -> Moment {
        self.host.clock.moment(self.now_ns)
    }

    fn take_clock_step(&mut self) -> Option<i64> {
        let Conditions { wall_ns, at_ns, .. } = self.conditions;
        self.host.clock.take_step(wall_ns, at_ns)
    }

    fn link(&self) -> Link {
        match self.conditions.is_linked {
            true => Link::Up,
            false => Link::Down,
        }
    }

    fn next_presence(&mut self) -> Option<Presence> {
        self.host.presence.pop_front()
    }

    fn next_heartbeat(&mut self) -> Option<Item> {
        let heartbeat = self.host.heartbeats.pop_front()?;
        (self.observer)(Step::Reads(&heartbeat));
        Some(heartbeat)
    }

    fn next_observation(&mut self) -> Option<Item> {
        while let Some((arrived_ns, item)) = self.host.observations.pop_front() {
            if self.conditions.at_ns - arrived_ns <= self.host.max_age_ns {
                self.now_ns += IMAGE_NS + self.conditions.overload_ns;
                return Some(item);
            }
            self.host.unread += 1;
        }
        None
    }

    fn next_request(&mut self) -> Option<Item> {
        self.host.changes.pop_front()
    }

    fn kept(&mut self) -> Option<Result<(), String>> {
        let is_done = |writing: &mut Writing| writing.done_ns <= self.now_ns;
        let Writing { job, succeeds, .. } = self.host.writing.take_if(is_done)?;
        if !succeeds {
            return Some(Err("no space left on device".to_owned()));
        }
        self.disk.write(&job, Disk::steps(&job));
        Some(Ok(()))
    }

    fn answers(&mut self) -> Option<(NodeId, Vec<Item>)> {
        let is_over =
            |question: &mut Question| question.answers.is_some() || question.due_ns <= self.now_ns;
        let Question { node, answers, .. } = self.host.question.take_if(is_over)?;
        Some((node, answers.unwrap_or_default()))
    }

    fn host(&mut self) -> HostState {
        HostState {
            unread: self.host.unread,
            ..HostState::default()
        }
    }

    fn act(&mut self, action: Action, core: &FusionCore) -> Result<(), Infallible> {
        match action {
            Action::Publish(Publication::Message(put)) => {
                (self.observer)(Step::Publishes(&put, core, self.disk));
                if put.is_kept {
                    self.host.kept.insert(put.key.clone(), item_of(&put));
                }
                self.effects.push((self.now_ns, Effect::Publish(put)));
            }
            Action::Publish(Publication::Models(root, payloads)) => {
                self.host.shelf = Some((root, payloads));
            }
            Action::Publish(Publication::Withdrawal(key)) => {
                self.host.kept.remove(&key);
            }
            Action::Keep(job) => {
                let (begun_ns, n_files) = (self.now_ns, Disk::steps(&job) as u64);
                self.host.writing = Some(Writing {
                    job,
                    begun_ns,
                    done_ns: begun_ns + n_files * self.conditions.disk_ns.unwrap_or(MS),
                    succeeds: self.conditions.disk_ns.is_some(),
                });
            }
            Action::Ask(_) if self.host.question.is_some() => {}
            Action::Ask(node) => {
                self.host.question = Some(Question {
                    node: node.clone(),
                    due_ns: self.now_ns + MODELS_WAIT_NS,
                    answers: None,
                });
                self.effects.push((self.now_ns, Effect::Ask(node)));
            }
        }
        Ok(())
    }

    fn solve(&mut self, task: &SolverTask) {
        let due_ns = self.now_ns + ADJUSTMENT_NS;
        self.host
            .solving
            .get_or_insert_with(|| (task.clone(), due_ns));
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
