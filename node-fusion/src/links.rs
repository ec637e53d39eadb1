//! What is published of objects that have links: their links and joints with each pose, and what they are made of, in place of
//! a rigid object's configuration.

use sextant_estimator::{ObjectEstimate, ObjectId, ObjectModel};
use sextant_proto::{ArticulatedConfig, Keys, ObjectLinks, ObjectPose};
use sextant_zenoh_bus::{Bus, BusError, Latest, Publisher, Qos};
use std::collections::BTreeMap;

/// The publishers of all objects that have links.
#[derive(Default)]
pub struct LinksOutlet {
    objects: BTreeMap<ObjectId, Outlet>,
}

struct Outlet {
    links: Publisher<ObjectLinks>,
    /// Answers late joiners.
    config: Latest<ArticulatedConfig>,
}

impl LinksOutlet {
    /// Declares the publishers of an object and keeps what it is made of for late joiners; nothing where it is rigid.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn take(
        &mut self,
        bus: &Bus,
        keys: &Keys,
        object: &ObjectModel,
        signature: &str,
    ) -> Result<(), BusError> {
        let Some(message) = ArticulatedConfig::of(object) else {
            return Ok(());
        };
        let key = keys.config_articulated(object.id());
        let config = bus.latest_publisher(&key, Qos::Config)?.signed(signature);
        config.keep(&message)?;
        let outlet = Outlet {
            links: bus.publisher(&keys.links(object.id()), Qos::Pose)?,
            config,
        };
        self.objects.insert(object.id().clone(), outlet);
        Ok(())
    }

    /// Tells everyone what the object is made of; nothing where it is rigid.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn announce(&self, object: &ObjectId) -> Result<(), BusError> {
        let outlet = self.objects.get(object);
        outlet.map_or(Ok(()), |outlet| outlet.config.put_again())
    }

    /// Whether the object has links.
    pub fn has(&self, object: &ObjectId) -> bool {
        self.objects.contains_key(object)
    }

    /// The object is gone, or another now.
    pub fn forget(&mut self, object: &ObjectId) {
        self.objects.remove(object);
    }

    /// Publishes the links beside the pose of the same estimate.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn publish(&self, estimate: &ObjectEstimate, pose: &ObjectPose) -> Result<(), BusError> {
        let outlet = self.objects.get(&estimate.object);
        match outlet.zip(ObjectLinks::from_estimate(estimate, pose)) {
            Some((outlet, message)) => outlet.links.put(&message),
            None => Ok(()),
        }
    }
}
