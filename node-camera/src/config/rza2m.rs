//! The camera of an RZ/A2M, as the file describes it.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sextant_rza2m::CameraSettings;
use sextant_rza2m::drp::Circuit;
use sextant_site_files::Complaint;

/// The camera of an RZ/A2M: an IMX219, driven from user space (docs/rza2m.md).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rza2mConfig {
    /// Width, a multiple of 32, and height, even, in pixels: 32x16 to 800x480 (default 640x480).
    #[serde(default = "default_resolution")]
    pub resolution: [u16; 2],
    /// Images a second; absent: as many as the sensor gives.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Exposure in microseconds (default 5000); there is no automatic one.
    #[serde(default = "default_exposure_us")]
    pub exposure_us: u32,
    /// Analog gain, 1 to 10.66 (default 4).
    #[serde(default = "default_gain")]
    pub gain: f64,
    /// Circuits of the DRP that make images grey, one after the other; none: the CPU does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drp: Vec<DrpCircuitConfig>,
}

/// A circuit of the DRP.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrpCircuitConfig {
    /// Which one.
    pub circuit: DrpCircuit,
    /// Its configuration data, a file of Renesas' DRP library that you have to provide.
    pub data: PathBuf,
}

/// Circuits that can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DrpCircuit {
    /// Raw image to grey, red at the first pixel.
    Bayer2grayscale,
    /// Gaussian of 3x3 pixels; of a raw image it makes a grey one, whatever the order of colours.
    GaussianBlur,
    /// Median of 3x3 pixels.
    MedianBlur,
    /// Greatest of 3x3 pixels.
    Dilate,
    /// Least of 3x3 pixels.
    Erode,
}

fn default_resolution() -> [u16; 2] {
    [640, 480]
}

fn default_exposure_us() -> u32 {
    5000
}

fn default_gain() -> f64 {
    4.0
}

impl Rza2mConfig {
    /// What the camera is asked for.
    pub(crate) fn settings(&self) -> CameraSettings {
        let Self {
            resolution,
            rate_hz,
            exposure_us,
            gain,
            ..
        } = *self;
        CameraSettings {
            resolution,
            rate_hz,
            exposure_us,
            gain,
        }
    }

    pub(super) fn resolve(&mut self, folder: &Path) {
        for circuit in &mut self.drp {
            circuit.data = folder.join(&circuit.data);
        }
    }

    pub(super) fn check(&self) -> Result<(), Complaint> {
        let complain = |key: &str, cause: String| Complaint::new(key, cause, "see docs/rza2m.md");
        let settings = self.settings().check();
        settings.map_err(|cause| complain("source", cause.to_string()))?;
        let circuits = self.drp.iter().map(|config| config.circuit.into());
        let order = sextant_rza2m::check_order(circuits);
        order.map_err(|cause| complain("source.drp", cause.to_owned()))
    }
}

impl From<DrpCircuit> for Circuit {
    fn from(circuit: DrpCircuit) -> Self {
        match circuit {
            DrpCircuit::Bayer2grayscale => Self::Bayer2Grayscale,
            DrpCircuit::GaussianBlur => Self::GaussianBlur,
            DrpCircuit::MedianBlur => Self::MedianBlur,
            DrpCircuit::Dilate => Self::Dilate,
            DrpCircuit::Erode => Self::Erode,
        }
    }
}
