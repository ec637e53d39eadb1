//! Everything that a fusion node publishes: poses, status, clocks, answers, proposals, and the models for late joiners.

use crate::formers::Formers;
use crate::models::Models;
use sextant_proto::{
    ANNOUNCED, CameraSettings, ClockReport, ConfigAnswer, FusionInputs, FusionStatus, Keys, NodeId,
    ObjectConfig, ObjectLinks, ObjectPose, Proposal, RigConfig,
};
use sextant_site_model::{CameraId, ObjectId, ObjectModel, Rig};
use sextant_site_report::ObjectEstimate;
use sextant_zenoh_bus::{Bus, BusError, Latest, Publisher, Qos};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Sender of a refinement that a node applies: not an announcement, so that other fusion nodes apply it as well.
const REFINEMENT: &str = "refinement";

/// The publishers of one fusion node.
pub struct Publishers<'a> {
    bus: &'a Bus,
    keys: Keys,
    node: NodeId,
    /// Sender of what this node announces.
    sender: String,
    objects: BTreeMap<ObjectId, ObjectPublishers>,
    rig: Latest<RigConfig>,
    /// Of cameras that have settings.
    cameras: BTreeMap<CameraId, Latest<CameraSettings>>,
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

/// Messages dropped because a value was out of range.
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
                self.messages = self.messages.saturating_add(1);
                self.cause = broken.to_string();
                Ok(false)
            }
            Err(other) => Err(other),
        }
    }
}

struct ObjectPublishers {
    poses: Publisher<ObjectPose>,
    /// Sequence number of the last pose.
    sequence: u64,
    /// None for a rigid object.
    links: Option<Publisher<ObjectLinks>>,
    config: Latest<ObjectConfig>,
}

impl<'a> Publishers<'a> {
    /// Declares every publisher and announces the models.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn open(
        bus: &'a Bus,
        keys: &Keys,
        node: &NodeId,
        models: &Models,
    ) -> Result<Self, BusError> {
        let sender = format!("{ANNOUNCED}{node}");
        let rig = bus.latest_publisher(&keys.config_rig(), Qos::Config)?;
        let mut publishers = Self {
            bus,
            keys: keys.clone(),
            objects: BTreeMap::new(),
            cameras: BTreeMap::new(),
            rig: rig.signed(&sender),
            sender,
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
        publishers.announce_rig(&models.rig)?;
        for object in &models.objects {
            publishers.put_object(object)?;
            publishers.announce_object(object.id())?;
        }
        for settings in models.settings.values() {
            publishers.announce_settings(settings)?;
        }
        Ok(publishers)
    }

    /// Announces the settings in force of a camera; those without a value once, and late joiners hear nothing of them.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce_settings(&mut self, settings: &CameraSettings) -> Result<(), BusError> {
        let publisher = match self.cameras.entry(settings.camera.clone()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let key = self.keys.config_camera(&settings.camera);
                let latest = self.bus.latest_publisher(&key, Qos::Config)?;
                place.insert(latest.signed(&self.sender))
            }
        };
        publisher.put(settings)?;
        if settings.is_none() {
            self.cameras.remove(&settings.camera);
        }
        Ok(())
    }

    /// Announces the rig in force.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce_rig(&self, rig: &Rig) -> Result<(), BusError> {
        self.rig.put(&RigConfig::from(rig))
    }

    /// Asks every node of the site, other fusion nodes included, to apply a refined rig.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn request_rig(&self, rig: &Rig) -> Result<(), BusError> {
        let key = self.keys.config_rig();
        let publisher = self.bus.publisher::<RigConfig>(&key, Qos::Config)?;
        publisher.signed(REFINEMENT).put(&RigConfig::from(rig))
    }

    /// Asks every node of the site, other fusion nodes included, to apply a refined object.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn request_object(&self, object: &ObjectModel) -> Result<(), BusError> {
        let key = self.keys.config_object(object.id());
        let publisher = self.bus.publisher::<ObjectConfig>(&key, Qos::Config)?;
        publisher
            .signed(REFINEMENT)
            .put(&ObjectConfig::from(object))
    }

    /// Declares the publishers of a new or changed object and keeps its model for late joiners.
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
            Entry::Vacant(place) => {
                let config = self
                    .bus
                    .latest_publisher(&self.keys.config_object(id), Qos::Config)?;
                place.insert(ObjectPublishers {
                    poses: self.bus.publisher(&self.keys.pose(id), Qos::Pose)?,
                    sequence: 0,
                    links: None,
                    config: config.signed(&self.sender),
                })
            }
        };
        publishers.links = links;
        publishers.config.keep(&ObjectConfig::from(object))
    }

    /// Drops the publishers of a removed object.
    pub fn remove_object(&mut self, id: &ObjectId) {
        self.objects.remove(id);
    }

    /// Announces what is in force of an object: its model, or that it does not exist.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce_object(&self, id: &ObjectId) -> Result<(), BusError> {
        if let Some(publishers) = self.objects.get(id) {
            return publishers.config.put_again();
        }
        let key = self.keys.config_object(id);
        let publisher = self.bus.publisher::<ObjectConfig>(&key, Qos::Config)?;
        publisher
            .signed(&self.sender)
            .put(&ObjectConfig::removal(id.clone()))
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
