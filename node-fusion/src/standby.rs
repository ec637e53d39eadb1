//! This node's part among the fusion nodes of its site: heartbeats and liveliness in, heartbeats and the epoch of its poses out. Who
//! publishes is decided by `sextant_election`.

use sextant_election::{Company, Election, Input, Link, Moment};
use sextant_process::SteadyClock;
use sextant_proto::{Heartbeat, KeyRef, Keys, Kind, NodeId};
use sextant_zenoh_bus::{
    AliveWatch, Bus, BusError, DropRule, Presence, Publisher, Qos, Subscription,
};

/// Most heartbeats that wait: three seconds of those of sixteen nodes.
const QUEUE: usize = 1024;

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
}

fn moment(clock: &SteadyClock) -> Moment {
    Moment {
        monotonic_ns: clock.monotonic_ns(),
        wall_ns: clock.now_ns(),
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
        clock: &SteadyClock,
    ) -> Result<Self, BusError> {
        let longest = Kind::Heartbeat.max_bytes();
        let heartbeats = keys.all_heartbeats();
        let heartbeats = bus.subscribe(&heartbeats, QUEUE, DropRule::Oldest, longest)?;
        let company = match bus.alive_keys(&keys.all_fusion_alive())?.is_empty() {
            true => Company::Alone,
            false => Company::Others,
        };
        Ok(Self {
            election: Election::new(node.clone(), moment(clock), company),
            heartbeats,
            presence: bus.watch_alive(&keys.all_fusion_alive())?,
            publisher: bus.publisher(&keys.heartbeat(node), Qos::Pose)?,
            duty: Duty::StandBy,
            keys: keys.clone(),
        })
    }

    /// Takes in what has arrived and sends what is due; a change of duty, if there is one.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn turn(&mut self, bus: &Bus, clock: &SteadyClock) -> Result<Option<Duty>, BusError> {
        let now = moment(clock);
        let link = match bus.is_connected() {
            true => Link::Up,
            false => Link::Down,
        };
        self.election.handle(now, Input::Link(link));
        while let Some(change) = self.presence.try_recv() {
            if let Presence::Left(key) = change
                && let Some(KeyRef::Alive(_, node)) = self.keys.parse(&key)
            {
                self.election.handle(now, Input::Left(&node));
            }
        }
        while let Some(item) = self.heartbeats.try_recv() {
            if let Ok(beat) = item.decode::<Heartbeat>()
                && self.keys.heartbeat(&beat.node) == item.key
            {
                self.election.handle(now, Input::Heartbeat(&beat));
            }
        }
        self.election.handle(now, Input::Tick);
        if let Some(beat) = self.election.poll_heartbeat(now.monotonic_ns) {
            self.publisher.put(&beat)?;
        }
        Ok(self.change_of_duty())
    }

    /// The host's clock was set, or the host was suspended: others may have taken over meanwhile.
    pub fn interrupted(&mut self, clock: &SteadyClock) {
        self.election.handle(moment(clock), Input::Interrupted);
    }

    /// Epoch of the poses that this node publishes now; none while it stands by.
    pub fn epoch(&self, clock: &SteadyClock) -> Option<u64> {
        self.election.epoch(clock.monotonic_ns())
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
