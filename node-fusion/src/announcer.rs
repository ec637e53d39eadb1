//! Announces the models in force, and replies to those who join late: the part of the one node that publishes the poses.

use crate::models::{Change, Models};
use sextant_proto::{ANNOUNCED, CameraSettings, KeyRef, Keys, NodeId, ObjectConfig, RigConfig};
use sextant_site_model::{CameraId, ObjectId, ObjectModel};
use sextant_zenoh_bus::{Bus, BusError, Latest, Qos};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Announces until it is dropped.
pub struct Announcer<'a> {
    bus: &'a Bus,
    keys: Keys,
    sender: String,
    rig: Latest<RigConfig>,
    objects: BTreeMap<ObjectId, Latest<ObjectConfig>>,
    /// Of cameras that have settings.
    cameras: BTreeMap<CameraId, Latest<CameraSettings>>,
}

impl<'a> Announcer<'a> {
    /// Announces these models.
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
        let mut announcer = Self {
            bus,
            keys: keys.clone(),
            rig: rig.signed(&sender),
            sender,
            objects: BTreeMap::new(),
            cameras: BTreeMap::new(),
        };
        announcer.rig.put(&RigConfig::from(&models.rig))?;
        for object in &models.objects {
            announcer.object(object)?;
        }
        for settings in models.settings.values() {
            announcer.settings(settings)?;
        }
        Ok(announcer)
    }

    /// Announces a change that is in force.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn change(&mut self, change: &Change) -> Result<(), BusError> {
        match change {
            Change::Rig(rig) => self.rig.put(&RigConfig::from(rig)),
            Change::Object(object) => self.object(object),
            Change::Removal(id) => self.removal(id),
            Change::Camera(settings) => self.settings(settings),
        }
    }

    /// Announces again what is in force of something, for those who received a change that was refused.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn again(&mut self, about: &KeyRef, models: &Models) -> Result<(), BusError> {
        match about {
            KeyRef::ConfigObject(id) => {
                match models.objects.iter().find(|object| object.id() == id) {
                    Some(object) => self.object(object),
                    None => self.removal(id),
                }
            }
            KeyRef::ConfigCamera(id) => {
                let settings = models.settings.get(id).cloned();
                self.settings(&settings.unwrap_or_else(|| CameraSettings::none(id.clone())))
            }
            // A proposal is taken for a model by no subscriber.
            KeyRef::ConfigModels => Ok(()),
            _ => self.rig.put(&RigConfig::from(&models.rig)),
        }
    }

    fn object(&mut self, object: &ObjectModel) -> Result<(), BusError> {
        let id = object.id();
        let publisher = match self.objects.entry(id.clone()) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let key = self.keys.config_object(id);
                let latest = self.bus.latest_publisher(&key, Qos::Config)?;
                place.insert(latest.signed(&self.sender))
            }
        };
        publisher.put(&ObjectConfig::from(object))
    }

    /// Those who join late hear nothing of it.
    fn removal(&mut self, id: &ObjectId) -> Result<(), BusError> {
        self.objects.remove(id);
        let key = self.keys.config_object(id);
        let publisher = self.bus.publisher::<ObjectConfig>(&key, Qos::Config)?;
        publisher
            .signed(&self.sender)
            .put(&ObjectConfig::removal(id.clone()))
    }

    /// Settings without a value are announced once, and those who join late hear nothing of them.
    fn settings(&mut self, settings: &CameraSettings) -> Result<(), BusError> {
        let id = &settings.camera;
        let publisher = match self.cameras.remove(id) {
            Some(known) => known,
            None => {
                let key = self.keys.config_camera(id);
                let latest = self.bus.latest_publisher(&key, Qos::Config)?;
                latest.signed(&self.sender)
            }
        };
        publisher.put(settings)?;
        if !settings.is_none() {
            self.cameras.insert(id.clone(), publisher);
        }
        Ok(())
    }
}
