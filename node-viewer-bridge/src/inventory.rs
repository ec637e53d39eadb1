//! The objects of each fusion node, by its statuses: an object is forgotten even if the bridge missed its removal, or if it was removed
//! while its fusion node was down.

use sextant_proto::{FusionStatus, NodeId};
use sextant_site_model::ObjectId;
use sextant_zenoh_bus::BoundedMap;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Fusion nodes that are kept in mind.
const MAX_NODES: usize = 64;
/// A node that has sent no status for so long gives way to another one.
const EXPIRY: Duration = Duration::from_secs(60);

/// The objects of each fusion node.
#[derive(Debug)]
pub(crate) struct Inventory {
    objects: BoundedMap<NodeId, BTreeSet<ObjectId>>,
}

impl Default for Inventory {
    fn default() -> Self {
        Self {
            objects: BoundedMap::new(MAX_NODES, EXPIRY),
        }
    }
}

impl Inventory {
    /// Takes a status in; the objects that its node had and that no node has any more.
    pub(crate) fn take(&mut self, now: Instant, status: &FusionStatus) -> Vec<ObjectId> {
        let objects = status.objects.iter().map(|object| object.object.clone());
        let node = status.node.clone();
        let before = self.objects.insert(now, node, objects.collect());
        let is_gone = |object: &ObjectId| !self.objects.iter().any(|(_, has)| has.contains(object));
        let before = before.ok().flatten().into_iter().flatten();
        before.filter(is_gone).collect()
    }
}

#[cfg(test)]
pub(crate) mod samples {
    use super::*;
    use sextant_proto::{ObjectHealth, Rejections};
    use sextant_site_report::State;

    pub(crate) fn status(node: &str, objects: &[&str]) -> FusionStatus {
        let health = |id: &&str| ObjectHealth {
            object: ObjectId::new(id).unwrap(),
            state: State::Tracking,
            rate_hz: 30.0,
        };
        FusionStatus {
            node: NodeId::new(node).unwrap(),
            version: String::new(),
            uptime_s: 1,
            epoch: Some(1),
            cameras: vec![],
            foreign: Rejections::default(),
            objects: objects.iter().map(health).collect(),
            faults: vec![],
            faults_left_out: 0,
            imperfections: vec![],
            notices: vec![],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::status;
    use super::*;

    fn ids(names: &[&str]) -> Vec<ObjectId> {
        let id = |name: &&str| ObjectId::new(name).unwrap();
        names.iter().map(id).collect()
    }

    #[test]
    fn an_object_is_gone_when_no_node_has_it_any_more() {
        let (mut inventory, now) = (Inventory::default(), Instant::now());
        let mut gone = |node, objects: &[&str]| inventory.take(now, &status(node, objects));
        assert!(gone("a", &["cube", "box"]).is_empty());
        assert!(gone("b", &["cube"]).is_empty());
        assert_eq!(gone("a", &[]), ids(&["box"]));
        assert_eq!(gone("b", &[]), ids(&["cube"]));
    }

    #[test]
    fn a_flood_of_nodes_neither_grows_it_nor_shuts_others_out_for_good() {
        let (mut inventory, start) = (Inventory::default(), Instant::now());
        for n in 0..10 * MAX_NODES {
            inventory.take(start, &status(&format!("n{n}"), &["cube"]));
        }
        assert_eq!(inventory.objects.len(), MAX_NODES);
        let later = start + EXPIRY;
        inventory.take(later, &status("real", &["box"]));
        let gone = inventory.take(later, &status("real", &[]));
        assert_eq!(gone, ids(&["box"]));
    }
}
