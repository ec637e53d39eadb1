//! What several files say about each other.

use sextant_estimator::{Fusion, FusionOptions};
use sextant_site_model::{CameraId, ObjectModel, Rig};
use sextant_tag_families::Family;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Models and recordings read so far, which must agree with each other.
#[derive(Default)]
pub struct CrossChecks {
    rigs: Vec<(PathBuf, Rig)>,
    objects: Vec<ObjectModel>,
    recorded: BTreeSet<(PathBuf, CameraId)>,
    /// The first picture of each camera and size.
    sizes: BTreeMap<(CameraId, [u32; 2]), PathBuf>,
}

impl CrossChecks {
    /// A rig was read.
    pub fn rig(&mut self, path: &Path, rig: Rig) {
        self.rigs.push((path.to_owned(), rig));
    }

    /// An object was read.
    pub fn object(&mut self, object: ObjectModel) {
        self.objects.push(object);
    }

    /// Families of the objects' tags.
    pub fn families(&self) -> BTreeSet<Family> {
        let tags = self.objects.iter().flat_map(ObjectModel::tags);
        tags.map(|tag| tag.tag.family).collect()
    }

    /// A recording has a camera.
    pub fn recorded(&mut self, recording: &Path, camera: &CameraId) {
        self.recorded.insert((recording.to_owned(), camera.clone()));
    }

    /// A recording has a picture of that size.
    pub fn picture(&mut self, camera: &CameraId, size: [u32; 2], path: &Path) {
        self.sizes
            .entry((camera.clone(), size))
            .or_insert_with(|| path.to_owned());
    }

    /// What does not go together.
    pub fn complaints(&self) -> Vec<String> {
        let fused = Fusion::new(
            Rig::default(),
            self.objects.clone(),
            FusionOptions::default(),
        );
        let mut complaints: Vec<String> = fused.err().iter().map(ToString::to_string).collect();
        for (path, rig) in &self.rigs {
            complaints.extend(self.unknown_cameras(path, rig));
            complaints.extend(self.other_sizes(path, rig));
            complaints.extend(self.without_landmarks(path, rig));
        }
        complaints
    }

    /// A carried camera, where objects were read and none of them is a landmark.
    fn without_landmarks(&self, path: &Path, rig: &Rig) -> Option<String> {
        let mut objects = self.objects.iter();
        if self.objects.is_empty() || objects.any(|object| object.world_from_object().is_some()) {
            return None;
        }
        let mut cameras = rig.cameras().iter();
        let carried = cameras.find(|camera| camera.mount.is_some())?;
        Some(format!(
            "{}: camera \"{}\" is carried, and no object is a landmark; give the object file of \
             tags that stand still a `world_from_object`",
            path.display(),
            carried.id
        ))
    }

    fn unknown_cameras<'a>(
        &'a self,
        path: &'a Path,
        rig: &'a Rig,
    ) -> impl Iterator<Item = String> + 'a {
        let unknown = self.recorded.iter();
        let unknown = unknown.filter(|(_, camera)| rig.camera(camera).is_none());
        unknown.map(|(recording, camera)| {
            format!(
                "{}: the rig {} has no camera \"{camera}\"; add it there or take the folder away",
                recording.display(),
                path.display()
            )
        })
    }

    fn other_sizes<'a>(
        &'a self,
        path: &'a Path,
        rig: &'a Rig,
    ) -> impl Iterator<Item = String> + 'a {
        self.sizes.iter().filter_map(move |((id, size), picture)| {
            let camera = rig.camera(id).filter(|camera| camera.resolution != *size)?;
            let ([width, height], [expected_width, expected_height]) = (size, camera.resolution);
            Some(format!(
                "{}: {width}x{height} pixels, but the rig {} says \
                 {expected_width}x{expected_height} of camera \"{id}\"",
                picture.display(),
                path.display()
            ))
        })
    }
}
