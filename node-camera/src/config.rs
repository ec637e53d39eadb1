//! `camera.toml`: configuration of a camera node. Paths are relative to the folder of the file.

mod rza2m;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sextant_apriltag::{Family, Options};
use sextant_estimator::CameraId;
use sextant_iceoryx_images::IceoryxOptions;
use sextant_proto::SiteId;
use sextant_site_files::{Complaint, FileError, read_toml_checked};
use sextant_zenoh_bus::BusOptions;

pub use self::rza2m::{DrpCircuit, DrpCircuitConfig, Rza2mConfig};

/// The file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraNodeConfig {
    /// The site, which is part of every key.
    pub site: SiteId,
    /// Id of the camera in the rig.
    pub camera: CameraId,
    /// Where the images come from.
    pub source: SourceConfig,
    /// Detector options.
    #[serde(default)]
    pub detection: DetectionConfig,
    /// Preview images.
    #[serde(default)]
    pub preview: PreviewConfig,
    /// Network session; by default a client of the router on this host.
    #[serde(default)]
    pub network: BusOptions,
    /// Shared memory of capture and detection.
    #[serde(default)]
    pub shared_memory: IceoryxOptions,
}

/// Where the images come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum SourceConfig {
    /// Images of a scenario, rendered at their times by the clock of this host.
    Simulator {
        /// The scenario's file; it must have a camera of this node's name.
        scenario: PathBuf,
    },
    /// Recorded images in the EuRoC layout.
    Images {
        /// Folder with one folder per camera; that of this node's camera is played.
        folder: PathBuf,
        /// Playback speed.
        #[serde(default)]
        pace: Pace,
        /// Whether to start again at the end; timestamps keep ascending.
        #[serde(default)]
        repeat: bool,
        /// Wire time at which the recording's first image (of any of its cameras) is played; time stamps are shifted
        /// likewise. Give several nodes the same to play a recording together. Absent: time stamps as recorded.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start_ns: Option<u64>,
    },
    /// A camera of this host.
    V4l2 {
        /// The device, best by its place: `/dev/v4l/by-path/...`.
        device: PathBuf,
        /// Width and height in pixels.
        resolution: [u32; 2],
        /// Images a second; absent: the driver's choice.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rate_hz: Option<f64>,
        /// Exposure in microseconds, set on the camera and used to find the middle of the exposure; absent: the
        /// camera's own choice, and the time stamp is taken as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exposure_us: Option<u32>,
        /// Microseconds from the first row to the last, of a shutter that rolls: `line_delay` of rig.toml times rows. Drivers
        /// stamp the first row's beginning or the last one's end; the capture time is that of the middle row. Absent: 0.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        readout_us: Option<u32>,
    },
    /// The camera of an RZ/A2M.
    Rza2m(Rza2mConfig),
}

/// Playback speed of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// Recorded speed.
    #[default]
    Recorded,
    /// As fast as possible; slow readers miss images.
    AsFastAsPossible,
}

/// Detector options.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectionConfig {
    /// Tag families, at least one (default tag36h11). Each further one costs time and false detections.
    pub families: Vec<Family>,
    /// Most bit errors corrected, 0 to 2 (default 2).
    pub max_hamming: u8,
    /// Least decision margin in grey levels, 0 to 100 (default 4).
    pub min_margin: f32,
    /// Whether to track tags: each image is searched near earlier tags and, in turn, elsewhere, so that a new tag is found
    /// within ten images (default false: search all of every image). It saves time where most of the image has no tags. A tag that
    /// jumps may be missing for up to ten images. Predicted tags are never published.
    pub tracking: bool,
}

impl Default for DetectionConfig {
    fn default() -> Self {
        let Options {
            families,
            max_hamming,
            min_margin,
            ..
        } = Options::default();
        Self {
            families,
            max_hamming,
            min_margin,
            tracking: false,
        }
    }
}

impl DetectionConfig {
    /// Options of the detector.
    pub(crate) fn options(&self) -> Options {
        let Self {
            families,
            max_hamming,
            min_margin,
            ..
        } = self.clone();
        Options {
            families,
            max_hamming,
            min_margin,
            ..Options::default()
        }
    }
}

/// Preview images: JPEG, made only while somebody subscribes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PreviewConfig {
    /// Images per second, 0 (none) to 30 (default 5).
    pub rate_hz: f64,
    /// JPEG quality, 10 to 90 (default 60); reduced automatically while an image exceeds 100 kB.
    pub quality: u8,
    /// Widest picture in pixels, 64 to 4096 (default 800); larger images are reduced by a whole factor.
    pub max_width: u16,
}

impl Default for PreviewConfig {
    fn default() -> Self {
        Self {
            rate_hz: 5.0,
            quality: 60,
            max_width: 800,
        }
    }
}

impl SourceConfig {
    /// A simulated camera.
    pub fn simulator(scenario: impl Into<PathBuf>) -> Self {
        Self::Simulator {
            scenario: scenario.into(),
        }
    }

    /// A recording, as recorded.
    pub fn images(folder: impl Into<PathBuf>) -> Self {
        Self::Images {
            folder: folder.into(),
            pace: Pace::Recorded,
            repeat: false,
            start_ns: None,
        }
    }
}

impl CameraNodeConfig {
    /// A configuration with everything else as it is by default.
    pub fn new(
        site: SiteId,
        camera: CameraId,
        source: SourceConfig,
        network: BusOptions,
        shared_memory: IceoryxOptions,
    ) -> Self {
        let (detection, preview) = (DetectionConfig::default(), PreviewConfig::default());
        Self {
            site,
            camera,
            source,
            detection,
            preview,
            network,
            shared_memory,
        }
    }

    /// Reads and checks the file; paths in it become absolute or relative to the working directory.
    ///
    /// # Errors
    /// A missing or malformed file, and values out of their ranges, with line and key.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let mut config: Self = read_toml_checked(file, Self::check)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        config.source.resolve(folder);
        config.shared_memory.root = folder.join(&config.shared_memory.root);
        Ok(config)
    }

    fn check(&self) -> Result<(), Complaint> {
        let PreviewConfig {
            rate_hz,
            quality,
            max_width,
        } = self.preview;
        within("preview.rate_hz", rate_hz, 0.0, 30.0)?;
        within("preview.quality", quality.into(), 10.0, 90.0)?;
        within("preview.max_width", max_width.into(), 64.0, 4096.0)?;
        sextant_apriltag::Detector::new(self.detection.options())
            .map_err(|cause| Complaint::new("detection", cause.to_string(), ""))?;
        self.network
            .check()
            .map_err(|cause| Complaint::new("network", cause.to_string(), ""))?;
        self.source.check()
    }
}

impl SourceConfig {
    fn resolve(&mut self, folder: &Path) {
        match self {
            Self::Simulator { scenario: path } | Self::Images { folder: path, .. } => {
                *path = folder.join(&path)
            }
            Self::Rza2m(config) => config.resolve(folder),
            Self::V4l2 { .. } => {}
        }
    }

    fn check(&self) -> Result<(), Complaint> {
        if let Self::Rza2m(config) = self {
            return config.check();
        }
        let Self::V4l2 {
            resolution: [width, height],
            rate_hz,
            exposure_us,
            readout_us,
            ..
        } = self
        else {
            return Ok(());
        };
        within("source.resolution", f64::from(*width), 16.0, 4096.0)?;
        within("source.resolution", f64::from(*height), 16.0, 3072.0)?;
        within("source.rate_hz", rate_hz.unwrap_or(1.0), 0.1, 1000.0)?;
        let exposure_us = f64::from(exposure_us.unwrap_or(1));
        within("source.exposure_us", exposure_us, 1.0, 1e6)?;
        let readout_us = f64::from(readout_us.unwrap_or(0));
        within("source.readout_us", readout_us, 0.0, 1e5)
    }
}

fn within(key: &str, value: f64, least: f64, most: f64) -> Result<(), Complaint> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Complaint::new(
        key,
        format!("{value} is not from {least} to {most}"),
        "choose a value in that range",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const MINIMAL: &str = "site = \"demo\"\ncamera = \"north\"\n";

    fn read(rest: &str) -> Result<CameraNodeConfig, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("camera.toml");
        fs::write(&file, format!("{MINIMAL}{rest}")).unwrap();
        let start = format!("{}/", folder.path().display());
        CameraNodeConfig::read(&file).map_err(|error| error.to_string().replace(&start, ""))
    }

    #[test]
    fn a_minimal_file_takes_every_default() {
        let config = read("[source]\nkind = \"simulator\"\nscenario = \"s.toml\"\n").unwrap();
        assert_eq!(config.preview, PreviewConfig::default());
        assert_eq!(config.network, BusOptions::default());
        assert_eq!(config.detection.families, [Family::Tag36h11]);
    }

    #[test]
    fn paths_are_relative_to_the_file() {
        let config =
            read("[source]\nkind = \"images\"\nfolder = \"r\"\n[shared_memory]\nroot = \"i\"\n")
                .unwrap();
        let SourceConfig::Images {
            folder,
            pace,
            repeat,
            start_ns,
        } = config.source
        else {
            panic!("{config:?}")
        };
        assert!(folder.is_absolute() && folder.ends_with("r"));
        assert_eq!((pace, repeat, start_ns), (Pace::Recorded, false, None));
        assert!(
            config.shared_memory.root.is_absolute() && config.shared_memory.root.ends_with("i")
        );
        let absolute = read("[source]\nkind = \"images\"\nfolder = \"/r\"\n").unwrap();
        assert_eq!(absolute.source, SourceConfig::images("/r"));
    }

    #[test]
    fn mistakes_are_told_with_their_place() {
        for (rest, expected) in [
            (
                "[source]\nkind = \"simulator\"\nscenery = \"x\"\n",
                "scenery",
            ),
            ("[source]\nkind = \"webcam\"\n", "webcam"),
            (
                "[source]\nkind = \"v4l2\"\ndevice = \"/dev/video0\"\nresolution = [8, 480]\n",
                "camera.toml:6:14: source.resolution",
            ),
            (
                "[source]\nkind = \"v4l2\"\ndevice = \"/dev/video0\"\nresolution = [640, 480]\nreadout_us = 200000\n",
                "camera.toml:7:14: source.readout_us: 200000 is not from 0 to 100000",
            ),
            (
                "[source]\nkind = \"rza2m\"\nresolution = [650, 480]\n",
                "a width of a multiple of 32",
            ),
            (
                "[source]\nkind = \"rza2m\"\n[[source.drp]]\ncircuit = \"median-blur\"\ndata = \"m.dat\"\n",
                "the first circuit must be Bayer2Grayscale",
            ),
            (
                "[source]\nkind = \"rza2m\"\n[[source.drp]]\ncircuit = \"sobel\"\ndata = \"s.dat\"\n",
                "sobel",
            ),
            (
                "[source]\nkind = \"images\"\nfolder = \"r\"\n[preview]\nrate_hz = 99.0\n",
                "camera.toml:7:11: preview.rate_hz",
            ),
            (
                "[source]\nkind = \"images\"\nfolder = \"r\"\n[detection]\nfamilies = []\n",
                "no tag family",
            ),
        ] {
            let error = read(rest).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn the_circuits_of_an_rza2m_lie_beside_the_file() {
        let config = read("[source]\nkind = \"rza2m\"\n[[source.drp]]\ncircuit = \"bayer2grayscale\"\ndata = \"b.dat\"\n").unwrap();
        let SourceConfig::Rza2m(Rza2mConfig {
            resolution, drp, ..
        }) = config.source
        else {
            panic!("{config:?}")
        };
        assert_eq!(resolution, [640, 480]);
        assert!(drp[0].data.is_absolute() && drp[0].data.ends_with("b.dat"));
    }

    #[test]
    fn what_is_written_is_read_back() {
        let config = CameraNodeConfig::new(
            SiteId::new("demo").unwrap(),
            CameraId::new("north").unwrap(),
            SourceConfig::simulator("/s.toml"),
            BusOptions::client_of("tcp/127.0.0.1:7447"),
            IceoryxOptions::default(),
        );
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("camera.toml");
        sextant_site_files::write_toml(&file, &config).unwrap();
        assert_eq!(CameraNodeConfig::read(&file).unwrap(), config);
    }
}
