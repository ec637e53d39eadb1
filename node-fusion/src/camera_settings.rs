//! The file of camera settings: exposure, gain and rate of the site's cameras.

use serde::{Deserialize, Serialize};
use sextant_proto::{CameraSettings, encode, limits};
use sextant_site_files::{Complaint, FileError, read_toml_checked, write_toml};
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::path::Path;

/// The settings of each camera that has some.
pub type SettingsOfCameras = BTreeMap<CameraId, CameraSettings>;

/// As written: a table `[[settings]]` for each camera.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsFile {
    #[serde(default)]
    settings: Vec<CameraSettings>,
}

impl SettingsFile {
    fn check(&self) -> Result<(), Complaint> {
        if self.settings.len() > limits::MAX_CAMERAS {
            let most = format!("more than {} cameras", limits::MAX_CAMERAS);
            return Err(Complaint::new("settings", most, "remove some"));
        }
        self.settings.iter().try_for_each(|settings| {
            encode(settings).map(drop).map_err(|cause| {
                let cause = format!("camera {}: {cause}", settings.camera);
                let remedy =
                    "choose a value in the range that `sextant config set camera --help` names";
                Complaint::new("settings", cause, remedy)
            })
        })
    }
}

/// Reads the file; a missing one has no settings.
///
/// # Errors
/// A malformed file, or a value out of its range.
pub fn read(file: &Path) -> Result<SettingsOfCameras, FileError> {
    if !file.exists() {
        return Ok(SettingsOfCameras::new());
    }
    let SettingsFile { settings } = read_toml_checked(file, SettingsFile::check)?;
    let of_cameras = settings.into_iter().map(|one| (one.camera.clone(), one));
    Ok(of_cameras.collect())
}

/// Writes the settings of one camera into the file; those of others stay.
///
/// # Errors
/// What the system refuses, and a file in the way that is something else.
pub fn keep(file: &Path, settings: &CameraSettings) -> Result<(), FileError> {
    let mut all = read(file)?;
    all.remove(&settings.camera);
    if !settings.is_none() {
        all.insert(settings.camera.clone(), settings.clone());
    }
    let settings = all.into_values().collect();
    write_toml(file, &SettingsFile { settings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_read_back_and_no_other_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cameras.toml");
        assert!(read(&file).unwrap().is_empty());
        let settings = |id: &str, exposure_us| CameraSettings {
            exposure_us,
            rate_hz: Some(29.97),
            ..CameraSettings::none(CameraId::new(id).unwrap())
        };
        let [north, south] = [settings("north", Some(4000.0)), settings("south", None)];
        keep(&file, &north).unwrap();
        keep(&file, &south).unwrap();
        let both = [&north, &south].map(|one| (one.camera.clone(), one.clone()));
        assert_eq!(read(&file).unwrap(), SettingsOfCameras::from(both));
        keep(&file, &CameraSettings::none(north.camera)).unwrap();
        assert_eq!(
            read(&file).unwrap().into_values().collect::<Vec<_>>(),
            [south]
        );
        std::fs::write(&file, "id = \"cube\"\n").unwrap();
        assert!(keep(&file, &settings("north", None)).is_err());
    }

    #[test]
    fn a_value_out_of_range_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cameras.toml");
        std::fs::write(&file, "[[settings]]\ncamera = \"north\"\nexposure_us = 0\n").unwrap();
        let refused = read(&file).unwrap_err().to_string();
        assert!(refused.contains("exposure_us"), "{refused}");
    }
}
