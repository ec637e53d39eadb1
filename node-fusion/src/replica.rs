//! This node's replica of the site's models. The node that publishes the poses decides about changes, the others follow
//! it, and the newest version wins wherever it comes from.
//!
//! Input: requests, heartbeats of other nodes, their models, and what became of writing files. Output: [`Effect`]s.
//! Knows no network, no file and no clock.

mod own_changes;

use crate::formers::Formers;
use crate::models::{Change, ModelsInForce, Payloads};
use crate::pace::Pace;
use crate::refusals::detail;
use own_changes::OwnChanges;
pub use own_changes::SetAside;
use sextant_election::{Link, Moment};
use sextant_proto::{
    ChangeOutcome, ConfigAnswer, KeyRef, ModelsState, ModelsVersion, NodeId, Refusal, limits,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

const MS: u64 = 1_000_000;
/// A node counts as present for so long after its last heartbeat, ns.
const PRESENT_NS: u64 = 1000 * MS;
/// A node that has not reported its models is waited for so long after it has come or gone, ns: its process may stand
/// still.
const PAUSE_NS: u64 = 5000 * MS;
/// A node is forgotten after so long without a heartbeat, ns.
const FORGOTTEN_NS: u64 = 5000 * MS;
/// For so long newer models are asked for before a change is decided on without them, ns.
const FETCHED_NS: u64 = 5000 * MS;
/// How long other nodes may take to follow before a change is answered, ns.
const FOLLOWED_NS: u64 = 1000 * MS;
/// A node whose models are old is asked about after so long, ns: until then it is following.
const BEHIND_NS: u64 = 2000 * MS;
/// Nodes that were known before the own link was lost are waited for so long after it is back, ns.
const REJOIN_NS: u64 = 500 * MS;
/// A node that knows of newer models for so long writes down that it does, ns: until then it takes them over.
const NOTED_NS: u64 = 100 * MS;
/// A node that should publish and has no current models for so long publishes what it tracks as lost, ns.
const LOST_NS: u64 = 500 * MS;
/// Between two questions for newer models, ns.
const QUESTION_NS: u64 = 500 * MS;
/// Between two attempts to write what is in force, ns.
const RETRY_NS: u64 = 10_000 * MS;

/// What the node has to do.
#[derive(Debug, PartialEq)]
pub enum Effect {
    /// Work from the models of the replica, which these changes have made of the former ones.
    PutInForce(Vec<Change>),
    /// Write to the files, and tell the outcome to [`Replica::kept`].
    Keep(KeepJob),
    /// Ask a node for its models, and hand them to [`Replica::follow`].
    Ask(NodeId),
    /// Tell what became of a change.
    Answer(Answered),
}

/// What became of a change.
#[derive(Debug, PartialEq)]
pub struct Answered {
    /// As published, unless the node made the change by itself.
    pub answer: ConfigAnswer,
    /// Who asked for the change.
    pub origin: Origin,
}

/// Changes to be written, all or none.
#[derive(Debug, Clone, PartialEq)]
pub struct KeepJob {
    /// In this order.
    pub changes: Vec<Change>,
    /// Take back what was written before one failed, in this order. None where the changes are in force whether or not
    /// they can be written.
    pub undo: Vec<Change>,
    /// Which models the files hold then.
    pub record: ModelsRecord,
}

/// A version of the models, and the node that has it.
pub type HeldVersion = (ModelsVersion, NodeId);

/// What outlives a node beside its models.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ModelsRecord {
    /// Version and fingerprint of the models in the files.
    pub state: ModelsState,
    /// The newest version that the node knows of, where it could not get it.
    pub newer: Option<HeldVersion>,
}

/// Who asks for a change.
#[derive(Debug, Clone, PartialEq)]
pub enum Origin {
    /// A client on the network.
    Request {
        /// What the payload is about.
        about: KeyRef,
        /// Its sender, where it says.
        sender: Option<String>,
    },
    /// This node: a refinement.
    Own,
}

/// A change that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The key below the site.
    pub key: String,
    /// Of the payload.
    pub fingerprint: u64,
    /// Who asks.
    pub origin: Origin,
    /// All or none of them; or why the payload is no change.
    pub changes: Result<Vec<Change>, Refusal>,
}

/// Another fusion node, as last heard.
#[derive(Debug)]
struct Peer {
    heard_ns: u64,
    models: ModelsState,
    /// Since when its models are older than this node's.
    behind_since_ns: Option<u64>,
}

/// A change on its way.
#[derive(Debug)]
enum Step {
    /// It is being written.
    Keeping {
        request: Request,
        changes: Vec<Change>,
        after: ModelsInForce,
        version: ModelsVersion,
    },
    /// The others are taking it over.
    Spreading {
        answered: Answered,
        /// Who was there when it was made.
        others: Vec<NodeId>,
        due_ns: u64,
    },
}

/// What of the models in force is not in the files yet.
#[derive(Debug, Default)]
struct Backlog {
    changes: Vec<Change>,
    /// Whether the record of the version is to be written.
    is_record_old: bool,
    /// Of the changes, those that are being written.
    in_flight: Option<usize>,
    /// Not to be tried before, monotonic ns.
    due_ns: u64,
    /// Why the last attempt failed.
    cause: Option<String>,
    /// The newer version that the record names, or will.
    noted: Option<HeldVersion>,
}

/// The models and their version.
#[derive(Debug)]
pub struct Replica {
    node: NodeId,
    models: ModelsInForce,
    formers: Formers,
    payloads: Payloads,
    /// Version and fingerprint of these.
    state: ModelsState,
    /// Greatest counter known, of former versions of this node's files too.
    counter: u64,
    /// The newest version that a heartbeat has reported, also to an earlier process of this node.
    newest: Option<HeldVersion>,
    /// A version that this node cannot work from.
    unusable: Option<ModelsVersion>,
    peers: BTreeMap<NodeId, Peer>,
    /// Nodes that have not reported their models yet, and until when they are waited for, monotonic ns.
    unheard: BTreeMap<NodeId, u64>,
    /// Nodes that were heard since the start, but for those that have ended.
    known: BTreeSet<NodeId>,
    /// Whether the models were compared with those of all other nodes since the start, or since the link was lost.
    is_compared: bool,
    is_link_lost: bool,
    question_due_ns: u64,
    /// Since when newer models are known, monotonic ns.
    behind_since_ns: Option<u64>,
    /// Since when the models are not current, monotonic ns.
    outdated_since_ns: Option<u64>,
    own_changes: OwnChanges,
    /// What of them was set aside, until somebody decides anew.
    set_aside: Option<SetAside>,
    step: Option<Step>,
    /// None where changes are not kept.
    backlog: Option<Backlog>,
    pace: Pace,
    effects: VecDeque<Effect>,
}

impl Replica {
    /// Of models that were read from files, whose record says which version they were of. Changes outlive the process
    /// where `unwritten` says what of the models is not in the files.
    #[must_use]
    pub fn new(
        node: NodeId,
        models: ModelsInForce,
        formers: Formers,
        record: Option<ModelsRecord>,
        unwritten: Option<Vec<Change>>,
    ) -> Self {
        let payloads = Payloads::encode(&models);
        let ModelsRecord {
            state: record,
            newer: newest,
        } = record.unwrap_or_default();
        let versions = (record.version.iter()).chain(newest.iter().map(|(version, _)| version));
        let counter = versions.map(|version| version.counter).max();
        // Files that were edited since are of no version.
        let is_known = record.fingerprint == payloads.fingerprint();
        if let Some(version) = record.version.as_ref().filter(|_| !is_known) {
            let counter = version.counter;
            tracing::warn!(
                counter,
                "the rig, an object or the settings of a camera were edited \
                since this node wrote them: they count where no other fusion node runs"
            );
        }
        let backlog = unwritten.map(|changes| Backlog {
            changes,
            noted: newest.clone(),
            ..Backlog::default()
        });
        Self {
            node,
            formers,
            state: ModelsState {
                version: record.version.filter(|_| is_known),
                fingerprint: payloads.fingerprint(),
            },
            payloads,
            models,
            counter: counter.unwrap_or(0),
            newest,
            unusable: None,
            peers: BTreeMap::new(),
            unheard: BTreeMap::new(),
            known: BTreeSet::new(),
            is_compared: false,
            is_link_lost: false,
            question_due_ns: 0,
            behind_since_ns: None,
            outdated_since_ns: None,
            own_changes: OwnChanges::default(),
            set_aside: None,
            step: None,
            backlog,
            pace: Pace::default(),
            effects: VecDeque::new(),
        }
    }

    /// What is in force.
    #[must_use]
    pub fn models(&self) -> &ModelsInForce {
        &self.models
    }

    /// What was in force before.
    #[must_use]
    pub fn formers(&self) -> &Formers {
        &self.formers
    }

    /// The models as messages, for the other nodes.
    #[must_use]
    pub fn payloads(&self) -> &Payloads {
        &self.payloads
    }

    /// For this node's heartbeats.
    #[must_use]
    pub fn state(&self) -> &ModelsState {
        &self.state
    }

    /// The next thing to be done.
    pub fn poll(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// Whether poses may be published: no newer models are known, and the files that this node was started with were
    /// compared with what other nodes have.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.newer().is_none() && (self.is_compared || self.unheard.is_empty())
    }

    /// Whether the models have not been current for so long that whoever waits for poses has to know.
    #[must_use]
    pub fn is_stuck(&self, now: Moment) -> bool {
        let since_ns = self.outdated_since_ns;
        since_ns.is_some_and(|since_ns| now.monotonic_ns >= since_ns + LOST_NS)
    }

    /// What of this node's changes another one's have set aside, until somebody decides anew.
    #[must_use]
    pub fn set_aside(&self) -> Option<&SetAside> {
        self.set_aside.as_ref()
    }

    /// Whether a change may be decided on now. A node that can get newer models does that first.
    #[must_use]
    pub fn is_ready(&self, now: Moment) -> bool {
        let is_writing = (self.backlog.as_ref()).is_some_and(|backlog| backlog.in_flight.is_some());
        let is_recent = |since_ns: u64| now.monotonic_ns < since_ns + FETCHED_NS;
        let follows = self.newer().is_some_and(|(version, node)| {
            let is_usable = self.unusable.as_ref() != Some(version);
            is_usable && self.is_present(node, now) && self.behind_since_ns.is_none_or(is_recent)
        });
        self.step.is_none() && !is_writing && !follows && self.pace.is_due(now.monotonic_ns)
    }

    /// Whether a change is under way.
    #[must_use]
    pub fn is_deciding(&self) -> bool {
        self.step.is_some()
    }

    /// Which nodes have older models than others: this one, or present ones that do not follow.
    pub fn outdated(&self, now: Moment) -> impl Iterator<Item = (&NodeId, &NodeId)> {
        let own = self.newer().map(|(_, newer)| (&self.node, newer));
        let is_late = move |peer: &Peer| {
            peer.behind_since_ns
                .is_some_and(|since_ns| now.monotonic_ns >= since_ns + BEHIND_NS)
        };
        let late = self
            .peers
            .iter()
            .filter(move |(node, peer)| is_late(peer) && self.is_present(node, now));
        own.into_iter()
            .chain(late.map(|(node, _)| (node, &self.node)))
    }

    /// Why the models in force are not in the files, where they could not be written.
    #[must_use]
    pub fn not_kept(&self) -> Option<&str> {
        self.backlog.as_ref()?.cause.as_deref()
    }
}

/// Other nodes.
impl Replica {
    /// A fusion node is alive.
    pub fn joined(&mut self, node: NodeId, now: Moment) {
        if node != self.node
            && !self.peers.contains_key(&node)
            && self.unheard.len() < limits::MAX_PEERS
        {
            let until_ns = now.monotonic_ns + PAUSE_NS;
            self.unheard.entry(node).or_insert(until_ns);
        }
    }

    /// The state of the own link, whether or not it has changed. While it was lost the others may have changed the
    /// models: what was in force here is compared with theirs before anything is published by it.
    pub fn link(&mut self, link: Link, now: Moment) {
        let is_lost = link == Link::Down;
        if self.is_link_lost && !is_lost && !self.known.is_empty() {
            let until_ns = now.monotonic_ns + REJOIN_NS;
            let known = self.known.iter().cloned();
            self.unheard.extend(known.map(|node| (node, until_ns)));
            self.is_compared = false;
        }
        self.is_link_lost = is_lost;
    }

    /// A fusion node is not alive any more.
    pub fn left(&mut self, node: &NodeId, now: Moment) {
        if let Some(until_ns) = self.unheard.get_mut(node) {
            *until_ns = now.monotonic_ns + PAUSE_NS;
        }
        if !self.is_link_lost {
            self.known.remove(node);
        }
        self.peers.remove(node);
    }

    /// A heartbeat of another node.
    pub fn hear(&mut self, node: &NodeId, theirs: &ModelsState, now: Moment) {
        if *node == self.node {
            return;
        }
        self.unheard.remove(node);
        if self.known.len() < limits::MAX_PEERS && !self.known.contains(node) {
            self.known.insert(node.clone());
        }
        if self.peers.len() < limits::MAX_PEERS || self.peers.contains_key(node) {
            let since_ns = self.peers.get(node).and_then(|peer| peer.behind_since_ns);
            let is_behind = theirs.version < self.state.version;
            let peer = Peer {
                heard_ns: now.monotonic_ns,
                models: theirs.clone(),
                behind_since_ns: is_behind.then_some(since_ns.unwrap_or(now.monotonic_ns)),
            };
            self.peers.insert(node.clone(), peer);
        }
        self.forget_what_is_lost(node, theirs);
        let Some(version) = &theirs.version else {
            return;
        };
        if theirs.version == self.state.version {
            self.own_changes.shared_with(node);
        }
        self.counter = self.counter.max(version.counter);
        if theirs.version > self.state.version {
            let is_keeping = matches!(self.step, Some(Step::Keeping { .. }));
            match theirs.fingerprint == self.state.fingerprint && !is_keeping {
                true => self.adopt(version.clone()),
                false => self.note_newer(version, node, now),
            }
        }
    }

    /// A restarted node may have older models than before. The newer ones are no longer waited for, unless another node
    /// has them.
    fn forget_what_is_lost(&mut self, node: &NodeId, theirs: &ModelsState) {
        let is_lost = |(version, holder): &HeldVersion| {
            holder == node && theirs.version.as_ref() < Some(version)
        };
        if self.newest.as_ref().is_some_and(is_lost) {
            let of_peer =
                |(node, peer): (&NodeId, &Peer)| Some((peer.models.version.clone()?, node.clone()));
            self.newest = self.peers.iter().filter_map(of_peer).max();
        }
    }

    /// The models of another node, as it answered: below its root, the key and the payload of each. What is of no newer
    /// version changes nothing.
    pub fn follow(&mut self, node: &NodeId, theirs: Payloads, now: Moment) {
        let Some(peer) = self.peers.get(node) else {
            return;
        };
        let version = peer.models.version.clone();
        let Some(version) = version.filter(|_| peer.models.fingerprint == theirs.fingerprint())
        else {
            return;
        };
        let is_keeping = matches!(self.step, Some(Step::Keeping { .. }));
        if is_keeping || Some(&version) <= self.state.version.as_ref() {
            return;
        }
        let after = theirs.models(&self.models);
        match after {
            Ok(after) => {
                tracing::info!(%node, counter = version.counter, "takes over the rig, the \
                    objects and the settings of another fusion node");
                if let Some(Step::Spreading { mut answered, .. }) = self.step.take() {
                    answered.answer.outcome = overtaken();
                    self.effects.push_back(Effect::Answer(answered));
                }
                let changes = self.models.changes_to(&after);
                let before = self.models.clone();
                self.wait_for_files(&changes);
                self.take(changes, after, version.clone(), now);
                self.note_set_aside(&version, &before, now);
                self.set_payloads(theirs);
                self.adopt(version);
            }
            Err(refusal) => {
                tracing::error!(%node, "the models of another fusion node are newer and cannot \
                    be used here: {refusal}");
                self.unusable = Some(version);
            }
        }
    }

    /// Notes what of this node's changes the version in force does not have; what was `before` can be brought back.
    fn note_set_aside(&mut self, version: &ModelsVersion, before: &ModelsInForce, now: Moment) {
        let replaced = (self.own_changes).replaced(&version.author, before, &self.models);
        let Some(replaced) = replaced else {
            return;
        };
        tracing::warn!(by = %replaced.by, "a change of this node is set aside, as the network was \
            divided and another fusion node has made more changes, or later ones: {}", replaced.detail);
        self.formers = Formers::default();
        for change in &replaced.changes {
            self.formers.note(change, before, now.wall_ns);
        }
        self.set_aside = Some(replaced);
    }

    fn note_newer(&mut self, version: &ModelsVersion, node: &NodeId, now: Moment) {
        if self.newer().is_none() {
            self.behind_since_ns = Some(now.monotonic_ns);
        }
        let known = self.newest.as_ref().map(|(version, _)| version);
        if Some(version) >= known {
            self.newest = Some((version.clone(), node.clone()));
        }
    }

    fn newer(&self) -> Option<(&ModelsVersion, &NodeId)> {
        let newest = self.newest.as_ref().map(|(version, node)| (version, node));
        newest.filter(|(version, _)| Some(*version) > self.state.version.as_ref())
    }

    fn knows_newer_than(&self, version: &ModelsVersion) -> bool {
        let heard = self.newest.as_ref().map(|(version, _)| version);
        heard.max(self.state.version.as_ref()) > Some(version)
    }

    fn is_present(&self, node: &NodeId, now: Moment) -> bool {
        let peer = self.peers.get(node);
        peer.is_some_and(|peer| now.monotonic_ns.saturating_sub(peer.heard_ns) < PRESENT_NS)
    }

    /// The models in force are of this version.
    fn adopt(&mut self, version: ModelsVersion) {
        self.set_version(version);
        if let Some(backlog) = &mut self.backlog {
            backlog.is_record_old = true;
        }
    }

    fn set_payloads(&mut self, payloads: Payloads) {
        self.state.fingerprint = payloads.fingerprint();
        self.payloads = payloads;
    }

    fn set_version(&mut self, version: ModelsVersion) {
        self.counter = self.counter.max(version.counter);
        self.state.version = Some(version);
    }
}

/// Changes.
impl Replica {
    /// Decides on a change, as the node that publishes the poses.
    pub fn request(&mut self, request: Request, now: Moment) {
        let decided = request
            .changes
            .clone()
            .and_then(|changes| self.models.changed(&changes));
        match decided {
            Err(refusal) => self.answer(&request, ChangeOutcome::Refused(refusal)),
            // A person decides that the newer models, which this node cannot get, do not count.
            Ok(None) if self.newer().is_some() => {
                let (after, version) = (self.models.clone(), self.next_version(now));
                self.make(request, Vec::new(), after, version, now);
            }
            Ok(None) => self.answer(&request, ChangeOutcome::Same),
            Ok(Some(after)) => {
                let version = self.next_version(now);
                let changes = self.models.changes_to(&after);
                self.make(request, changes, after, version, now);
            }
        }
    }

    fn next_version(&self, now: Moment) -> ModelsVersion {
        ModelsVersion {
            counter: self.counter.saturating_add(1),
            t_ns: now.wall_ns,
            author: self.node.clone(),
        }
    }

    fn make(
        &mut self,
        request: Request,
        changes: Vec<Change>,
        after: ModelsInForce,
        version: ModelsVersion,
        now: Moment,
    ) {
        let Some(backlog) = &mut self.backlog else {
            self.own_changes.add(&changes, version.t_ns);
            self.take(changes, after, version, now);
            self.spread(&request, ChangeOutcome::Taken, now);
            return;
        };
        let mut all = backlog.changes.clone();
        all.extend(changes.iter().cloned());
        backlog.in_flight = Some(backlog.changes.len());
        backlog.noted = None;
        self.effects.push_back(Effect::Keep(KeepJob {
            changes: all,
            undo: after.changes_to(&self.models),
            record: ModelsRecord {
                state: ModelsState {
                    version: Some(version.clone()),
                    fingerprint: Payloads::encode(&after).fingerprint(),
                },
                newer: None,
            },
        }));
        self.step = Some(Step::Keeping {
            request,
            changes,
            after,
            version,
        });
    }

    /// What became of the last [`Effect::Keep`].
    pub fn kept(&mut self, outcome: Result<(), String>, now: Moment) {
        let Some(backlog) = &mut self.backlog else {
            return;
        };
        let n_written = backlog.in_flight.take().unwrap_or(0);
        match &outcome {
            Ok(()) => {
                backlog
                    .changes
                    .drain(..n_written.min(backlog.changes.len()));
                backlog.cause = None;
            }
            Err(_) => backlog.due_ns = now.monotonic_ns + RETRY_NS,
        }
        let Some(Step::Keeping {
            request,
            changes,
            after,
            version,
        }) = self
            .step
            .take_if(|step| matches!(step, Step::Keeping { .. }))
        else {
            if let Err(cause) = outcome {
                backlog.is_record_old = true;
                backlog.cause = Some(cause);
            }
            return;
        };
        match outcome {
            Err(cause) => {
                let detail = detail(&cause);
                self.answer(
                    &request,
                    ChangeOutcome::Refused(Refusal::NotStored { detail }),
                );
            }
            Ok(()) if self.knows_newer_than(&version) => {
                self.wait_for_files(&after.changes_to(&self.models));
                self.answer(&request, overtaken());
            }
            Ok(()) => {
                self.own_changes.add(&changes, version.t_ns);
                self.take(changes, after, version, now);
                self.spread(&request, ChangeOutcome::Kept, now);
            }
        }
    }

    /// Does what is due. A node that publishes and knows the models of all others gives its files a version, if they
    /// have none.
    pub fn tick(&mut self, publishes: bool, now: Moment) {
        let lasts = |since_ns: u64, ns: u64| now.monotonic_ns < since_ns + ns;
        self.unheard
            .retain(|_, until_ns| now.monotonic_ns < *until_ns);
        self.peers
            .retain(|_, peer| lasts(peer.heard_ns, FORGOTTEN_NS));
        self.is_compared |= self.unheard.is_empty();
        if publishes
            && self.state.version.is_none()
            && self.unheard.is_empty()
            && self.newest.is_none()
        {
            self.adopt(self.next_version(now));
        }
        let since_ns = self.outdated_since_ns.unwrap_or(now.monotonic_ns);
        self.outdated_since_ns = (!self.is_current()).then_some(since_ns);
        self.ask(now);
        self.write_backlog(now);
        if let Some(Step::Spreading { others, due_ns, .. }) = &self.step {
            let (_, behind) = self.followers(others);
            if behind.is_empty() || now.monotonic_ns >= *due_ns {
                self.finish();
            }
        }
    }

    /// The turn of a change took from `begun_ns` to `ended_ns` (monotonic): the next one waits.
    pub fn rest(&mut self, begun_ns: u64, ended_ns: u64) {
        self.pace.rest(begun_ns, ended_ns);
    }

    fn ask(&mut self, now: Moment) {
        let Some((version, node)) = self.newer() else {
            return;
        };
        let is_due = now.monotonic_ns >= self.question_due_ns;
        if is_due && self.unusable.as_ref() != Some(version) && self.is_present(node, now) {
            let node = node.clone();
            self.question_due_ns = now.monotonic_ns + QUESTION_NS;
            self.effects.push_back(Effect::Ask(node));
        }
    }

    fn write_backlog(&mut self, now: Moment) {
        let newer = self
            .newer()
            .map(|(version, node)| (version.clone(), node.clone()));
        let is_noted_ns = self.outdated_since_ns.unwrap_or(now.monotonic_ns) + NOTED_NS;
        let Some(backlog) = &mut self.backlog else {
            return;
        };
        let is_noted = newer == backlog.noted || newer.is_some() && now.monotonic_ns < is_noted_ns;
        let is_wanted = backlog.is_record_old || !backlog.changes.is_empty() || !is_noted;
        let is_free = self.step.is_none() && backlog.in_flight.is_none();
        if is_wanted && is_free && now.monotonic_ns >= backlog.due_ns {
            backlog.is_record_old = false;
            backlog.in_flight = Some(backlog.changes.len());
            backlog.noted = newer.clone();
            self.effects.push_back(Effect::Keep(KeepJob {
                changes: backlog.changes.clone(),
                undo: Vec::new(),
                record: ModelsRecord {
                    state: ModelsState {
                        version: self.state.version.clone(),
                        fingerprint: Payloads::encode(&self.models).fingerprint(),
                    },
                    newer,
                },
            }));
        }
    }

    /// Changes that are in force before they are in the files; the last one of each model counts.
    fn wait_for_files(&mut self, changes: &[Change]) {
        let Some(backlog) = &mut self.backlog else {
            return;
        };
        let n_in_flight = backlog.in_flight.unwrap_or(0);
        let mut waiting = backlog
            .changes
            .split_off(n_in_flight.min(backlog.changes.len()));
        waiting.retain(|known| !changes.iter().any(|change| change.is_about_the_same(known)));
        backlog.changes.append(&mut waiting);
        backlog.changes.extend(changes.iter().cloned());
    }

    fn take(
        &mut self,
        changes: Vec<Change>,
        after: ModelsInForce,
        version: ModelsVersion,
        now: Moment,
    ) {
        let is_own = version.author == self.node;
        let known = self
            .state
            .version
            .as_ref()
            .map_or(0, |version| version.counter);
        for change in &changes {
            // Between much older models and these there were others.
            match is_own || version.counter == known + 1 {
                true => self.formers.note(change, &self.models, now.wall_ns),
                false => self.formers.forget(change),
            }
        }
        let decides = |set_aside: &SetAside| {
            let mut own = set_aside.changes.iter();
            own.any(|own| changes.iter().any(|change| change.is_about_the_same(own)))
        };
        if self.set_aside.as_ref().is_some_and(decides) {
            self.set_aside = None;
        }
        self.set_payloads(Payloads::encode(&after));
        self.models = after;
        self.set_version(version);
        self.effects.push_back(Effect::PutInForce(changes));
    }

    fn spread(&mut self, request: &Request, outcome: ChangeOutcome, now: Moment) {
        let others = self.peers.keys().filter(|node| self.is_present(node, now));
        self.step = Some(Step::Spreading {
            answered: self.answered(request, outcome),
            others: others.cloned().collect(),
            due_ns: now.monotonic_ns + FOLLOWED_NS,
        });
    }

    fn answer(&mut self, request: &Request, outcome: ChangeOutcome) {
        let answered = self.answered(request, outcome);
        self.effects.push_back(Effect::Answer(answered));
    }

    fn answered(&self, request: &Request, outcome: ChangeOutcome) -> Answered {
        Answered {
            answer: ConfigAnswer {
                node: self.node.clone(),
                key: limits::clipped(&request.key, limits::MAX_DETAIL_BYTES),
                fingerprint: request.fingerprint,
                outcome,
                followers: Vec::new(),
                behind: Vec::new(),
            },
            origin: request.origin.clone(),
        }
    }

    fn finish(&mut self) {
        if let Some(Step::Spreading {
            mut answered,
            others,
            ..
        }) = self.step.take()
        {
            (answered.answer.followers, answered.answer.behind) = self.followers(&others);
            self.effects.push_back(Effect::Answer(answered));
        }
    }

    /// Those of these nodes that have this node's version, or a newer one, and those that do not.
    fn followers(&self, nodes: &[NodeId]) -> (Vec<NodeId>, Vec<NodeId>) {
        let has = |node: &NodeId| {
            let peer = self.peers.get(node);
            peer.is_some_and(|peer| peer.models.version >= self.state.version)
        };
        nodes.iter().cloned().partition(has)
    }
}

/// A change that was decided on while another node had newer models.
fn overtaken() -> ChangeOutcome {
    ChangeOutcome::Refused(Refusal::Other {
        detail: "another fusion node has newer models, which are in force now: look at them \
            (`sextant config get`) and try again"
            .to_owned(),
    })
}

#[cfg(test)]
mod tests;
