//! Departed nodes and objects: shown as gone for a while, then dropped. A camera of the rig is expected back and stays.

use crate::top::board::Board;
use sextant_proto::NodeKind;
use sextant_site_model::{CameraId, ObjectId};

/// Time for which departed nodes and objects are shown, ns.
const SHOWN_NS: u64 = 60_000_000_000;

impl Board {
    /// Marks what no fusion node has any more.
    pub fn compare_with_statuses(&mut self, now_ns: u64) {
        let fusion = &self.fusion;
        let has_object = |id: &ObjectId| {
            let mut objects = fusion.values().flat_map(|status| &status.objects);
            objects.any(|object| object.object == *id)
        };
        for (id, row) in &mut self.objects {
            let gone_ns = row.gone_ns.or(Some(now_ns));
            row.gone_ns = gone_ns.filter(|_| !has_object(id));
        }
        let has_camera = |id: &CameraId| {
            let mut cameras = fusion.values().flat_map(|status| &status.cameras);
            cameras.any(|camera| camera.camera == *id)
        };
        for (id, row) in &mut self.cameras {
            row.in_rig = has_camera(id);
            if !row.in_rig {
                row.intake = None;
            }
        }
    }

    /// Drops what has been gone for a minute.
    pub fn see_off(&mut self, now_ns: u64) {
        let is_old = |gone_ns: u64| now_ns.saturating_sub(gone_ns) > SHOWN_NS;
        self.objects
            .retain(|_, row| !row.gone_ns.is_some_and(is_old));
        self.cameras
            .retain(|_, row| row.in_rig || !row.gone_ns(now_ns).is_some_and(is_old));
        let cameras = &self.cameras;
        let expected = |kind: NodeKind, id: &str| {
            kind == NodeKind::Camera && cameras.keys().any(|camera| camera.as_str() == id)
        };
        self.nodes.retain(|(kind, id), row| {
            row.up || row.heard_ns == 0 || !is_old(row.heard_ns) || expected(*kind, id.as_str())
        });
        let nodes = &self.nodes;
        // The last messages of an ended node are outdated.
        let lives = |id| nodes.contains_key(&(NodeKind::Fusion, id));
        self.fusion.retain(|id, _| lives(id.clone()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::board::tests::{NOW_NS, board};

    #[test]
    fn a_camera_that_left_is_dropped_unless_the_rig_expects_it() {
        let mut board = board();
        let later = NOW_NS + 61_000_000_000;
        board.see_off(later);
        let north = CameraId::new("north").unwrap();
        assert_eq!(board.cameras[&north].gone_ns(later), Some(NOW_NS));
        board.cameras.entry(north).or_default().in_rig = false;
        board.see_off(later);
        assert!(board.cameras.is_empty());
    }
}
