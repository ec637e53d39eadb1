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
    _config: Latest<ArticulatedConfig>,
}

impl LinksOutlet {
    /// Declares the publishers of an object and publishes what it is made of; nothing where it is rigid.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn take(&mut self, bus: &Bus, keys: &Keys, object: &ObjectModel) -> Result<(), BusError> {
        let Some(message) = ArticulatedConfig::of(object) else {
            return Ok(());
        };
        let config = bus.latest_publisher(&keys.config_articulated(object.id()), Qos::Config)?;
        config.put(&message)?;
        let outlet = Outlet {
            links: bus.publisher(&keys.links(object.id()), Qos::Pose)?,
            _config: config,
        };
        self.objects.insert(object.id().clone(), outlet);
        Ok(())
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
