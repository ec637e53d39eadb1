//! The rig and the objects of a replay, and whether they fit the recording and each other.

use crate::observation::EXPOSURE_UNKNOWN_NS;
use sextant_apriltag::Options;
use sextant_recordings::{Dataset, Row};
use sextant_site_files::{FileError, read_object, read_rig};
use sextant_site_model::{CameraId, ObjectModel, Rig};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Why rig and objects cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ModelsError {
    /// A file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// An object of several tags is not learned yet.
    #[error(
        "{}: no tag has an object_from_tag; write where the tags sit, or learn it with `sextant learn`",
        .0.display()
    )]
    NotLearned(PathBuf),
    /// The rig lacks a camera of the recording.
    #[error(
        "{}: the rig {} has no camera \"{camera}\"; add it there or take the folder away",
        folder.display(), rig.display()
    )]
    UnknownCamera {
        /// The camera's folder.
        folder: PathBuf,
        /// The rig file.
        rig: PathBuf,
        /// The camera.
        camera: CameraId,
    },
    /// The pose of one of several cameras is unknown.
    #[error(
        "{}: camera \"{camera}\" has no world_from_camera; calibrate it with `sextant calibrate rig`",
        rig.display()
    )]
    NoPose {
        /// The rig file.
        rig: PathBuf,
        /// The camera.
        camera: CameraId,
    },
    /// Nothing stands still by which a carried camera is localised.
    #[error(
        "{}: camera \"{camera}\" is carried, and no object is a landmark; give the object file \
         of tags that stand still a `world_from_object`",
        rig.display()
    )]
    NoLandmarks {
        /// The rig file.
        rig: PathBuf,
        /// The camera.
        camera: CameraId,
    },
}

/// The cameras and objects that a replay works from.
#[derive(Debug)]
pub struct ReplayModels {
    /// The cameras.
    pub rig: Rig,
    /// The objects, in the order of their files.
    pub objects: Vec<ObjectModel>,
    rig_file: PathBuf,
}

impl ReplayModels {
    /// Reads the files.
    ///
    /// # Errors
    /// A file that cannot be used, and an object that is not learned yet.
    pub fn read(rig_file: &Path, object_files: &[PathBuf]) -> Result<Self, ModelsError> {
        Ok(Self {
            objects: read_objects(object_files)?,
            rig: read_rig(rig_file)?,
            rig_file: rig_file.to_owned(),
        })
    }

    /// Every camera of the recording is in the rig, and its pose is known unless the rig has one camera only.
    ///
    /// # Errors
    /// The first camera that is not.
    pub fn check_cameras(&self, dataset: &Dataset, recording: &Path) -> Result<(), ModelsError> {
        for camera in dataset.cameras() {
            let id = &camera.camera;
            match self.rig.camera(id) {
                None => {
                    return Err(ModelsError::UnknownCamera {
                        folder: recording.join(id.as_str()),
                        rig: self.rig_file.clone(),
                        camera: id.clone(),
                    });
                }
                Some(camera) if !camera.is_placed() && self.rig.cameras().len() > 1 => {
                    return Err(ModelsError::NoPose {
                        rig: self.rig_file.clone(),
                        camera: id.clone(),
                    });
                }
                Some(camera) if camera.mount.is_some() && !self.has_landmarks() => {
                    return Err(ModelsError::NoLandmarks {
                        rig: self.rig_file.clone(),
                        camera: id.clone(),
                    });
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    fn has_landmarks(&self) -> bool {
        let mut objects = self.objects.iter();
        objects.any(|object| object.world_from_object().is_some())
    }

    /// The capture time of a row: the middle of its exposure, whichever moment its stamp is of.
    pub fn capture_ns(&self, row: &Row) -> u64 {
        let (camera, stamp_ns) = (&row.camera, row.capture_ns);
        self.rig
            .middle_of_exposure_ns(camera, stamp_ns, EXPOSURE_UNKNOWN_NS)
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

/// Reads object files.
///
/// # Errors
/// A file that cannot be used, and an object of several tags that is not learned yet.
pub fn read_objects(files: &[PathBuf]) -> Result<Vec<ObjectModel>, ModelsError> {
    let objects = files.iter().map(|file| {
        let object = read_object(file)?;
        let tags = object.tags();
        if tags.len() > 1 && tags.iter().all(|tag| tag.object_from_tag.is_none()) {
            return Err(ModelsError::NotLearned(file.clone()));
        }
        Ok(object)
    });
    objects.collect()
}
