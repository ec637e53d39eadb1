//! The rig and the objects of a replay, and whether they fit the recording and each other.

use super::sight;
use anyhow::bail;
use sextant_apriltag::Options;
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::{Dataset, Row};
use sextant_site_files::{read_object, read_rig};
use sextant_site_model::{ObjectModel, Rig};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Cameras and objects.
pub struct Models {
    /// The cameras.
    pub rig: Rig,
    /// The objects, in the order of the command line.
    pub objects: Vec<ObjectModel>,
    rig_file: PathBuf,
}

impl Models {
    /// Reads the files.
    ///
    /// # Errors
    /// [`Exit::Input`] for a file that cannot be used, and an object that is not learned yet.
    pub fn read(rig_file: &Path, object_files: &[PathBuf]) -> anyhow::Result<Self> {
        Ok(Self {
            objects: objects(object_files)?,
            rig: rig(rig_file)?,
            rig_file: rig_file.to_owned(),
        })
    }

    /// Every camera of the recording is in the rig, and its pose is known unless it is the only one.
    ///
    /// # Errors
    /// [`Exit::Input`] for the first that is not.
    pub fn check_cameras(&self, dataset: &Dataset, recording: &Path) -> anyhow::Result<()> {
        let file = self.rig_file.display();
        for camera in dataset.cameras() {
            let id = &camera.camera;
            let folder = recording.join(id.as_str());
            match self.rig.camera(id) {
                None => wrong(format!(
                    "{}: the rig {file} has no camera \"{id}\"; add it there or take the folder away",
                    folder.display()
                ))?,
                Some(camera)
                    if camera.world_from_camera.is_none() && self.rig.cameras().len() > 1 =>
                {
                    wrong(format!(
                        "{file}: camera \"{id}\" has no world_from_camera; calibrate it with `sextant calibrate rig`"
                    ))?
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// The capture time of a row: the middle of its exposure, whichever moment its stamp is of.
    pub fn capture_ns(&self, row: &Row) -> u64 {
        let (camera, stamp_ns) = (&row.camera, row.capture_ns);
        self.rig
            .middle_of_exposure_ns(camera, stamp_ns, sight::EXPOSURE_UNKNOWN_NS)
    }

    /// A detector that looks for the families of the objects' tags.
    pub fn detector_options(&self) -> Options {
        let tags = self.objects.iter().flat_map(ObjectModel::tags);
        let families: BTreeSet<Family> = tags.map(|tag| tag.tag.family).collect();
        Options {
            families: families.into_iter().collect(),
            ..Options::default()
        }
    }
}

/// A rig file.
///
/// # Errors
/// [`Exit::Input`] for a file that cannot be used.
pub fn rig(file: &Path) -> anyhow::Result<Rig> {
    read_rig(file).exit_with(Exit::Input)
}

/// Object files.
///
/// # Errors
/// [`Exit::Input`] for a file that cannot be used, and an object of several tags that is not learned yet.
pub fn objects(files: &[PathBuf]) -> anyhow::Result<Vec<ObjectModel>> {
    let objects = files.iter().map(|file| {
        let object = read_object(file).exit_with(Exit::Input)?;
        let tags = object.tags();
        if tags.len() > 1 && tags.iter().all(|tag| tag.object_from_tag.is_none()) {
            wrong(format!(
                "{}: no tag has an object_from_tag; write where the tags sit, or learn it with `sextant learn`",
                file.display()
            ))?;
        }
        Ok(object)
    });
    objects.collect()
}

fn wrong(message: String) -> anyhow::Result<()> {
    bail!(Failure::new(Exit::Input, anyhow::anyhow!(message)))
}
