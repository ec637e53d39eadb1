//! The state machine of one node.

use sextant_proto::limits::MAX_PEERS;
use sextant_proto::{HeardBeat, Heartbeat, ModelsState, NodeId};
use std::collections::BTreeMap;

const MS: u64 = 1_000_000;
/// Period of heartbeats, ns.
const BEAT_NS: u64 = 50 * MS;
/// Silence of the publisher after which a standby takes over, ns: longer than a heartbeat's period, an unnoticed
/// interruption and a slow network together.
const SILENCE_NS: u64 = 200 * MS;
/// The same where its liveliness token is gone, ns: a heartbeat that comes nevertheless shows that only a link was
/// lost.
const FAREWELL_NS: u64 = 75 * MS;
/// By so much longer each further standby waits, ns.
const TURN_NS: u64 = 50 * MS;
/// A node that was not called for so long was interrupted, ns. It is called at least once in a heartbeat's period.
const INTERRUPTION_NS: u64 = 100 * MS;
/// How long a node that was interrupted waits for the answers of others, ns.
const ANSWERS_NS: u64 = 500 * MS;
/// A node among others listens for so long before it may take over, ns: subscriptions have to reach the others first.
pub(crate) const ARRIVAL_NS: u64 = 500 * MS;
/// A node that has not been heard of for so long is forgotten, ns.
const FORGOTTEN_NS: u64 = 5000 * MS;

/// A moment by both clocks of a host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// By a clock that is never set, ns.
    pub monotonic_ns: u64,
    /// Wire time, ns since the Unix epoch: only epochs are made of it.
    pub wall_ns: u64,
}

/// Whether other fusion nodes were alive when this one started.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Company {
    /// None: the node publishes at once.
    Alone,
    /// Some: the node listens first.
    Others,
}

/// This node's link to the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Link {
    /// A router answers, or none is needed.
    Up,
    /// No router answers, so no other node receives this one's messages.
    Down,
}

/// What happens to a node.
#[derive(Debug, Clone, Copy)]
pub enum Input<'a> {
    /// Time has passed.
    Tick,
    /// A heartbeat has arrived.
    Heartbeat(&'a Heartbeat),
    /// Another node's liveliness token is gone.
    Left(&'a NodeId),
    /// The state of the link, whether or not it has changed.
    Link(Link),
    /// The host was suspended, or its clock was set.
    Interrupted,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    StandingBy,
    Publishing { epoch: u64 },
}

/// Another node, as last heard.
#[derive(Debug, Clone)]
struct Peer {
    received_ns: u64,
    sent_ns: u64,
    epoch: Option<u64>,
    /// The newest of this node's heartbeats that it has received.
    answered_ns: Option<u64>,
}

impl Peer {
    fn is_present(&self, now_ns: u64) -> bool {
        now_ns.saturating_sub(self.received_ns) < SILENCE_NS
    }
}

/// One node's part in the election. Times are by [`Moment::monotonic_ns`].
#[derive(Debug, Clone)]
pub struct Election {
    node: NodeId,
    role: Role,
    link: Link,
    /// When the last interruption was, until every other node has answered a heartbeat sent since then.
    unanswered_since_ns: Option<u64>,
    /// The newest epoch known.
    newest: u64,
    /// At most [`MAX_PEERS`].
    peers: BTreeMap<NodeId, Peer>,
    called_ns: u64,
    beat_due_ns: u64,
    /// Since when no publisher is known.
    silent_since_ns: u64,
}

impl Election {
    /// A node that starts now.
    #[must_use]
    pub fn new(node: NodeId, now: Moment, company: Company) -> Self {
        let now_ns = now.monotonic_ns;
        let mut election = Self {
            node,
            role: Role::StandingBy,
            link: Link::Up,
            unanswered_since_ns: None,
            newest: 0,
            peers: BTreeMap::new(),
            called_ns: now_ns,
            beat_due_ns: now_ns,
            silent_since_ns: now_ns + ARRIVAL_NS - SILENCE_NS,
        };
        if company == Company::Alone {
            election.take_over(now);
        }
        election
    }

    /// Takes an input that arrives now.
    pub fn handle(&mut self, now: Moment, input: Input<'_>) {
        let now_ns = now.monotonic_ns;
        if self.is_interrupted(now_ns) {
            self.interrupted(now_ns);
        }
        self.called_ns = now_ns;
        match input {
            Input::Tick => self.tick(now),
            Input::Heartbeat(beat) => self.hear(now_ns, beat),
            Input::Left(node) => self.left(now_ns, node),
            Input::Link(link) => self.link(now_ns, link),
            Input::Interrupted => self.interrupted(now_ns),
        }
    }

    /// The epoch under which this node may publish at `monotonic_ns`; none while it stands by.
    #[must_use]
    pub fn epoch(&self, monotonic_ns: u64) -> Option<u64> {
        self.claim().filter(|_| self.is_sure(monotonic_ns))
    }

    /// Whether what this node knows of the others holds at `monotonic_ns`: it is neither cut off nor waits for answers
    /// after an interruption.
    #[must_use]
    pub fn is_sure(&self, monotonic_ns: u64) -> bool {
        let is_known = self.peers.is_empty() || !self.is_interrupted(monotonic_ns);
        self.is_linked() && self.unanswered_since_ns.is_none() && is_known
    }

    /// Whether the link to the network is up.
    #[must_use]
    pub fn is_linked(&self) -> bool {
        self.link == Link::Up
    }

    /// Whether another node counts as alive at `monotonic_ns`.
    #[must_use]
    pub fn is_present(&self, node: &NodeId, monotonic_ns: u64) -> bool {
        let peer = self.peers.get(node);
        peer.is_some_and(|peer| peer.is_present(monotonic_ns))
    }

    /// The epoch that this node holds, also while it waits for the others after an interruption; none of a standby.
    #[must_use]
    pub fn claim(&self) -> Option<u64> {
        match self.role {
            Role::StandingBy => None,
            Role::Publishing { epoch } => Some(epoch),
        }
    }

    /// Makes a heartbeat due at once: the others are to know something now.
    pub fn hasten_heartbeat(&mut self, monotonic_ns: u64) {
        self.beat_due_ns = self.beat_due_ns.min(monotonic_ns);
    }

    /// The heartbeat that is due, if one is.
    pub fn poll_heartbeat(&mut self, monotonic_ns: u64) -> Option<Heartbeat> {
        if monotonic_ns < self.beat_due_ns {
            return None;
        }
        self.beat_due_ns = monotonic_ns + BEAT_NS;
        let heard = self.peers.iter().map(|(node, peer)| HeardBeat {
            node: node.clone(),
            sent_ns: peer.sent_ns,
        });
        Some(Heartbeat {
            node: self.node.clone(),
            sent_ns: monotonic_ns,
            epoch: self.claim(),
            newest: self.newest,
            heard: heard.collect(),
            sharing: None,
            models: ModelsState::default(),
        })
    }

    /// When [`Input::Tick`] and [`Self::poll_heartbeat`] are due.
    #[must_use]
    pub fn poll_timeout(&self) -> u64 {
        match self.role {
            Role::StandingBy if self.link == Link::Up => {
                let takes_over_ns = self.silent_since_ns + SILENCE_NS;
                self.beat_due_ns.min(takes_over_ns.max(self.called_ns + MS))
            }
            _ => self.beat_due_ns,
        }
    }
}

impl Election {
    fn is_interrupted(&self, now_ns: u64) -> bool {
        now_ns.saturating_sub(self.called_ns) > INTERRUPTION_NS
    }

    /// Another node may have taken over meanwhile; its heartbeats arrive only now. Nodes that were silent before are
    /// not waited for.
    fn interrupted(&mut self, now_ns: u64) {
        let called_ns = self.called_ns;
        let was_present = |peer: &&mut Peer| called_ns < peer.received_ns + SILENCE_NS;
        for peer in self.peers.values_mut().filter(was_present) {
            peer.received_ns = now_ns;
        }
        self.silent_since_ns = self.silent_since_ns.max(now_ns);
        self.beat_due_ns = now_ns;
        self.unanswered_since_ns = Some(now_ns);
        self.count_answers();
    }

    /// The interruption is over when the others have answered, at once where there are none.
    fn count_answers(&mut self) {
        let Some(since_ns) = self.unanswered_since_ns else {
            return;
        };
        let answered = |peer: &Peer| peer.answered_ns.is_some_and(|sent_ns| sent_ns >= since_ns);
        let mut present = (self.peers.values()).filter(|peer| peer.received_ns >= since_ns);
        if present.all(answered) {
            self.unanswered_since_ns = None;
        }
    }

    fn tick(&mut self, now: Moment) {
        let now_ns = now.monotonic_ns;
        self.peers
            .retain(|_, peer| now_ns.saturating_sub(peer.received_ns) < FORGOTTEN_NS);
        let is_over = |since_ns: u64| now_ns >= since_ns + ANSWERS_NS;
        if self.unanswered_since_ns.is_some_and(is_over) {
            self.unanswered_since_ns = None;
        }
        let stands_by = self.role == Role::StandingBy && self.is_linked();
        if stands_by && now_ns >= self.takes_over_ns(now_ns) {
            self.take_over(now);
        }
    }

    /// When this standby takes over, unless it receives a heartbeat of a publisher before.
    fn takes_over_ns(&self, now_ns: u64) -> u64 {
        let before = self.peers.range(..&self.node);
        let n_before = before.filter(|(_, peer)| peer.is_present(now_ns)).count() as u64;
        self.silent_since_ns + SILENCE_NS + n_before * TURN_NS
    }

    fn take_over(&mut self, now: Moment) {
        self.newest = self.newest.saturating_add(1).max(now.wall_ns);
        self.role = Role::Publishing { epoch: self.newest };
        self.unanswered_since_ns = None;
        self.beat_due_ns = now.monotonic_ns;
    }

    fn hear(&mut self, now_ns: u64, beat: &Heartbeat) {
        if beat.node == self.node {
            return;
        }
        let answer = beat.heard.iter().find(|heard| heard.node == self.node);
        let peer = Peer {
            received_ns: now_ns,
            sent_ns: beat.sent_ns,
            epoch: beat.epoch,
            answered_ns: answer.map(|heard| heard.sent_ns),
        };
        if self.peers.len() < MAX_PEERS || self.peers.contains_key(&beat.node) {
            self.peers.insert(beat.node.clone(), peer);
        }
        self.newest = self.newest.max(beat.newest).max(beat.epoch.unwrap_or(0));
        if beat.epoch == Some(self.newest) {
            self.silent_since_ns = self.silent_since_ns.max(now_ns);
        }
        let is_replaced = |epoch: u64| {
            epoch < self.newest || (beat.epoch == Some(epoch) && beat.node < self.node)
        };
        if self.claim().is_some_and(is_replaced) {
            self.role = Role::StandingBy;
            self.silent_since_ns = now_ns;
            self.beat_due_ns = now_ns;
        }
        self.count_answers();
    }

    fn left(&mut self, now_ns: u64, node: &NodeId) {
        let Some(gone) = self.peers.get_mut(node) else {
            return;
        };
        let silent_since_ns = (now_ns + FAREWELL_NS).saturating_sub(SILENCE_NS);
        gone.received_ns = gone.received_ns.min(silent_since_ns);
        let is_publisher = gone.epoch == Some(self.newest);
        if is_publisher && self.role == Role::StandingBy && self.is_linked() {
            self.silent_since_ns = silent_since_ns;
        }
        self.count_answers();
    }

    fn link(&mut self, now_ns: u64, link: Link) {
        let was = std::mem::replace(&mut self.link, link);
        if was == Link::Down && link == Link::Up {
            self.interrupted(now_ns);
        }
    }
}
