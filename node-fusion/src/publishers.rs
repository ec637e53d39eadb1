//! Everything that a fusion node publishes itself: poses, status, clocks, answers, proposals, and its models for the other fusion nodes.

use crate::formers::Formers;
use crate::models::{Models, Payloads};
use sextant_proto::{
    ClockReport, ConfigAnswer, FusionInputs, FusionStatus, Keys, NodeId, ObjectConfig, ObjectLinks,
    ObjectPose, Proposal, RigConfig,
};
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::ObjectEstimate;
use sextant_zenoh_bus::{Bus, BusError, Latest, Publisher, Qos, Shelf};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// The publishers of one fusion node.
pub struct Publishers<'a> {
    bus: &'a Bus,
    keys: Keys,
    node: NodeId,
    objects: BTreeMap<ObjectId, ObjectPublishers>,
    models: Shelf,
    status: Latest<FusionStatus>,
    clocks: Latest<ClockReport>,
    inputs: Publisher<FusionInputs>,
    answers: Latest<ConfigAnswer>,
    proposal: Latest<Proposal>,
    former: Latest<Proposal>,
    former_rig: Latest<RigConfig>,
    former_objects: BTreeMap<ObjectId, Latest<ObjectConfig>>,
    unpublished: Unpublished,
}

/// Messages dropped because a value was out of range, or because they were held up.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Unpublished {
    /// How many since the process started.
    pub messages: u64,
    /// Cause of the last one.
    pub cause: String,
}

impl Unpublished {
    /// Whether the message was published; one that cannot be encoded is counted and dropped.
    fn check(&mut self, sent: Result<(), BusError>) -> Result<bool, BusError> {
        match sent {
            Ok(()) => Ok(true),
            Err(broken @ BusError::Message { .. }) => {
                self.count(broken.to_string());
                Ok(false)
            }
            Err(other) => Err(other),
        }
    }

    fn count(&mut self, cause: String) {
        self.messages = self.messages.saturating_add(1);
        self.cause = cause;
    }
}

struct ObjectPublishers {
    poses: Publisher<ObjectPose>,
    /// Sequence number of the last pose.
    sequence: u64,
    /// None for a rigid object.
    links: Option<Publisher<ObjectLinks>>,
}

impl<'a> Publishers<'a> {
    /// Declares every publisher.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn open(
        bus: &'a Bus,
        keys: &Keys,
        node: &NodeId,
        models: &Models,
    ) -> Result<Self, BusError> {
        let mut publishers = Self {
            bus,
            keys: keys.clone(),
            objects: BTreeMap::new(),
            models: bus.shelf(&keys.models_of(node))?,
            status: bus.latest_publisher(&keys.fusion_status(node), Qos::Status)?,
            clocks: bus.latest_publisher(&keys.clocks(node), Qos::Status)?,
            inputs: bus.publisher(&keys.inputs(node), Qos::Status)?,
            answers: bus.latest_publisher(&keys.config_answer(node), Qos::Config)?,
            proposal: bus.latest_publisher(&keys.proposal(node), Qos::Config)?,
            former: bus.latest_publisher(&keys.former(node), Qos::Config)?,
            former_rig: bus.latest_publisher(&keys.former_rig(node), Qos::Config)?,
            former_objects: BTreeMap::new(),
            node: node.clone(),
            unpublished: Unpublished::default(),
        };
        for object in &models.objects {
            publishers.put_object(object)?;
        }
        Ok(publishers)
    }

    /// Has the other fusion nodes that ask get these models.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn models(&self, payloads: &Payloads) -> Result<(), BusError> {
        self.models.replace(payloads.iter())
    }

    /// Declares the publishers of a new or changed object.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn put_object(&mut self, object: &ObjectModel) -> Result<(), BusError> {
        let id = object.id();
        let links = match object.articulation() {
            Some(_) => Some(self.bus.publisher(&self.keys.links(id), Qos::Pose)?),
            None => None,
        };
        let publishers = match self.objects.entry(id.clone()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(ObjectPublishers {
                poses: self.bus.publisher(&self.keys.pose(id), Qos::Pose)?,
                sequence: 0,
                links: None,
            }),
        };
        publishers.links = links;
        Ok(())
    }

    /// Drops the publishers of a removed object.
    pub fn remove_object(&mut self, id: &ObjectId) {
        self.objects.remove(id);
    }

    /// A pose that was held up in this node is not current any more: it is counted, and not published.
    pub fn count_held_up(&mut self, object: &ObjectId, held_s: f64) {
        self.unpublished.count(format!(
            "a pose of object {object} was held up for {held_s:.1} s in this node: its machine stood still, or is too slow"
        ));
    }

    /// Publishes an estimate under an epoch at `now_ns`; whether it could be encoded.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn pose(
        &mut self,
        estimate: &ObjectEstimate,
        epoch: u64,
        now_ns: u64,
    ) -> Result<bool, BusError> {
        let Some(publishers) = self.objects.get_mut(&estimate.object) else {
            return Ok(false);
        };
        let pose = ObjectPose::from_estimate(estimate, epoch, publishers.sequence + 1, now_ns);
        if !self.unpublished.check(publishers.poses.put(&pose))? {
            return Ok(false);
        }
        publishers.sequence += 1;
        let links = ObjectLinks::from_estimate(estimate, &pose);
        match publishers.links.as_ref().zip(links) {
            Some((publisher, links)) => self.unpublished.check(publisher.put(&links)),
            None => Ok(true),
        }
    }

    /// Publishes the status.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn status(&mut self, status: &FusionStatus) -> Result<(), BusError> {
        self.unpublished.check(self.status.put(status)).map(drop)
    }

    /// Publishes the estimated clock offsets.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn clocks(&mut self, report: &ClockReport) -> Result<(), BusError> {
        self.unpublished.check(self.clocks.put(report)).map(drop)
    }

    /// Publishes inputs of the estimator, for recordings.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn inputs(&mut self, inputs: &FusionInputs) -> Result<(), BusError> {
        self.unpublished.check(self.inputs.put(inputs)).map(drop)
    }

    /// Answers whoever published a change.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn answer(&mut self, answer: &ConfigAnswer) -> Result<(), BusError> {
        self.unpublished.check(self.answers.put(answer)).map(drop)
    }

    /// Publishes a refined calibration, or an empty proposal.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn proposal(&mut self, proposal: &Proposal) -> Result<(), BusError> {
        let sent = self.proposal.put(proposal);
        self.unpublished.check(sent).map(drop)
    }

    /// Publishes the models before the last change.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn formers(&mut self, formers: &Formers) -> Result<(), BusError> {
        if let Some(former) = &formers.rig {
            let sent = self.former_rig.put(&RigConfig::from(&former.model));
            self.unpublished.check(sent)?;
        }
        self.former_objects
            .retain(|id, _| formers.objects.contains_key(id));
        for (id, former) in &formers.objects {
            let publisher = match self.former_objects.entry(id.clone()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(place) => {
                    let key = self.keys.former_object(&self.node, id);
                    place.insert(self.bus.latest_publisher(&key, Qos::Config)?)
                }
            };
            let sent = publisher.put(&ObjectConfig::from(&former.model));
            self.unpublished.check(sent)?;
        }
        let last = formers.last(&self.node).map_err(|cause| BusError::Message {
            key: self.former.key().to_owned(),
            cause: cause.to_string(),
        });
        let sent = last.and_then(|last| self.former.put(&last));
        self.unpublished.check(sent).map(drop)
    }

    /// The messages that could not be published.
    pub fn unpublished(&self) -> &Unpublished {
        &self.unpublished
    }
}
