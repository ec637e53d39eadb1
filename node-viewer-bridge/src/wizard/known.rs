//! What the wizards know of the site: cameras, objects, picture sizes, and which fusion nodes live. Bounded like the hub.

use sextant_proto::NodeId;
use sextant_site_model::{CameraId, ObjectId, ObjectModel, Rig};
use sextant_zenoh_bus::BoundedMap;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Cameras, objects and nodes kept in mind.
const MOST: usize = 512;
/// Tags of all objects kept in mind.
const MOST_TAGS: usize = 16_384;
/// An entry without news for so long gives way to a new one.
const EXPIRY: Duration = Duration::from_secs(60);

/// The site, as its fusion nodes and cameras publish it.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    /// The rig in force, once somebody announced one.
    pub rig: Option<Rig>,
    objects: BoundedMap<ObjectId, ObjectModel>,
    resolutions: BoundedMap<CameraId, [u32; 2]>,
    fusion_nodes: BTreeSet<NodeId>,
}

impl Default for Known {
    fn default() -> Self {
        Self {
            rig: None,
            objects: BoundedMap::new(MOST, EXPIRY),
            resolutions: BoundedMap::new(MOST, EXPIRY),
            fusion_nodes: BTreeSet::new(),
        }
    }
}

impl Known {
    pub(crate) fn object(&self, id: &ObjectId) -> Option<&ObjectModel> {
        self.objects.get(id)
    }

    /// Takes an object in, if there is room for it and its tags.
    pub(crate) fn take_object(&mut self, model: ObjectModel) {
        let others = self.objects.iter().filter(|(id, _)| *id != model.id());
        let tags: usize = others.map(|(_, other)| other.tags().len()).sum();
        if tags + model.tags().len() <= MOST_TAGS {
            let _ = self
                .objects
                .insert(Instant::now(), model.id().clone(), model);
        }
    }

    /// Marks objects that a fusion node lists as existing.
    pub(crate) fn confirm_objects(&mut self, objects: &BTreeSet<&str>) {
        let is_one = |id: &ObjectId| objects.contains(id.as_str());
        self.objects.touch_where(Instant::now(), is_one);
    }

    pub(crate) fn forget_object(&mut self, id: &ObjectId) {
        self.objects.remove(id);
    }

    /// The size of a camera's images: that of the newest one, else that of the rig.
    pub(crate) fn resolution(&self, camera: &CameraId) -> Option<[u32; 2]> {
        let of_rig = || Some(self.rig.as_ref()?.camera(camera)?.resolution);
        self.resolutions.get(camera).copied().or_else(of_rig)
    }

    pub(crate) fn take_resolution(&mut self, camera: &CameraId, resolution: [u32; 2]) {
        let _ = self
            .resolutions
            .insert(Instant::now(), camera.clone(), resolution);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wizard::samples;

    #[test]
    fn floods_of_ids_end_at_the_bounds() {
        let mut known = Known::default();
        for n in 0..10 * MOST {
            let name = format!("x{n}");
            let tags = samples::cube().tags().to_vec();
            let id = ObjectId::new(&name).unwrap();
            known.take_object(ObjectModel::new(id, tags).unwrap());
            known.take_resolution(&CameraId::new(&name).unwrap(), [640, 480]);
            known.fusion_node(&NodeId::new(&name).unwrap(), true);
        }
        assert_eq!(known.objects.len(), MOST);
        assert_eq!(known.resolutions.len(), MOST);
        assert_eq!(known.fusion_nodes.len(), MOST);
    }

    #[test]
    fn a_flood_of_tags_ends_at_the_bound() {
        let mut known = Known::default();
        let tag = samples::cube().tags()[0].clone();
        let tags: Vec<_> = (0..1024)
            .map(|id| {
                let mut tag = tag.clone();
                tag.tag.id = id;
                tag
            })
            .collect();
        for n in 0..10 * MOST_TAGS / tags.len() {
            let id = ObjectId::new(&format!("x{n}")).unwrap();
            known.take_object(ObjectModel::new(id, tags.clone()).unwrap());
        }
        assert_eq!(known.objects.len(), MOST_TAGS / tags.len());
    }
}
