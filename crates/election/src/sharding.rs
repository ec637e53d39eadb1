//! Which objects of a site a fusion node tracks, and of which it publishes the poses.
//!
//! Input: heartbeats of the other nodes, which of them are alive, what this node sees of its objects, and time. Output:
//! what this node tracks and publishes, and its part of a heartbeat. Knows no network and no clock.
//!
//! - The nodes are ranked per object by weights that all of them compute alike: rendezvous hashing (D. G. Thaler, C. V.
//!   Ravishankar, Using name-based mappings to increase hit rates, IEEE/ACM Transactions on Networking 6, 1998). When a
//!   node comes or goes, only the objects move in whose ranking it comes first.
//! - The first nodes of the ranking track an object, and the first of them that is ready publishes it. A node is ready
//!   when it has tracked the object for half a second. Until another node has announced that it publishes, the former
//!   one goes on, so that nothing is missing in between.
//! - Who begins to publish takes an epoch greater than all it knows of, as in the election. Of two that publish the one
//!   with the older epoch stops.

use crate::election::{ARRIVAL_NS, Company, Election, Moment};
use sextant_proto::limits::MAX_PEERS;
use sextant_proto::{Heartbeat, NodeId, Part, Share, Sharing, fingerprint};
use sextant_site_model::ObjectId;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

const MS: u64 = 1_000_000;
/// Longest time between two evaluations, ns: by so much a node begins later to publish what it has become ready for.
const PERIOD_NS: u64 = 100 * MS;
/// A node that has tracked an object for so long is ready to publish it, ns: the window of the estimator.
const READY_NS: u64 = 500 * MS;

/// How a node comes to its objects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Assignment {
    /// By the ranking of the nodes that are alive.
    ByMembers {
        /// How many nodes besides the publisher track an object.
        standbys: usize,
    },
    /// These objects, whoever else is alive.
    Fixed(BTreeSet<ObjectId>),
}

/// One node's share of the objects of a site. Times are by [`Moment::monotonic_ns`].
#[derive(Debug, Clone)]
pub struct Sharding {
    node: NodeId,
    assignment: Assignment,
    objects: BTreeMap<ObjectId, OwnPart>,
    /// What the other nodes have announced; at most [`MAX_PEERS`].
    members: BTreeMap<NodeId, Member>,
    /// Nodes whose configuration differs from this node's.
    dissenters: BTreeSet<NodeId>,
    /// The newest epoch known.
    newest: u64,
    /// Before this the others may not have been heard.
    listens_until_ns: u64,
    due_ns: u64,
}

/// This node's part in one object.
#[derive(Debug, Clone, Copy, Default)]
struct OwnPart {
    is_tracked: bool,
    /// When the object was first tracked well.
    seen_ns: Option<u64>,
    epoch: Option<u64>,
}

/// Another node, as last heard.
#[derive(Debug, Clone, Default, PartialEq)]
struct Member {
    standbys: Option<u32>,
    parts: BTreeMap<ObjectId, Part>,
}

impl OwnPart {
    fn part(&self, now_ns: u64) -> Part {
        let is_ready = |seen_ns: u64| now_ns >= seen_ns + READY_NS;
        match self.epoch {
            Some(epoch) => Part::Publishing(epoch),
            None if self.seen_ns.is_some_and(is_ready) => Part::Ready,
            None => Part::Preparing,
        }
    }
}

/// The weight of a node for an object. The node with the greatest comes first; equal ones are ordered by name.
fn weight<'a>(node: &'a NodeId, object: &ObjectId) -> (u64, Reverse<&'a NodeId>) {
    let name = format!("{node}/{object}");
    // FNV-1a spreads its last bytes over the high bits too little to be compared: finalised as in splitmix64.
    let mut hash = fingerprint(name.as_bytes());
    hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (hash ^ (hash >> 31), Reverse(node))
}

/// The nodes in the order in which they take an object over.
pub fn ranking<'a>(
    nodes: impl IntoIterator<Item = &'a NodeId>,
    object: &ObjectId,
) -> Vec<&'a NodeId> {
    let mut nodes: Vec<&NodeId> = nodes.into_iter().collect();
    nodes.sort_by_cached_key(|&node| Reverse(weight(node, object)));
    nodes
}

impl Sharding {
    /// A node that starts now, among others or alone.
    #[must_use]
    pub fn new(node: NodeId, assignment: Assignment, now: Moment, company: Company) -> Self {
        let now_ns = now.monotonic_ns;
        Self {
            node,
            assignment,
            objects: BTreeMap::new(),
            members: BTreeMap::new(),
            dissenters: BTreeSet::new(),
            newest: 0,
            listens_until_ns: match company {
                Company::Alone => now_ns,
                Company::Others => now_ns + ARRIVAL_NS,
            },
            due_ns: now_ns,
        }
    }

    /// The site has these objects now; those that stay keep their part.
    pub fn set_objects<'a>(&mut self, objects: impl IntoIterator<Item = &'a ObjectId>) {
        let mut before = std::mem::take(&mut self.objects);
        let part = |id: &ObjectId| (id.clone(), before.remove(id).unwrap_or_default());
        self.objects = objects.into_iter().map(part).collect();
        self.due_ns = 0;
    }

    /// The estimator tracks the object well.
    pub fn see(&mut self, object: &ObjectId, monotonic_ns: u64) {
        if let Some(own) = self.objects.get_mut(object)
            && own.is_tracked
        {
            own.seen_ns.get_or_insert(monotonic_ns);
        }
    }

    /// Takes in another node's heartbeat; whether that node's configuration is found to differ from this one's.
    pub fn hear(&mut self, beat: &Heartbeat) -> bool {
        if beat.node == self.node {
            return false;
        }
        let sharing = beat.sharing.as_ref();
        let parts = sharing.into_iter().flat_map(|sharing| &sharing.objects);
        let parts: BTreeMap<_, _> = parts.map(|one| (one.object.clone(), one.part)).collect();
        let epochs = parts.values().filter_map(|part| match part {
            Part::Publishing(epoch) => Some(*epoch),
            Part::Preparing | Part::Ready => None,
        });
        let newest = epochs.chain(beat.epoch).chain([beat.newest]).max();
        self.newest = self.newest.max(newest.unwrap_or(0));
        let member = sharing.map(|sharing| Member {
            standbys: sharing.standbys,
            parts,
        });
        let agrees = (member.as_ref()).is_some_and(|one| one.standbys == self.standbys());
        let before = self.members.remove(&beat.node);
        if before != member {
            self.due_ns = 0;
        }
        if let Some(member) = member
            && self.members.len() < MAX_PEERS
        {
            self.members.insert(beat.node.clone(), member);
        }
        if agrees || self.dissenters.len() >= MAX_PEERS {
            self.dissenters.remove(&beat.node);
            return false;
        }
        self.dissenters.insert(beat.node.clone())
    }

    /// Decides anew what this node tracks and publishes, by the election's knowledge of who is alive; whether that has
    /// changed. Then a heartbeat is due at once: the others have to know of an epoch before its poses appear.
    pub fn evaluate(&mut self, now: Moment, election: &Election) -> bool {
        let now_ns = now.monotonic_ns;
        if !election.is_linked() {
            self.listens_until_ns = now_ns + ARRIVAL_NS;
        }
        let is_sure = now_ns >= self.listens_until_ns && election.is_sure(now_ns);
        if !is_sure {
            return false;
        }
        let n_members = self.members.len();
        self.members
            .retain(|node, _| election.is_present(node, now_ns));
        if self.members.len() == n_members && now_ns < self.due_ns {
            return false;
        }
        self.due_ns = now_ns + PERIOD_NS;
        let next_epoch = self.newest.saturating_add(1).max(now.wall_ns);
        let mut objects = std::mem::take(&mut self.objects);
        let mut has_changed = false;
        for (object, own) in &mut objects {
            let before = (own.is_tracked, own.epoch);
            self.track(object, own);
            own.epoch = self.publish(object, own, now_ns, next_epoch);
            self.newest = self.newest.max(own.epoch.unwrap_or(0));
            has_changed |= before != (own.is_tracked, own.epoch);
        }
        self.objects = objects;
        has_changed
    }

    /// Whether this node tracks an object.
    #[must_use]
    pub fn tracks(&self, object: &ObjectId) -> bool {
        self.objects.get(object).is_some_and(|own| own.is_tracked)
    }

    /// The epoch under which this node publishes the poses of an object, provided that the election
    /// [is sure](Election::is_sure).
    #[must_use]
    pub fn epoch(&self, object: &ObjectId) -> Option<u64> {
        self.objects.get(object)?.epoch
    }

    /// The newest epoch of the poses that this node publishes.
    #[must_use]
    pub fn newest_epoch(&self) -> Option<u64> {
        self.objects.values().filter_map(|own| own.epoch).max()
    }

    /// What this node announces in its heartbeat.
    #[must_use]
    pub fn announcement(&self, monotonic_ns: u64) -> Sharing {
        let tracked = self.objects.iter().filter(|(_, own)| own.is_tracked);
        let share = |(object, own): (&ObjectId, &OwnPart)| Share {
            object: object.clone(),
            part: own.part(monotonic_ns),
        };
        Sharing {
            standbys: self.standbys(),
            objects: tracked.map(share).collect(),
        }
    }
}

impl Sharding {
    fn standbys(&self) -> Option<u32> {
        match &self.assignment {
            Assignment::ByMembers { standbys } => {
                Some(u32::try_from(*standbys).unwrap_or(u32::MAX))
            }
            Assignment::Fixed(_) => None,
        }
    }

    /// A node begins to track an object that it ranks high enough for, and stops when enough nodes before it are ready:
    /// until then it is needed.
    fn track(&self, object: &ObjectId, own: &mut OwnPart) {
        let is_tracked = match &self.assignment {
            Assignment::Fixed(objects) => objects.contains(object),
            Assignment::ByMembers { standbys } => {
                let own_weight = weight(&self.node, object);
                let before = (self.members.iter()).filter(|(node, member)| {
                    let may_track = member.standbys.is_some() || member.parts.contains_key(object);
                    may_track && weight(node, object) > own_weight
                });
                let is_ready = |member: &Member| member.part(object) > Some(Part::Preparing);
                let n_needed = before.filter(|(_, member)| !own.is_tracked || is_ready(member));
                own.epoch.is_some() || n_needed.count() <= *standbys
            }
        };
        if !is_tracked {
            *own = OwnPart::default();
        }
        own.is_tracked = is_tracked;
    }

    /// The epoch under which this node publishes the object from now on.
    fn publish(&self, object: &ObjectId, own: &OwnPart, now_ns: u64, next: u64) -> Option<u64> {
        if !own.is_tracked {
            return None;
        }
        let order = |node, part: Part| (part > Part::Preparing, weight(node, object));
        let others = || {
            let members = self.members.iter();
            members.filter_map(|(node, member)| Some((node, member.part(object)?)))
        };
        let own_order = order(&self.node, own.part(now_ns));
        let is_first = others().all(|(node, part)| order(node, part) < own_order);
        let is_replaced = others().any(|(node, part)| match (part, own.epoch) {
            (Part::Publishing(theirs), Some(epoch)) => {
                (theirs, Reverse(node)) > (epoch, Reverse(&self.node))
            }
            _ => false,
        });
        match own.epoch {
            Some(epoch) if !is_replaced => Some(epoch),
            _ => is_first.then_some(next),
        }
    }
}

impl Member {
    fn part(&self, object: &ObjectId) -> Option<Part> {
        self.parts.get(object).copied()
    }
}
