//! Which objects the site's fusion nodes have, by their statuses: so that one that was removed while the bridge did not hear
//! it, or while its fusion node was down, is forgotten all the same.

use sextant_estimator::ObjectId;
use sextant_proto::{FusionStatus, NodeId};
use std::collections::{BTreeMap, BTreeSet};

/// Fusion nodes that are kept in mind; more is somebody's mistake.
const MAX_NODES: usize = 64;

/// The objects of each fusion node.
#[derive(Debug, Default)]
pub(crate) struct Inventory {
    objects: BTreeMap<NodeId, BTreeSet<ObjectId>>,
}

impl Inventory {
    /// Takes a status in; the objects that its node had and that nobody has any more.
    pub(crate) fn take(&mut self, status: &FusionStatus) -> Vec<ObjectId> {
        if self.objects.len() >= MAX_NODES && !self.objects.contains_key(&status.node) {
            return Vec::new();
        }
        let now = status.objects.iter().map(|object| object.object.clone());
        let before = self.objects.insert(status.node.clone(), now.collect());
        let is_gone = |object: &ObjectId| !self.objects.values().any(|has| has.contains(object));
        before.into_iter().flatten().filter(is_gone).collect()
    }
}

#[cfg(test)]
pub(crate) mod samples {
    use super::*;
    use sextant_estimator::State;
    use sextant_proto::{ObjectHealth, Rejections};

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
            cameras: vec![],
            foreign: Rejections::default(),
            objects: objects.iter().map(health).collect(),
            faults: vec![],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::samples::status;
    use super::*;

    #[test]
    fn an_object_is_gone_when_no_node_has_it_any_more() {
        let mut inventory = Inventory::default();
        assert!(inventory.take(&status("a", &["cube", "box"])).is_empty());
        assert!(inventory.take(&status("b", &["cube"])).is_empty());
        let gone = inventory.take(&status("a", &[]));
        assert_eq!(gone, [ObjectId::new("box").unwrap()]);
        let gone = inventory.take(&status("b", &[]));
        assert_eq!(gone, [ObjectId::new("cube").unwrap()]);
    }
}
