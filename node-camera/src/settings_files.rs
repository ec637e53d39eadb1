//! The camera's settings between the detecting part, which has the network, and the capturing part, which has none: two
//! small files beside the shared memory. They end with it; the site then sends its settings again.

use std::io;
use std::path::{Path, PathBuf};

use sextant_iceoryx_images::{ImagesError, companion_file};
use sextant_proto::{CameraControls, CameraSettings};
use sextant_site_files::{FileError, read_toml, write_toml};

use crate::config::{CameraNodeConfig, SourceConfig};

/// The files.
#[derive(Debug, Clone)]
pub(crate) struct SettingsFiles {
    settings: PathBuf,
    controls: PathBuf,
}

impl SettingsFiles {
    /// Those of a camera.
    ///
    /// # Errors
    /// Options of shared memory that cannot be had.
    pub(crate) fn new(config: &CameraNodeConfig) -> Result<Self, ImagesError> {
        let file = |name: &str| {
            companion_file(&config.shared_memory, &format!("{}.{name}", config.camera))
        };
        Ok(Self {
            settings: file("settings")?,
            controls: file("controls")?,
        })
    }

    /// Files in any folder.
    #[cfg(test)]
    pub(crate) fn in_folder(folder: &Path) -> Self {
        Self {
            settings: folder.join("settings"),
            controls: folder.join("controls"),
        }
    }

    /// The file of the site's settings.
    pub(crate) fn settings_file(&self) -> &Path {
        &self.settings
    }

    /// What the site wants; none where it wants nothing.
    pub(crate) fn settings(&self) -> Option<CameraSettings> {
        read_toml(&self.settings).ok()
    }

    /// Hands the site's settings to the capturing part.
    ///
    /// # Errors
    /// What the system refuses.
    pub(crate) fn write_settings(&self, settings: &CameraSettings) -> Result<(), FileError> {
        if !settings.is_none() {
            return write_toml(&self.settings, settings);
        }
        match std::fs::remove_file(&self.settings) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(FileError::Unwritable {
                path: self.settings.clone(),
                source,
            }),
            _ => Ok(()),
        }
    }

    /// What is in force, as the capturing part has written it; unknown before.
    pub(crate) fn controls(&self) -> CameraControls {
        read_toml(&self.controls).unwrap_or_default()
    }

    /// Hands what is in force to the detecting part.
    ///
    /// # Errors
    /// What the system refuses.
    pub(crate) fn write_controls(&self, controls: &CameraControls) -> Result<(), FileError> {
        write_toml(&self.controls, controls)
    }
}

impl SourceConfig {
    /// This source with the values that the site sets in place of the file's.
    ///
    /// # Errors
    /// Why a source of this kind has no such settings, and the remedy.
    pub(crate) fn with(&self, wanted: &CameraSettings) -> Result<Self, &'static str> {
        let mut source = self.clone();
        let whole = |value: f64| value.round() as u32;
        let wanted_us = wanted.exposure_us.map(whole);
        match &mut source {
            Self::V4l2(config) => {
                config.exposure_us = wanted_us.or(config.exposure_us);
                config.gain = wanted.gain.map(whole).or(config.gain);
                config.rate_hz = wanted.rate_hz.or(config.rate_hz);
            }
            Self::Rza2m(config) => {
                config.exposure_us = wanted_us.unwrap_or(config.exposure_us);
                config.gain = wanted.gain.unwrap_or(config.gain);
                config.rate_hz = wanted.rate_hz.or(config.rate_hz);
            }
            Self::Simulator {
                exposure_us,
                gain,
                rate_hz,
                ..
            } => {
                *exposure_us = wanted.exposure_us.or(*exposure_us);
                *gain = wanted.gain.or(*gain);
                *rate_hz = wanted.rate_hz.or(*rate_hz);
            }
            Self::Command(_) => {
                return Err(
                    "its images come from a program; give exposure, gain and rate to the \
                     program, in `run` of [source] in its camera.toml",
                );
            }
            Self::Images { .. } | Self::Video(_) => {
                return Err("its images are recorded; remove its settings (value `file`)");
            }
        }
        Ok(source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{Control, SettingsOutcome};
    use sextant_site_model::CameraId;

    fn wanted(exposure_us: Option<f64>) -> CameraSettings {
        CameraSettings {
            exposure_us,
            ..CameraSettings::none(CameraId::new("north").unwrap())
        }
    }

    #[test]
    fn the_site_overrides_what_it_sets_and_nothing_else() {
        let simulator = SourceConfig::simulator("/s.toml");
        let longer = simulator.with(&wanted(Some(8000.0))).unwrap();
        assert!(matches!(
            longer,
            SourceConfig::Simulator {
                exposure_us: Some(8000.0),
                rate_hz: None,
                ..
            }
        ));
        assert_eq!(longer.with(&wanted(None)), Ok(longer.clone()));
        let recording = SourceConfig::images("/r").with(&wanted(Some(8000.0)));
        assert!(recording.unwrap_err().contains("recorded"));
    }

    #[test]
    fn what_is_handed_over_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let files = SettingsFiles::in_folder(folder.path());
        assert_eq!(files.settings(), None);
        assert_eq!(files.controls(), CameraControls::default());
        files.write_settings(&wanted(Some(8000.0))).unwrap();
        assert_eq!(files.settings(), Some(wanted(Some(8000.0))));
        for _ in 0..2 {
            files.write_settings(&wanted(None)).unwrap();
            assert_eq!(files.settings(), None);
        }
        let controls = CameraControls {
            exposure_us: Control {
                wanted: Some(8000.0),
                value: Some(7900.0),
                range: Some([100.0, 33_000.5]),
            },
            outcome: SettingsOutcome::Adjusted {
                detail: "nearly".to_owned(),
            },
            ..CameraControls::default()
        };
        files.write_controls(&controls).unwrap();
        assert_eq!(files.controls(), controls);
    }
}
