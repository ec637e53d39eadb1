//! Exposure, gain and rate of a camera: as the site wants them, and as they are in force.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// Settings of a camera. What is none is up to the camera's own file. A message without any value removes the site's
/// settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSettings {
    /// The camera; the same as in the key.
    pub camera: CameraId,
    /// Exposure, µs, 1 to 1,000,000.
    pub exposure_us: Option<f64>,
    /// Gain in the units of the camera's driver, 0 to 1,000,000; a factor where there is no driver.
    pub gain: Option<f64>,
    /// Images per second, 0.1 to 1000.
    pub rate_hz: Option<f64>,
}

impl CameraSettings {
    /// Settings that leave everything to the camera's own file.
    #[must_use]
    pub fn none(camera: CameraId) -> Self {
        Self {
            camera,
            exposure_us: None,
            gain: None,
            rate_hz: None,
        }
    }

    /// Whether everything is left to the camera's own file.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.values() == [None; 3]
    }

    /// Exposure, gain and rate.
    #[must_use]
    pub fn values(&self) -> [Option<f64>; 3] {
        [self.exposure_us, self.gain, self.rate_hz]
    }
}

impl Message for CameraSettings {
    const KIND: MessageKind = MessageKind::CameraSettings;

    fn check(&self) -> Result<(), OutOfRange> {
        let exposure_us = self.exposure_us.unwrap_or(1.0);
        holds((1.0..=1e6).contains(&exposure_us), "exposure_us")?;
        let gain = self.gain.unwrap_or(0.0);
        holds((0.0..=1e6).contains(&gain), "gain")?;
        let rate_hz = self.rate_hz.unwrap_or(1.0);
        holds((0.1..=1000.0).contains(&rate_hz), "rate_hz")
    }
}

/// One setting of a camera.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Control {
    /// What the site wants; none: up to the camera's own file.
    pub wanted: Option<f64>,
    /// What is in force; none: unknown, or chosen by the camera for every image.
    pub value: Option<f64>,
    /// Least and greatest value; none: unknown, or not adjustable.
    pub range: Option<[f64; 2]>,
}

impl Control {
    fn check(&self, field: &'static str) -> Result<(), OutOfRange> {
        let [least, greatest] = self.range.unwrap_or_default();
        holds(least <= greatest, field)?;
        for value in [self.wanted, self.value, Some(least), Some(greatest)] {
            check::amount(value.unwrap_or(0.0), field)?;
        }
        Ok(())
    }
}

/// What became of the site's settings at a camera.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SettingsOutcome {
    /// The site has none for this camera.
    #[default]
    None,
    /// They are on their way to the camera.
    Pending,
    /// They are in force.
    Applied,
    /// In force as far as the camera allows.
    Adjusted {
        /// What differs, and why.
        detail: String,
    },
    /// The camera keeps what it had.
    Refused {
        /// Cause and remedy.
        detail: String,
    },
}

/// The settings of a camera in force.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CameraControls {
    /// Exposure, µs.
    pub exposure_us: Control,
    /// Gain, in the units of [`CameraSettings::gain`].
    pub gain: Control,
    /// Images per second.
    pub rate_hz: Control,
    /// What became of the values wanted.
    pub outcome: SettingsOutcome,
}

impl CameraControls {
    /// What the site wants, as these controls have it.
    #[must_use]
    pub fn wanted(&self) -> [Option<f64>; 3] {
        [self.exposure_us, self.gain, self.rate_hz].map(|control| control.wanted)
    }

    /// The same values in force, with what the site wants.
    #[must_use]
    pub fn wanting(mut self, wanted: [Option<f64>; 3], outcome: SettingsOutcome) -> Self {
        let controls = [&mut self.exposure_us, &mut self.gain, &mut self.rate_hz];
        for (control, wanted) in controls.into_iter().zip(wanted) {
            control.wanted = wanted;
        }
        Self { outcome, ..self }
    }

    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        self.exposure_us.check("controls.exposure_us")?;
        self.gain.check("controls.gain")?;
        self.rate_hz.check("controls.rate_hz")?;
        match &self.outcome {
            SettingsOutcome::Adjusted { detail } | SettingsOutcome::Refused { detail } => {
                check::detail(detail, "controls.outcome")
            }
            SettingsOutcome::None | SettingsOutcome::Pending | SettingsOutcome::Applied => Ok(()),
        }
    }
}
