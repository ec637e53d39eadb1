//! This node's part among the fusion nodes of its site: heartbeats and liveliness in, heartbeats and the epoch of its poses out. Who
//! publishes, and which objects, is decided by `sextant_election`.

use crate::config::ShardingConfig;
use crate::replica::Replica;
use sextant_election::{Assignment, Company, Election, Input, Link, Moment, Sharding};
use sextant_process::SteadyClock;
use sextant_proto::limits::MAX_PEERS;
use sextant_proto::{Heartbeat, KeyRef, Keys, Kind, ModelsState, NodeId};
use sextant_site_model::{ObjectId, ObjectModel, TagId};
use sextant_zenoh_bus::{
    AliveWatch, Bus, BusError, Presence, Publisher, Qos, StreamBounds, Subscription,
};
use std::collections::BTreeSet;
use std::time::Duration;

/// Most heartbeats that wait: three seconds of those of as many nodes as a site may have.
const QUEUE: StreamBounds = StreamBounds {
    items: 60 * MAX_PEERS,
    bytes: 8 << 20,
    wait: Duration::MAX,
};

/// What this node has to do from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Duty {
    /// Publish poses under this epoch.
    Publish {
        /// Greater than those of all others.
        epoch: u64,
    },
    /// Publish none.
    StandBy,
}

/// Takes part in the election.
#[derive(Debug)]
pub struct Standby {
    keys: Keys,
    election: Election,
    heartbeats: Subscription,
    presence: AliveWatch,
    publisher: Publisher<Heartbeat>,
    duty: Duty,
    /// The models that the last heartbeat told of.
    told: ModelsState,
    /// None where one node publishes all poses.
    sharding: Option<Sharding>,
    /// Tags of objects that other nodes track.
    foreign_tags: BTreeSet<TagId>,
}

/// Now, by both clocks of the host.
pub fn moment(clock: &SteadyClock) -> Moment {
    Moment {
        monotonic_ns: clock.monotonic_ns(),
        wall_ns: clock.now_ns(),
    }
}

fn assignment(config: &ShardingConfig) -> Option<Assignment> {
    match config {
        ShardingConfig::Off => None,
        ShardingConfig::ByMembers { standbys } => Some(Assignment::ByMembers {
            standbys: *standbys,
        }),
        ShardingConfig::Fixed { objects } => Some(Assignment::Fixed(objects.clone())),
    }
}

impl Standby {
    /// Joins the fusion nodes of the site; where there are others, as a standby.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn open(
        bus: &Bus,
        keys: &Keys,
        node: &NodeId,
        sharding: &ShardingConfig,
        replica: &mut Replica,
        clock: &SteadyClock,
    ) -> Result<Self, BusError> {
        let longest = Kind::Heartbeat.max_bytes();
        let heartbeats = keys.all_heartbeats();
        let heartbeats = bus.subscribe_stream(&heartbeats, QUEUE, longest)?;
        let alive = bus.alive_keys(&keys.all_fusion_alive())?;
        let company = match alive.is_empty() {
            true => Company::Alone,
            false => Company::Others,
        };
        let now = moment(clock);
        for key in alive {
            if let Some(KeyRef::Alive(_, node)) = keys.parse(&key) {
                replica.joined(node, now);
            }
        }
        let assignment = assignment(sharding);
        Ok(Self {
            election: Election::new(node.clone(), now, company),
            sharding: assignment.map(|one| Sharding::new(node.clone(), one, now, company)),
            foreign_tags: BTreeSet::new(),
            heartbeats,
            presence: bus.watch_alive(&keys.all_fusion_alive())?,
            publisher: bus.publisher(&keys.heartbeat(node), Qos::Pose)?,
            duty: Duty::StandBy,
            told: ModelsState::default(),
            keys: keys.clone(),
        })
    }

    /// Takes in what has arrived and sends what is due, also of the models of the nodes; a change of duty, if there is one.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn turn(
        &mut self,
        bus: &Bus,
        replica: &mut Replica,
        clock: &SteadyClock,
    ) -> Result<Option<Duty>, BusError> {
        let now = moment(clock);
        let link = match bus.is_connected() {
            true => Link::Up,
            false => Link::Down,
        };
        self.election.handle(now, Input::Link(link));
        while let Some(change) = self.presence.try_recv() {
            let (Presence::Joined(key) | Presence::Left(key)) = &change;
            let Some(KeyRef::Alive(_, node)) = self.keys.parse(key) else {
                continue;
            };
            match change {
                Presence::Joined(_) => replica.joined(node, now),
                Presence::Left(_) => {
                    self.election.handle(now, Input::Left(&node));
                    replica.left(&node, now);
                }
            }
        }
        while let Some(item) = self.heartbeats.try_recv() {
            if let Ok(beat) = item.decode::<Heartbeat>()
                && self.keys.heartbeat(&beat.node) == item.key
            {
                self.election.handle(now, Input::Heartbeat(&beat));
                replica.hear(&beat.node, &beat.models, now);
                if let Some(sharding) = &mut self.sharding
                    && sharding.hear(&beat)
                {
                    tracing::warn!(node = %beat.node, "a fusion node has another [sharding]: give all nodes of the site the same mode and standbys");
                }
            }
        }
        self.election.handle(now, Input::Tick);
        if let Some(sharding) = &mut self.sharding
            && sharding.evaluate(now, &self.election)
        {
            self.election.hasten_heartbeat(now.monotonic_ns);
            self.note_foreign_tags(&replica.models().objects);
        }
        let models = replica.state();
        if *models != self.told {
            self.election.hasten_heartbeat(now.monotonic_ns);
        }
        if let Some(mut beat) = self.election.poll_heartbeat(now.monotonic_ns) {
            let sharding = self.sharding.as_ref();
            beat.sharing = sharding.map(|sharding| sharding.announcement(now.monotonic_ns));
            beat.models = models.clone();
            self.told = models.clone();
            self.publisher.put(&beat)?;
        }
        Ok(self.change_of_duty())
    }

    /// The site has these objects now.
    pub fn take_objects(&mut self, objects: &[ObjectModel]) {
        if let Some(sharding) = &mut self.sharding {
            sharding.set_objects(objects.iter().map(ObjectModel::id));
            self.note_foreign_tags(objects);
        }
    }

    fn note_foreign_tags(&mut self, objects: &[ObjectModel]) {
        let others = objects.iter().filter(|object| !self.tracks(object.id()));
        let tags = others.flat_map(ObjectModel::tags).map(|tag| tag.tag);
        self.foreign_tags = tags.collect();
    }

    /// The host's clock was set, or the host was suspended: others may have taken over meanwhile.
    pub fn interrupted(&mut self, clock: &SteadyClock) {
        self.election.handle(moment(clock), Input::Interrupted);
    }

    /// Whether this node cares for what concerns the whole site, also while it waits for the others after an interruption.
    pub fn leads(&self) -> bool {
        self.duty != Duty::StandBy
    }

    /// Epoch of the poses that this node publishes now; none while it stands by.
    pub fn epoch(&self, clock: &SteadyClock) -> Option<u64> {
        self.election.epoch(clock.monotonic_ns())
    }

    /// Epoch of the poses of an object that this node publishes now; none where another node does.
    pub fn epoch_of(&self, object: &ObjectId, clock: &SteadyClock) -> Option<u64> {
        let Some(sharding) = &self.sharding else {
            return self.epoch(clock);
        };
        let is_sure = self.election.is_sure(clock.monotonic_ns());
        sharding.epoch(object).filter(|_| is_sure)
    }

    /// The newest epoch of the poses that this node publishes; none while it publishes none.
    pub fn newest_epoch(&self, clock: &SteadyClock) -> Option<u64> {
        match &self.sharding {
            Some(sharding) => sharding.newest_epoch(),
            None => self.epoch(clock),
        }
    }

    /// Whether the objects of the site are shared among its fusion nodes.
    pub fn is_shared(&self) -> bool {
        self.sharding.is_some()
    }

    /// Whether this node tracks an object.
    pub fn tracks(&self, object: &ObjectId) -> bool {
        let sharding = self.sharding.as_ref();
        sharding.is_none_or(|sharding| sharding.tracks(object))
    }

    /// Whether a tag is on an object that other nodes track.
    pub fn is_foreign(&self, tag: &TagId) -> bool {
        self.foreign_tags.contains(tag)
    }

    /// The estimator tracks the object well.
    pub fn see(&mut self, object: &ObjectId, clock: &SteadyClock) {
        if let Some(sharding) = &mut self.sharding {
            sharding.see(object, clock.monotonic_ns());
        }
    }

    /// When the next turn is due, ns by the monotonic clock.
    pub fn due_ns(&self) -> u64 {
        self.election.poll_timeout()
    }

    fn change_of_duty(&mut self) -> Option<Duty> {
        let duty = match self.election.claim() {
            Some(epoch) => Duty::Publish { epoch },
            None => Duty::StandBy,
        };
        let before = std::mem::replace(&mut self.duty, duty);
        (before != duty).then_some(duty)
    }
}
