//! What a fusion node publishes: poses, status, clocks, answers, proposals, its models for the other fusion nodes, and,
//! while it publishes the poses, the models in force.
//!
//! Input: messages. Output: payloads under keys. Knows no network.

use crate::formers::Formers;
use crate::models::{Change, ModelsInForce, Payloads};
use sextant_proto::{
    ANNOUNCED, CameraSettings, ClockReport, ConfigAnswer, FusionInputs, FusionStatus, Heartbeat,
    KeyRef, Keys, Message, NodeId, ObjectConfig, ObjectLinks, ObjectPose, Proposal, RigConfig,
    encode,
};
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_site_report::ObjectEstimate;
use sextant_zenoh_bus::Qos;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Something to be published.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Publication {
    /// A message.
    Message(Put),
    /// Those who join late no longer get the message of this key, and nothing more comes on it for now.
    Withdrawal(String),
    /// What the other fusion nodes get that ask for keys below a root: these keys and payloads, all of one state.
    Models(String, Payloads),
}

/// A message for the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Put {
    /// Where.
    pub key: String,
    /// The encoded message.
    pub payload: Vec<u8>,
    /// Its class.
    pub qos: Qos,
    /// Whether those who join late get it.
    pub is_kept: bool,
    /// Signed by.
    pub sender: Option<String>,
}

/// Collects what is to be published.
#[derive(Debug)]
pub struct Outbox {
    keys: Keys,
    node: NodeId,
    /// The objects of the site, and the sequence number of the last pose of each.
    objects: BTreeMap<ObjectId, u64>,
    former_objects: BTreeSet<ObjectId>,
    /// Keys of the models in force that are announced; none while another node publishes the poses.
    announced: Option<BTreeSet<String>>,
    unpublished: Unpublished,
    held_up: u64,
    queue: VecDeque<Publication>,
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
    fn count(&mut self, cause: String) {
        self.messages = self.messages.saturating_add(1);
        self.cause = cause;
    }
}

impl Outbox {
    /// An empty one, for these objects.
    #[must_use]
    pub fn new(keys: Keys, node: NodeId, objects: Vec<ObjectId>) -> Self {
        let objects = objects.into_iter().map(|id| (id, 0));
        Self {
            keys,
            node,
            objects: objects.collect(),
            former_objects: BTreeSet::new(),
            announced: None,
            unpublished: Unpublished::default(),
            held_up: 0,
            queue: VecDeque::new(),
        }
    }

    /// The next thing to be published.
    pub fn poll(&mut self) -> Option<Publication> {
        self.queue.pop_front()
    }

    /// The messages that could not be published.
    #[must_use]
    pub fn unpublished(&self) -> &Unpublished {
        &self.unpublished
    }

    /// Whether the message could be encoded; another is counted and dropped.
    fn put(&mut self, message: &impl Message, put: Put) -> bool {
        match encode(message) {
            Ok(payload) => {
                self.queue
                    .push_back(Publication::Message(Put { payload, ..put }));
                true
            }
            Err(cause) => {
                self.unpublished.count(format!("{}: {cause}", put.key));
                false
            }
        }
    }

    fn stream(&mut self, key: String, qos: Qos, message: &impl Message) -> bool {
        self.put(message, Put::new(key, qos))
    }

    fn kept(&mut self, key: String, qos: Qos, message: &impl Message) -> bool {
        let put = Put {
            is_kept: true,
            ..Put::new(key, qos)
        };
        self.put(message, put)
    }
}

impl Put {
    /// Passing, unsigned, without its payload.
    fn new(key: String, qos: Qos) -> Self {
        Self {
            key,
            payload: Vec::new(),
            qos,
            is_kept: false,
            sender: None,
        }
    }
}

/// What every fusion node publishes.
impl Outbox {
    /// Publishes a heartbeat for other fusion nodes.
    pub fn heartbeat(&mut self, beat: &Heartbeat) {
        self.stream(self.keys.heartbeat(&self.node), Qos::Pose, beat);
    }

    /// The models, for other fusion nodes.
    pub fn models(&mut self, payloads: &Payloads) {
        let root = self.keys.models_of(&self.node);
        self.queue
            .push_back(Publication::Models(root, payloads.clone()));
    }

    /// Publishes the status, which late subscribers get too.
    pub fn status(&mut self, status: &FusionStatus) {
        self.kept(self.keys.fusion_status(&self.node), Qos::Status, status);
    }

    /// The estimated clock offsets.
    pub fn clocks(&mut self, report: &ClockReport) {
        self.kept(self.keys.clocks(&self.node), Qos::Status, report);
    }

    /// Inputs of the estimator, for recordings.
    pub fn inputs(&mut self, inputs: &FusionInputs) {
        self.stream(self.keys.inputs(&self.node), Qos::Status, inputs);
    }

    /// What became of a change.
    pub fn answer(&mut self, answer: &ConfigAnswer) {
        self.kept(self.keys.config_answer(&self.node), Qos::Config, answer);
    }

    /// A refined calibration, or an empty proposal.
    pub fn proposal(&mut self, proposal: &Proposal) {
        self.kept(self.keys.proposal(&self.node), Qos::Config, proposal);
    }

    /// The models before the last change.
    pub fn formers(&mut self, formers: &Formers) {
        if let Some(former) = &formers.rig {
            let key = self.keys.former_rig(&self.node);
            self.kept(key, Qos::Config, &RigConfig::from(&former.model));
        }
        let known = formers.objects.keys().cloned().collect();
        let before = std::mem::replace(&mut self.former_objects, known);
        for id in before.difference(&self.former_objects) {
            let key = self.keys.former_object(&self.node, id);
            self.queue.push_back(Publication::Withdrawal(key));
        }
        for (id, former) in &formers.objects {
            let key = self.keys.former_object(&self.node, id);
            self.kept(key, Qos::Config, &ObjectConfig::from(&former.model));
        }
        let key = self.keys.former(&self.node);
        match formers.last(&self.node) {
            Ok(last) => drop(self.kept(key, Qos::Config, &last)),
            Err(cause) => self.unpublished.count(format!("{key}: {cause}")),
        }
    }
}

/// Poses.
impl Outbox {
    /// An estimate under an epoch at `now_ns`; whether it could be encoded.
    pub fn pose(&mut self, estimate: &ObjectEstimate, epoch: u64, now_ns: u64) -> bool {
        let Some(sequence) = self.objects.get(&estimate.object).map(|last| last + 1) else {
            return false;
        };
        let pose = ObjectPose::from_estimate(estimate, epoch, sequence, now_ns);
        if !self.stream(self.keys.pose(&estimate.object), Qos::Pose, &pose) {
            return false;
        }
        self.objects.insert(estimate.object.clone(), sequence);
        match ObjectLinks::from_estimate(estimate, &pose) {
            Some(links) => self.stream(self.keys.links(&estimate.object), Qos::Pose, &links),
            None => true,
        }
    }

    /// A pose that was held up in this node is not current any more: it is counted, and not published.
    pub fn count_held_up(&mut self) {
        self.held_up = self.held_up.saturating_add(1);
    }

    /// Poses that were held up, since the process started.
    #[must_use]
    pub fn held_up(&self) -> u64 {
        self.held_up
    }

    /// The site has these objects now.
    pub fn take_objects(&mut self, objects: Vec<ObjectId>) {
        let before = std::mem::take(&mut self.objects);
        let last = |id: ObjectId| {
            let last = before.get(&id).copied().unwrap_or(0);
            (id, last)
        };
        self.objects = objects.into_iter().map(last).collect();
        for id in before.keys().filter(|id| !self.objects.contains_key(*id)) {
            for key in [self.keys.pose(id), self.keys.links(id)] {
                self.queue.push_back(Publication::Withdrawal(key));
            }
        }
    }
}

/// The models in force, which the node announces that publishes the poses.
impl Outbox {
    /// Begins to announce these models and to reply to those who join late, or ends it.
    pub fn announce(&mut self, models: Option<&ModelsInForce>) {
        let Some(models) = models else {
            let announced = self.announced.take().unwrap_or_default();
            self.queue
                .extend(announced.into_iter().map(Publication::Withdrawal));
            return;
        };
        if self.announced.is_some() {
            return;
        }
        self.announced = Some(BTreeSet::new());
        self.announce_rig(models);
        for object in &models.objects {
            self.announce_object(object);
        }
        for settings in models.settings.values() {
            self.announce_settings(settings);
        }
    }

    /// Announces changes that are in force.
    pub fn announce_changes(&mut self, changes: &[Change], models: &ModelsInForce) {
        if self.announced.is_none() {
            return;
        }
        for change in changes {
            match change {
                Change::Rig(_) => self.announce_rig(models),
                Change::Object(object) => self.announce_object(object),
                Change::Removal(id) => self.announce_removal(id),
                Change::Camera(settings) => self.announce_settings(settings),
            }
        }
    }

    /// Announces again what is in force of something, for those who received a change that was refused.
    pub fn announce_again(&mut self, about: &KeyRef, models: &ModelsInForce) {
        if self.announced.is_none() {
            return;
        }
        match about {
            KeyRef::ConfigObject(id) => {
                match models.objects.iter().find(|object| object.id() == id) {
                    Some(object) => self.announce_object(object),
                    None => self.announce_removal(id),
                }
            }
            KeyRef::ConfigCamera(id) => match models.settings.get(id) {
                Some(settings) => self.announce_settings(settings),
                None => self.announce_settings(&CameraSettings::none(id.clone())),
            },
            // Subscribers ignore proposals, so there is nothing to correct.
            KeyRef::ConfigModels => {}
            _ => self.announce_rig(models),
        }
    }

    fn announce_rig(&mut self, models: &ModelsInForce) {
        self.announced_kept(self.keys.config_rig(), &RigConfig::from(&models.rig));
    }

    fn announce_object(&mut self, object: &ObjectModel) {
        let key = self.keys.config_object(object.id());
        self.announced_kept(key, &ObjectConfig::from(object));
    }

    /// Those who join late hear nothing of it.
    fn announce_removal(&mut self, id: &ObjectId) {
        let key = self.keys.config_object(id);
        self.announced_once(key, &ObjectConfig::removal(id.clone()));
    }

    /// Settings without a value are announced once, and those who join late hear nothing of them.
    fn announce_settings(&mut self, settings: &CameraSettings) {
        let key = self.keys.config_camera(&settings.camera);
        match settings.is_none() {
            true => self.announced_once(key, settings),
            false => self.announced_kept(key, settings),
        }
    }

    fn announced_kept(&mut self, key: String, message: &impl Message) {
        let put = Put {
            is_kept: true,
            ..self.announcement(key.clone())
        };
        if self.put(message, put) {
            self.announced.get_or_insert_default().insert(key);
        }
    }

    fn announced_once(&mut self, key: String, message: &impl Message) {
        self.announced.get_or_insert_default().remove(&key);
        self.queue.push_back(Publication::Withdrawal(key.clone()));
        self.put(message, self.announcement(key.clone()));
        self.queue.push_back(Publication::Withdrawal(key));
    }

    fn announcement(&self, key: String) -> Put {
        Put {
            sender: Some(format!("{ANNOUNCED}{}", self.node)),
            ..Put::new(key, Qos::Config)
        }
    }
}
