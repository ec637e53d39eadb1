//! The publishers of a fusion node: a pose per object, the models for late joiners, the status.

use crate::links::LinksOutlet;
use sextant_estimator::{ObjectEstimate, ObjectId, ObjectModel, Rig};
use sextant_proto::{FusionStatus, Keys, NodeId, ObjectConfig, ObjectPose, RigConfig};
use sextant_zenoh_bus::{Bus, BusError, Latest, Publisher, Qos};
use std::collections::BTreeMap;

/// Everything that this node says.
pub struct Outlet {
    poses: BTreeMap<ObjectId, PoseOutlet>,
    links: LinksOutlet,
    status: Latest<FusionStatus>,
    /// Held for its answers to late joiners.
    _rig: Latest<RigConfig>,
    /// Likewise.
    _objects: Vec<Latest<ObjectConfig>>,
}

struct PoseOutlet {
    publisher: Publisher<ObjectPose>,
    sequence: u64,
}

impl Outlet {
    /// Declares every publisher and publishes the models.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn open(
        bus: &Bus,
        keys: &Keys,
        node: &NodeId,
        rig: &Rig,
        objects: &[ObjectModel],
    ) -> Result<Self, BusError> {
        let rig_outlet = bus.latest_publisher(&keys.config_rig(), Qos::Config)?;
        rig_outlet.put(&RigConfig::from(rig))?;
        let mut poses = BTreeMap::new();
        let mut configs = Vec::new();
        let mut links = LinksOutlet::default();
        for object in objects {
            links.take(bus, keys, object)?;
            if object.articulation().is_none() {
                let config = bus.latest_publisher(&keys.config_object(object.id()), Qos::Config)?;
                config.put(&ObjectConfig::from(object))?;
                configs.push(config);
            }
            let publisher = bus.publisher(&keys.pose(object.id()), Qos::Pose)?;
            poses.insert(
                object.id().clone(),
                PoseOutlet {
                    publisher,
                    sequence: 0,
                },
            );
        }
        let status = bus.latest_publisher(&keys.fusion_status(node), Qos::Status)?;
        Ok(Self {
            poses,
            links,
            status,
            _rig: rig_outlet,
            _objects: configs,
        })
    }

    /// Publishes an estimate at `now_ns`.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn pose(&mut self, estimate: &ObjectEstimate, now_ns: u64) -> Result<(), BusError> {
        let Some(outlet) = self.poses.get_mut(&estimate.object) else {
            return Ok(());
        };
        outlet.sequence += 1;
        let message = ObjectPose::from_estimate(estimate, outlet.sequence, now_ns);
        outlet.publisher.put(&message)?;
        self.links.publish(estimate, &message)
    }

    /// Publishes the status.
    ///
    /// # Errors
    /// When the network session has ended.
    pub fn status(&self, status: &FusionStatus) -> Result<(), BusError> {
        self.status.put(status)
    }
}
