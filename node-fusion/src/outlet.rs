//! The publishers of a fusion node: a pose per object, the models for late joiners, status, clocks, answers.

use crate::changes::ANNOUNCED;
use crate::formers::Formers;
use crate::links::LinksOutlet;
use crate::models::Models;
use sextant_estimator::{ObjectEstimate, ObjectId, ObjectModel, Rig};
use sextant_proto::{
    ClockReport, ConfigAnswer, FullObject, FullRig, FusionStatus, Keys, NodeId, ObjectConfig,
    ObjectPose, Proposal, RigConfig,
};
use sextant_zenoh_bus::{Bus, BusError, Latest, Publisher, Qos};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Signature of what a refinement has changed: no announcement, so that other fusion nodes take it.
const REFINED: &str = "refinement";

/// Everything that this node says.
pub struct Outlet<'a> {
    bus: &'a Bus,
    keys: Keys,
    node: NodeId,
    signature: String,
    objects: BTreeMap<ObjectId, ObjectOutlet>,
    links: LinksOutlet,
    rig: Latest<RigConfig>,
    full_rig: Latest<FullRig>,
    status: Latest<FusionStatus>,
    clocks: Latest<ClockReport>,
    answers: Latest<ConfigAnswer>,
    proposal: Latest<Proposal>,
    former: Latest<Proposal>,
    former_rig: Latest<FullRig>,
    former_objects: BTreeMap<ObjectId, Latest<FullObject>>,
    unpublished: Unpublished,
}

/// Messages that break their own contract, a pose out of range for example: they don't leave.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Unpublished {
    /// How many since the process started.
    pub messages: u64,
    /// Why the last one was.
    pub cause: String,
}

impl Unpublished {
    /// Whether the message was published; one that can't be encoded is counted and dropped.
    fn passed(&mut self, sent: Result<(), BusError>) -> Result<bool, BusError> {
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

struct ObjectOutlet {
    poses: Publisher<ObjectPose>,
    sequence: u64,
    /// Answers late joiners; silent where the object has links, which say what it is made of themselves.
    config: Latest<ObjectConfig>,
    /// Answers late joiners who want to know all that is stated.
    full: Latest<FullObject>,
}

impl<'a> Outlet<'a> {
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
        let signature = format!("{ANNOUNCED}{node}");
        let rig = bus.latest_publisher(&keys.config_rig(), Qos::Config)?;
        let full_rig = bus.latest_publisher(&keys.full_rig(), Qos::Config)?;
        let mut outlet = Self {
            bus,
            keys: keys.clone(),
            objects: BTreeMap::new(),
            links: LinksOutlet::default(),
            rig: rig.signed(&signature),
            full_rig: full_rig.signed(&signature),
            signature,
            status: bus.latest_publisher(&keys.fusion_status(node), Qos::Status)?,
            clocks: bus.latest_publisher(&keys.clocks(node), Qos::Status)?,
            answers: bus.latest_publisher(&keys.config_answer(node), Qos::Config)?,
            proposal: bus.latest_publisher(&keys.proposal(node), Qos::Config)?,
            former: bus.latest_publisher(&keys.former(node), Qos::Config)?,
            former_rig: bus.latest_publisher(&keys.former_rig(node), Qos::Config)?,
            former_objects: BTreeMap::new(),
            node: node.clone(),
            unpublished: Unpublished::default(),
        };
        outlet.announce_rig(&models.rig)?;
        for object in &models.objects {
            outlet.take_object(object)?;
            outlet.announce_object(object.id())?;
        }
        Ok(outlet)
    }

    /// Tells everyone which cameras are in force.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce_rig(&self, rig: &Rig) -> Result<(), BusError> {
        self.rig.put(&RigConfig::from(rig))?;
        self.full_rig.put(&FullRig::from(rig))
    }

    /// Asks everyone, other fusion nodes too, to work from the rig, in the name of this node's refinement.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn hand_out_rig(&self, rig: &Rig) -> Result<(), BusError> {
        let key = self.keys.full_rig();
        let publisher = self.bus.publisher::<FullRig>(&key, Qos::Config)?;
        publisher.signed(REFINED).put(&FullRig::from(rig))
    }

    /// The same of an object.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn hand_out_object(&self, object: &ObjectModel) -> Result<(), BusError> {
        let key = self.keys.full_object(object.id());
        let publisher = self.bus.publisher::<FullObject>(&key, Qos::Config)?;
        publisher.signed(REFINED).put(&FullObject::from(object))
    }

    /// An object is there or has changed: late joiners shall hear it.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn take_object(&mut self, object: &ObjectModel) -> Result<(), BusError> {
        let id = object.id();
        if self.links.has(id) != object.articulation().is_some() {
            // What it was made of is said by others now.
            self.objects.remove(id);
        }
        if !self.objects.contains_key(id) {
            let config = self.config_outlet(id)?;
            let key = self.keys.full_object(id);
            let full = self.bus.latest_publisher(&key, Qos::Config)?;
            let outlet = ObjectOutlet {
                poses: self.bus.publisher(&self.keys.pose(id), Qos::Pose)?,
                sequence: 0,
                config,
                full: full.signed(&self.signature),
            };
            self.objects.insert(id.clone(), outlet);
        }
        self.links.forget(id);
        let signature = self.signature.clone();
        self.links.take(self.bus, &self.keys, object, &signature)?;
        let Some(outlet) = self.objects.get(id) else {
            return Ok(());
        };
        outlet.full.keep(&FullObject::from(object))?;
        if object.articulation().is_none() {
            outlet.config.keep(&ObjectConfig::from(object))?;
        }
        Ok(())
    }

    /// An object is gone; everyone present has heard it.
    pub fn forget_object(&mut self, id: &ObjectId) {
        self.objects.remove(id);
        self.links.forget(id);
    }

    /// Tells everyone what is in force of an object; that there is none, where there is none.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce_object(&self, id: &ObjectId) -> Result<(), BusError> {
        if let Some(outlet) = self.objects.get(id) {
            self.links.announce(id)?;
            outlet.full.put_again()?;
            return outlet.config.put_again();
        }
        let none = ObjectConfig {
            id: id.clone(),
            tags: Vec::new(),
        };
        self.config_outlet(id)?.put(&none)
    }

    /// Publishes an estimate at `now_ns`; whether it could be encoded.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn pose(&mut self, estimate: &ObjectEstimate, now_ns: u64) -> Result<bool, BusError> {
        let Some(outlet) = self.objects.get_mut(&estimate.object) else {
            return Ok(false);
        };
        let message = ObjectPose::from_estimate(estimate, outlet.sequence + 1, now_ns);
        if !self.unpublished.passed(outlet.poses.put(&message))? {
            return Ok(false);
        }
        outlet.sequence += 1;
        self.unpublished
            .passed(self.links.publish(estimate, &message))
    }

    /// Publishes the status.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn status(&mut self, status: &FusionStatus) -> Result<(), BusError> {
        self.unpublished.passed(self.status.put(status)).map(drop)
    }

    /// Publishes what is known of the clocks.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn clocks(&mut self, report: &ClockReport) -> Result<(), BusError> {
        self.unpublished.passed(self.clocks.put(report)).map(drop)
    }

    /// Answers whoever published a change.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn answer(&mut self, answer: &ConfigAnswer) -> Result<(), BusError> {
        self.unpublished.passed(self.answers.put(answer)).map(drop)
    }

    /// Publishes a refined calibration, or that there is none.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn proposal(&mut self, proposal: &Proposal) -> Result<(), BusError> {
        let sent = self.proposal.put(proposal);
        self.unpublished.passed(sent).map(drop)
    }

    /// Publishes what takes the last change back.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn formers(&mut self, formers: &Formers) -> Result<(), BusError> {
        if let Some(former) = &formers.rig {
            let sent = self.former_rig.put(&FullRig::from(&former.model));
            self.unpublished.passed(sent)?;
        }
        self.former_objects
            .retain(|id, _| formers.objects.contains_key(id));
        for (id, former) in &formers.objects {
            let outlet = match self.former_objects.entry(id.clone()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(place) => {
                    let key = self.keys.former_object(&self.node, id);
                    place.insert(self.bus.latest_publisher(&key, Qos::Config)?)
                }
            };
            let sent = outlet.put(&FullObject::from(&former.model));
            self.unpublished.passed(sent)?;
        }
        let last = formers.last(&self.node).map_err(|cause| BusError::Message {
            key: self.former.key().to_owned(),
            cause: cause.to_string(),
        });
        let sent = last.and_then(|last| self.former.put(&last));
        self.unpublished.passed(sent).map(drop)
    }

    /// The messages that could not be published.
    pub fn unpublished(&self) -> &Unpublished {
        &self.unpublished
    }

    fn config_outlet(&self, id: &ObjectId) -> Result<Latest<ObjectConfig>, BusError> {
        let key = self.keys.config_object(id);
        let outlet = self.bus.latest_publisher(&key, Qos::Config)?;
        Ok(outlet.signed(&self.signature))
    }
}
