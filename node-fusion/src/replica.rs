//! This node's replica of the site's models. The node that publishes the poses decides about changes, the others follow
//! it, and the newest version wins wherever it comes from.
//!
//! Input: requests, heartbeats of other nodes, their models, and what became of writing files. Output: [`Effect`]s.
//! Knows no network, no file and no clock.

use crate::formers::Formers;
use crate::models::{Change, ModelsInForce, Payloads};
use crate::pace::Pace;
use crate::refusals::detail;
use sextant_election::Moment;
use sextant_proto::{
    ChangeOutcome, ConfigAnswer, KeyRef, ModelsState, ModelsVersion, NodeId, Refusal, limits,
};
use std::collections::{BTreeMap, VecDeque};

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
    /// Take back what was written before one failed, in this order.
    pub undo: Vec<Change>,
    /// Which models the files hold then.
    pub record: ModelsState,
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
    /// The newest version that a heartbeat has reported, and whose.
    newest: Option<(ModelsVersion, NodeId)>,
    /// A version that this node cannot work from.
    unusable: Option<ModelsVersion>,
    peers: BTreeMap<NodeId, Peer>,
    /// Nodes that have not reported their models yet, and when they came or left last, monotonic ns.
    unheard: BTreeMap<NodeId, u64>,
    /// Whether the models were compared with those of all other nodes since the start.
    is_compared: bool,
    question_due_ns: u64,
    /// Since when newer models are known, monotonic ns.
    behind_since_ns: Option<u64>,
    step: Option<Step>,
    /// None where changes are not kept.
    backlog: Option<Backlog>,
    pace: Pace,
    effects: VecDeque<Effect>,
}

impl Replica {
    /// Of models that were read from files, whose record says which version they were of. With `keeps`, changes outlive
    /// the process.
    #[must_use]
    pub fn new(
        node: NodeId,
        models: ModelsInForce,
        formers: Formers,
        record: Option<ModelsState>,
        keeps: bool,
    ) -> Self {
        let payloads = Payloads::encode(&models);
        let record = record.unwrap_or_default();
        let counter = record.version.as_ref().map_or(0, |version| version.counter);
        // Files that were edited since are of no version.
        let is_known = record.fingerprint == payloads.fingerprint();
        Self {
            node,
            formers,
            state: ModelsState {
                version: record.version.filter(|_| is_known),
                fingerprint: payloads.fingerprint(),
            },
            payloads,
            models,
            counter,
            newest: None,
            unusable: None,
            peers: BTreeMap::new(),
            unheard: BTreeMap::new(),
            is_compared: false,
            question_due_ns: 0,
            behind_since_ns: None,
            step: None,
            backlog: keeps.then(Backlog::default),
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
            self.unheard.insert(node, now.monotonic_ns);
        }
    }

    /// A fusion node is not alive any more.
    pub fn left(&mut self, node: &NodeId, now: Moment) {
        if let Some(since_ns) = self.unheard.get_mut(node) {
            *since_ns = now.monotonic_ns;
        }
        self.peers.remove(node);
    }

    /// A heartbeat of another node.
    pub fn hear(&mut self, node: &NodeId, theirs: &ModelsState, now: Moment) {
        if *node == self.node {
            return;
        }
        self.unheard.remove(node);
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
        let is_lost = |(version, holder): &(ModelsVersion, NodeId)| {
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
                self.wait_for_files(&changes);
                self.take(changes, after, version.clone(), now);
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
            self.take(changes, after, version, now);
            self.spread(&request, ChangeOutcome::Taken, now);
            return;
        };
        let mut all = backlog.changes.clone();
        all.extend(changes.iter().cloned());
        backlog.in_flight = Some(backlog.changes.len());
        self.effects.push_back(Effect::Keep(KeepJob {
            changes: all,
            undo: after.changes_to(&self.models),
            record: ModelsState {
                version: Some(version.clone()),
                fingerprint: Payloads::encode(&after).fingerprint(),
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
            .retain(|_, since_ns| lasts(*since_ns, PAUSE_NS));
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
        let Some(backlog) = &mut self.backlog else {
            return;
        };
        let is_wanted = backlog.is_record_old || !backlog.changes.is_empty();
        let is_free = self.step.is_none() && backlog.in_flight.is_none();
        if is_wanted && is_free && now.monotonic_ns >= backlog.due_ns {
            backlog.is_record_old = false;
            backlog.in_flight = Some(backlog.changes.len());
            self.effects.push_back(Effect::Keep(KeepJob {
                changes: backlog.changes.clone(),
                undo: Vec::new(),
                record: ModelsState {
                    version: self.state.version.clone(),
                    fingerprint: Payloads::encode(&self.models).fingerprint(),
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
