//! What an operator watches: counts, rates, latencies and states of the whole site, from the messages that the bridge takes in anyway;
//! as metrics of Prometheus ([`text`]) and as a verdict on the site's health ([`health`]).
//!
//! Ids come from the network: each map is bounded, and what nothing is heard of is forgotten.

mod health;
mod histogram;
mod record;
mod samples;
mod text;

pub(crate) use health::Ailment;
pub(crate) use samples::{BridgeFigures, CONTENT_TYPE};

use record::{CameraRecord, FusionRecord, ObjectRecord};
use sextant_proto::{
    CameraStatus, ClockReport, FusionStatus, NodeId, NodeKind, ObjectConfig, ObjectPose,
    Observations, RigConfig,
};
use sextant_site_model::{CameraId, ObjectId};
use sextant_tag_families::Family;
use sextant_zenoh_bus::BoundedMap;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Ids that are kept.
const MAX_CAMERAS: usize = 256;
const MAX_OBJECTS: usize = 1024;
const MAX_FUSION_NODES: usize = 64;
const MAX_NODES: usize = 512;
/// Tags whose objects are known.
const MAX_TAGS: usize = 16_384;
/// How long an id without news is kept.
const EXPIRY: Duration = Duration::from_secs(300);

/// When something happened, by both clocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// For periods on this machine.
    pub(crate) at: Instant,
    /// For latencies: ns since the Unix epoch.
    pub(crate) ns: u64,
}

/// A tag: its family and number.
type Tag = (Family, u32);

/// The figures of the site.
#[derive(Debug)]
pub(crate) struct Metrics {
    figures: Mutex<Figures>,
}

#[derive(Debug)]
struct Figures {
    cameras: BoundedMap<CameraId, CameraRecord>,
    objects: BoundedMap<ObjectId, ObjectRecord>,
    fusion: BoundedMap<NodeId, FusionRecord>,
    /// Living nodes, and since when.
    alive: BoundedMap<(NodeKind, NodeId), Instant>,
    rig: BTreeSet<CameraId>,
    object_of_tag: BTreeMap<Tag, ObjectId>,
}

impl Default for Metrics {
    fn default() -> Self {
        Self {
            figures: Mutex::new(Figures {
                cameras: BoundedMap::new(MAX_CAMERAS, EXPIRY),
                objects: BoundedMap::new(MAX_OBJECTS, EXPIRY),
                fusion: BoundedMap::new(MAX_FUSION_NODES, EXPIRY),
                alive: BoundedMap::new(MAX_NODES, EXPIRY),
                rig: BTreeSet::new(),
                object_of_tag: BTreeMap::new(),
            }),
        }
    }
}

/// Changes a record, a new one if need be; a new id beyond the bound is ignored.
fn update<K: Ord + Clone, V: Default>(
    map: &mut BoundedMap<K, V>,
    now: Instant,
    key: &K,
    change: impl FnOnce(&mut V),
) {
    let mut record = map.remove(key).unwrap_or_default();
    change(&mut record);
    let _ = map.insert(now, key.clone(), record);
}

impl Metrics {
    pub(crate) fn observations(&self, message: &Observations, now: Moment) {
        let mut figures = self.lock();
        update(&mut figures.cameras, now.at, &message.camera, |camera| {
            camera.take_image(message, now);
        });
        let tags = message.tags.iter().map(|tag| (tag.family, tag.id));
        let seen = tags.filter_map(|tag| figures.object_of_tag.get(&tag).cloned());
        let seen: BTreeSet<ObjectId> = seen.collect();
        for object in &seen {
            update(&mut figures.objects, now.at, object, |object| {
                object.is_seen(now.at);
            });
        }
    }

    pub(crate) fn camera_status(&self, status: &CameraStatus, now: Moment) {
        update(&mut self.lock().cameras, now.at, &status.camera, |camera| {
            camera.status = Some(status.clone());
        });
    }

    pub(crate) fn pose(&self, pose: &ObjectPose, now: Moment) {
        update(&mut self.lock().objects, now.at, &pose.object, |object| {
            object.take_pose(pose, now);
        });
    }

    pub(crate) fn fusion_status(&self, status: &FusionStatus, now: Moment) {
        update(&mut self.lock().fusion, now.at, &status.node, |node| {
            node.status = Some((status.clone(), now.at));
        });
    }

    pub(crate) fn clocks(&self, report: &ClockReport, now: Moment) {
        update(&mut self.lock().fusion, now.at, &report.node, |node| {
            node.clocks = report.cameras.clone();
        });
    }

    pub(crate) fn rig(&self, rig: &RigConfig) {
        self.lock().rig = rig.cameras.iter().map(|camera| camera.id.clone()).collect();
    }

    /// A new model of an object, or its removal.
    pub(crate) fn object(&self, object: &ObjectConfig) {
        let mut figures = self.lock();
        figures.object_of_tag.retain(|_, owner| *owner != object.id);
        if object.is_removal() {
            figures.objects.remove(&object.id);
        }
        for tag in &object.tags {
            if figures.object_of_tag.len() < MAX_TAGS {
                let tag = (tag.family, tag.id);
                figures.object_of_tag.insert(tag, object.id.clone());
            }
        }
    }

    pub(crate) fn presence(&self, kind: NodeKind, node: &NodeId, up: bool, now: Moment) {
        let (mut figures, key) = (self.lock(), (kind, node.clone()));
        if up {
            let _ = figures.alive.insert_lasting(now.at, key, now.at);
        } else {
            figures.alive.remove(&key);
        }
    }

    /// Forgets what nothing is heard of.
    pub(crate) fn expire(&self, now: Instant) {
        let mut figures = self.lock();
        figures.cameras.expire(now);
        figures.objects.expire(now);
        figures.fusion.expire(now);
    }

    /// What keeps the site from working; nothing if it works.
    pub(crate) fn ailments(&self, now: Instant) -> Vec<Ailment> {
        self.lock().ailments(now)
    }

    /// All metrics, in the text format of Prometheus.
    pub(crate) fn text(&self, bridge: &BridgeFigures, now: Instant) -> String {
        self.lock().text(bridge, now)
    }

    fn lock(&self) -> MutexGuard<'_, Figures> {
        // Nothing under the lock panics half way, so poisoned figures are whole ones.
        self.figures.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests;
