//! What the wizards know of the site: cameras, objects, picture sizes, and which fusion nodes live. Bounded like the hub.

use sextant_estimator::{CameraId, ObjectId, ObjectModel, Rig};
use sextant_proto::NodeId;
use std::collections::{BTreeMap, BTreeSet};

/// Cameras, objects and nodes kept in mind; more is somebody's mistake.
const MOST: usize = 512;

/// The site, as its fusion nodes and cameras tell.
#[derive(Debug, Default)]
pub(crate) struct Known {
    /// The rig in force, once somebody announced one.
    pub rig: Option<Rig>,
    objects: BTreeMap<ObjectId, ObjectModel>,
    resolutions: BTreeMap<CameraId, [u32; 2]>,
    fusion_nodes: BTreeSet<NodeId>,
}

impl Known {
    pub(crate) fn object(&self, id: &ObjectId) -> Option<&ObjectModel> {
        self.objects.get(id)
    }

    pub(crate) fn take_object(&mut self, model: ObjectModel) {
        if self.objects.len() < MOST || self.objects.contains_key(model.id()) {
            self.objects.insert(model.id().clone(), model);
        }
    }

    pub(crate) fn forget_object(&mut self, id: &ObjectId) {
        self.objects.remove(id);
    }

    /// The size of a camera's pictures: as its newest image says, else as the rig does.
    pub(crate) fn resolution(&self, camera: &CameraId) -> Option<[u32; 2]> {
        let of_rig = || Some(self.rig.as_ref()?.camera(camera)?.resolution);
        self.resolutions.get(camera).copied().or_else(of_rig)
    }

    pub(crate) fn take_resolution(&mut self, camera: &CameraId, resolution: [u32; 2]) {
        if let Some(known) = self.resolutions.get_mut(camera) {
            *known = resolution;
        } else if self.resolutions.len() < MOST {
            self.resolutions.insert(camera.clone(), resolution);
        }
    }

    pub(crate) fn fusion_node(&mut self, id: &NodeId, up: bool) {
        if !up {
            self.fusion_nodes.remove(id);
        } else if self.fusion_nodes.len() < MOST {
            self.fusion_nodes.insert(id.clone());
        }
    }

    /// Those who answer changes.
    pub(crate) fn fusion_nodes(&self) -> &BTreeSet<NodeId> {
        &self.fusion_nodes
    }
}
