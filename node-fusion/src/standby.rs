//! This node's part among the fusion nodes of its site: who publishes, and which objects, is decided by
//! `sextant_election`.
//!
//! Input: heartbeats and liveliness of the other nodes. Output: heartbeats, and the epoch of the poses. Knows no
//! network and no clock.

use crate::config::ShardingConfig;
use crate::models::ModelsInForce;
use sextant_election::{Assignment, Company, Election, Input, Link, Moment, Sharding};
use sextant_proto::{Heartbeat, ModelsState, NodeId};
use sextant_site_model::{ObjectId, ObjectModel, TagId, posed_objects};
use std::collections::BTreeSet;

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
    election: Election,
    duty: Duty,
    /// State of the models in the last heartbeat.
    published_models: ModelsState,
    /// None where one node publishes all poses.
    sharding: Option<Sharding>,
    /// Tags of objects that other nodes track.
    foreign_tags: BTreeSet<TagId>,
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
    #[must_use]
    pub fn new(
        node: &NodeId,
        sharding: &ShardingConfig,
        models: &ModelsInForce,
        company: Company,
        now: Moment,
    ) -> Self {
        let assignment = assignment(sharding);
        let mut standby = Self {
            election: Election::new(node.clone(), now, company),
            sharding: assignment.map(|one| Sharding::new(node.clone(), one, now, company)),
            foreign_tags: BTreeSet::new(),
            duty: Duty::StandBy,
            published_models: ModelsState::default(),
        };
        standby.take_models(models);
        standby
    }

    /// The state of the link to the network, whether or not it has changed.
    pub fn link(&mut self, link: Link, now: Moment) {
        self.election.handle(now, Input::Link(link));
    }

    /// The liveliness token of another node is gone.
    pub fn left(&mut self, node: &NodeId, now: Moment) {
        self.election.handle(now, Input::Left(node));
    }

    /// A heartbeat of another node.
    pub fn handle_heartbeat(&mut self, beat: &Heartbeat, now: Moment) {
        self.election.handle(now, Input::Heartbeat(beat));
        if let Some(sharding) = &mut self.sharding
            && sharding.hear(beat)
        {
            tracing::warn!(node = %beat.node, "a fusion node has another [sharding]: give all \
                nodes of the site the same mode and standbys");
        }
    }

    /// The host's clock was set, or the host was suspended: others may have taken over meanwhile.
    pub fn interrupted(&mut self, now: Moment) {
        self.election.handle(now, Input::Interrupted);
    }

    /// Does what is due; a change of duty, if there is one.
    pub fn tick(&mut self, models: &ModelsInForce, now: Moment) -> Option<Duty> {
        self.election.handle(now, Input::Tick);
        if let Some(sharding) = &mut self.sharding
            && sharding.evaluate(now, &self.election)
        {
            self.election.hasten_heartbeat(now.monotonic_ns);
            self.note_foreign_tags(models);
        }
        let duty = match self.election.claim() {
            Some(epoch) => Duty::Publish { epoch },
            None => Duty::StandBy,
        };
        let before = std::mem::replace(&mut self.duty, duty);
        (before != duty).then_some(duty)
    }

    /// The heartbeat that is due, if one is; at once where the models of this node have changed.
    pub fn poll_heartbeat(&mut self, models: &ModelsState, now: Moment) -> Option<Heartbeat> {
        if *models != self.published_models {
            self.election.hasten_heartbeat(now.monotonic_ns);
        }
        let mut beat = self.election.poll_heartbeat(now.monotonic_ns)?;
        let sharding = self.sharding.as_ref();
        beat.sharing = sharding.map(|sharding| sharding.announcement(now.monotonic_ns));
        beat.models = models.clone();
        self.published_models = models.clone();
        Some(beat)
    }

    /// The site has these models now.
    pub fn take_models(&mut self, models: &ModelsInForce) {
        if let Some(sharding) = &mut self.sharding {
            let posed = posed_objects(&models.rig, &models.objects);
            sharding.set_objects(posed.iter());
            self.note_foreign_tags(models);
        }
    }

    /// The tags of landmarks are needed wherever a carrier of cameras is tracked.
    fn note_foreign_tags(&mut self, models: &ModelsInForce) {
        let others = models
            .objects
            .iter()
            .filter(|object| !self.tracks(object.id()) && object.world_from_object().is_none());
        let tags = others.flat_map(ObjectModel::tags).map(|tag| tag.tag);
        self.foreign_tags = tags.collect();
    }

    /// Whether this node cares for what concerns the whole site, also while it waits for the others after an
    /// interruption.
    #[must_use]
    pub fn leads(&self) -> bool {
        self.duty != Duty::StandBy
    }

    /// Epoch of the poses that this node publishes now; none while it stands by.
    #[must_use]
    pub fn epoch(&self, now: Moment) -> Option<u64> {
        self.election.epoch(now.monotonic_ns)
    }

    /// Epoch of the poses of an object that this node publishes now; none where another node does.
    #[must_use]
    pub fn epoch_of(&self, object: &ObjectId, now: Moment) -> Option<u64> {
        let Some(sharding) = &self.sharding else {
            return self.epoch(now);
        };
        let is_sure = self.election.is_sure(now.monotonic_ns);
        sharding.epoch(object).filter(|_| is_sure)
    }

    /// The newest epoch of the poses that this node publishes; none while it publishes none.
    #[must_use]
    pub fn newest_epoch(&self, now: Moment) -> Option<u64> {
        match &self.sharding {
            Some(sharding) => sharding.newest_epoch(),
            None => self.epoch(now),
        }
    }

    /// Whether the objects of the site are shared among its fusion nodes.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.sharding.is_some()
    }

    /// Whether this node tracks an object.
    #[must_use]
    pub fn tracks(&self, object: &ObjectId) -> bool {
        let sharding = self.sharding.as_ref();
        sharding.is_none_or(|sharding| sharding.tracks(object))
    }

    /// Whether a tag is on an object that other nodes track.
    #[must_use]
    pub fn is_foreign(&self, tag: &TagId) -> bool {
        self.foreign_tags.contains(tag)
    }

    /// The estimator tracks the object well.
    pub fn see(&mut self, object: &ObjectId, now: Moment) {
        if let Some(sharding) = &mut self.sharding {
            sharding.see(object, now.monotonic_ns);
        }
    }

    /// When the next turn is due, ns by the monotonic clock.
    #[must_use]
    pub fn due_ns(&self) -> u64 {
        self.election.poll_timeout()
    }
}
