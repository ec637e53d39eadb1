//! `camera.toml`: configuration of a camera node. Paths are relative to the folder of the file.

mod rza2m;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sextant_apriltag::{Family, Image, Options};
use sextant_iceoryx_images::IceoryxOptions;
use sextant_proto::{Keys, NodeId, NodeKind, SiteId};
use sextant_site_files::{Complaint, FileError, parse_toml, read_text};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{BusError, BusOptions, Identity, Role, Security, SecurityOptions};

pub use self::rza2m::{DrpCircuit, DrpCircuitConfig, Rza2mConfig};

/// The settings of a camera node: contents of `camera.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraNodeConfig {
    /// The site, which is part of every key.
    pub site: SiteId,
    /// Id of the camera in the rig.
    pub camera: CameraId,
    /// Where the images come from; by default the first camera of this host.
    #[serde(default = "SourceConfig::first_camera")]
    pub source: SourceConfig,
    /// What the detector looks for, and how hard.
    #[serde(default)]
    pub detection: DetectionConfig,
    /// Preview images.
    #[serde(default)]
    pub preview: PreviewConfig,
    /// Network session; by default a client of the router on this host.
    #[serde(default)]
    pub network: BusOptions,
    /// How the network is protected; by default by being this machine's own.
    #[serde(default)]
    pub security: SecurityOptions,
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
        /// Exposure in microseconds in place of the scenario's.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exposure_us: Option<f64>,
        /// Gain in place of the scenario's; brightness grows with exposure and gain.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        gain: Option<f64>,
        /// Images a second in place of the scenario's.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rate_hz: Option<f64>,
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
        /// likewise. Give nodes of several hosts the same to play a recording together. Absent: time stamps as
        /// recorded; nodes of one host play a folder together, whenever each is started.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start_ns: Option<u64>,
    },
    /// A camera of this host.
    V4l2(V4l2Config),
    /// The camera of an RZ/A2M.
    Rza2m(Rza2mConfig),
    /// The standard output of a program.
    Command(CommandConfig),
    /// A video file, played as it was taken; needs ffmpeg.
    Video(VideoConfig),
}

/// A camera of this host, by Video4Linux 2. Exposure, gain, readout and controls may change while the node runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct V4l2Config {
    /// The device, best by its place: `/dev/v4l/by-path/...`; empty: the first camera of this host.
    #[serde(default, skip_serializing_if = "is_first_camera")]
    pub device: PathBuf,
    /// Width and height in pixels (default 640x480).
    #[serde(default = "default_resolution")]
    pub resolution: [u32; 2],
    /// Pixel format by its code, such as `YUYV`; absent: the best that the camera has at this size and rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    /// Images a second; absent: the driver's choice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Exposure in microseconds, set on the camera and used to find the middle of the exposure; absent: the
    /// camera's own choice, and the time stamp is taken as it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_us: Option<u32>,
    /// Gain in the driver's own units; absent: the camera's own choice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<u32>,
    /// Microseconds from the first row to the last, of a shutter that rolls: `line_delay` of rig.toml times rows.
    /// Drivers stamp the first row's beginning or the last one's end; the capture time is that of the middle row.
    /// Absent: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub readout_us: Option<u32>,
    /// Further controls of the camera by name, such as `focus_automatic_continuous = 0`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub controls: BTreeMap<String, i32>,
}

/// A program that writes images to its standard output. It is started again when it ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandConfig {
    /// The program and its arguments.
    pub run: CommandLine,
    /// How it writes images.
    pub format: StreamFormat,
    /// Width and height in pixels; needed where the stream does not say: grey and yuv420.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<[u32; 2]>,
    /// Bytes from one row to the next of grey and yuv420, where rows are padded; absent: as `rpicam-vid` pads them, the
    /// width of others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub row_length: Option<u32>,
    /// Milliseconds from the middle of an exposure to the image's arrival here, where they are known; absent: the time
    /// of arrival is taken as it is, and said to be uncertain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency_ms: Option<f64>,
}

/// A program and its arguments; no shell has a part in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CommandLine {
    /// Word by word.
    Words(Vec<String>),
    /// One text, split into words as a shell would, quotes included; nothing else of a shell works in it.
    Text(String),
}

impl CommandLine {
    /// The words, the program first; none where a quote is not closed.
    pub(crate) fn words(&self) -> Option<Vec<String>> {
        match self {
            Self::Words(words) => Some(words.clone()),
            Self::Text(text) => shlex::split(text),
        }
    }
}

/// How a program writes images, one after the other without anything between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StreamFormat {
    /// A byte a pixel, row by row.
    Grey,
    /// The same of the luma, then the chroma planes of half the width and height.
    Yuv420,
    /// JPEGs.
    Mjpeg,
    /// YUV4MPEG2, which says its own size.
    Y4m,
}

/// A video file as source of images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VideoConfig {
    /// The file, in any format that ffmpeg reads.
    pub file: PathBuf,
    /// Whether to begin anew at the end; time stamps go on ascending.
    #[serde(default)]
    pub repeat: bool,
    /// Wire time at which the video begins; give several nodes the same to play videos together. Absent: now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_ns: Option<u64>,
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

/// What the detector looks for, and how hard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectionConfig {
    /// Tag families, at least one (default tag36h11). Each further one costs time and false detections.
    pub families: Vec<Family>,
    /// Most bit errors corrected, 0 to 2 (default 2).
    pub max_hamming: u8,
    /// Least decision margin in grey levels, 0 to 100 (default 4).
    pub min_margin: f32,
    /// Whether tags are printed inverted, white for black (default false).
    pub inverted: bool,
    /// Whether to track tags: each image is searched near earlier tags and, in turn, elsewhere, so that a new tag is
    /// found within ten images (default false: search all of every image). It saves time where most of the image has no
    /// tags. A tag that jumps may be missing for up to ten images. Predicted tags are never published.
    pub tracking: bool,
}

impl Default for DetectionConfig {
    fn default() -> Self {
        let Options {
            families,
            max_hamming,
            min_margin,
            inverted,
            ..
        } = Options::default();
        Self {
            families,
            max_hamming,
            min_margin,
            inverted,
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
            inverted,
            ..
        } = self.clone();
        Options {
            families,
            max_hamming,
            min_margin,
            inverted,
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

/// Whether no device is named.
fn is_first_camera(device: &Path) -> bool {
    device.as_os_str().is_empty()
}

fn default_resolution() -> [u32; 2] {
    [640, 480]
}

impl SourceConfig {
    /// The first camera of this host, in its best format.
    pub fn first_camera() -> Self {
        Self::V4l2(V4l2Config {
            device: PathBuf::new(),
            resolution: default_resolution(),
            format: None,
            rate_hz: None,
            exposure_us: None,
            gain: None,
            readout_us: None,
            controls: BTreeMap::new(),
        })
    }

    /// A camera of a scenario's file, rendered as the file says.
    pub fn simulator(scenario: impl Into<PathBuf>) -> Self {
        Self::Simulator {
            scenario: scenario.into(),
            exposure_us: None,
            gain: None,
            rate_hz: None,
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
        let security = SecurityOptions::default();
        Self {
            site,
            camera,
            source,
            detection,
            preview,
            network,
            security,
            shared_memory,
        }
    }

    /// The keys of those who hold this camera's name: what a camera of a protected site may ask for.
    pub(crate) fn holders(&self) -> anyhow::Result<String> {
        let node = NodeId::new(self.camera.as_str())?;
        let holder = Keys::for_site(self.site.clone()).holder(NodeKind::Camera, &node);
        Ok(format!("{holder}/*/*"))
    }

    /// Reads and checks the file; paths in it become absolute or relative to the working directory.
    ///
    /// # Errors
    /// A missing or malformed file, and values out of their ranges, with line and key.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let mut config = Self::parse(file, &read_text(file)?)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        config.source.resolve(folder);
        config.shared_memory.root = folder.join(&config.shared_memory.root);
        if let Some(keys) = &mut config.security.keys {
            *keys = folder.join(&keys);
        }
        Ok(config)
    }

    /// Checks the text of a file; its paths stay as they are written.
    ///
    /// # Errors
    /// As [`CameraNodeConfig::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, FileError> {
        parse_toml(file, text, Self::check)
    }

    /// The network's protection, with the keys read and checked.
    ///
    /// # Errors
    /// Keys and endpoints that do not go with the profile.
    pub fn protection(&self) -> Result<Security, BusError> {
        let identity = Identity {
            site: self.site.as_str(),
            name: self.camera.as_str(),
            roles: &[Role::Camera],
        };
        self.security.load(Path::new(""), identity, &self.network)
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
            Self::Simulator { scenario: path, .. }
            | Self::Images { folder: path, .. }
            | Self::Video(VideoConfig { file: path, .. }) => *path = folder.join(&path),
            Self::Rza2m(config) => config.resolve(folder),
            Self::V4l2(_) | Self::Command(_) => {}
        }
    }

    fn check(&self) -> Result<(), Complaint> {
        match self {
            Self::Simulator { .. } | Self::Images { .. } | Self::Video(_) => Ok(()),
            Self::V4l2(config) => config.check(),
            Self::Rza2m(config) => config.check(),
            Self::Command(config) => config.check(),
        }
    }
}

impl V4l2Config {
    fn check(&self) -> Result<(), Complaint> {
        check_resolution(self.resolution)?;
        within("source.rate_hz", self.rate_hz.unwrap_or(1.0), 0.1, 1000.0)?;
        let exposure_us = f64::from(self.exposure_us.unwrap_or(1));
        within("source.exposure_us", exposure_us, 1.0, 1e6)?;
        let readout_us = f64::from(self.readout_us.unwrap_or(0));
        within("source.readout_us", readout_us, 0.0, 1e5)
    }
}

impl CommandConfig {
    fn check(&self) -> Result<(), Complaint> {
        let words = self.run.words();
        if words.is_none_or(|words| words.first().is_none_or(String::is_empty)) {
            return Err(Complaint::new(
                "source.run",
                "it names no program, or a quote is not closed",
                "write the program and its arguments as a list of texts",
            ));
        }
        let latency_ms = self.latency_ms.unwrap_or(0.0);
        within("source.latency_ms", latency_ms, 0.0, 60_000.0)?;
        let width = self.resolution.map_or(0, |[width, _]| width);
        if let Some(length) = self.row_length {
            within(
                "source.row_length",
                f64::from(length),
                f64::from(width),
                65_536.0,
            )?;
        }
        match (self.resolution, self.format) {
            (Some(resolution), _) => check_resolution(resolution),
            (None, StreamFormat::Mjpeg | StreamFormat::Y4m) => Ok(()),
            (None, StreamFormat::Grey | StreamFormat::Yuv420) => Err(Complaint::new(
                "source.format",
                "a stream without a size in it",
                "state the images' width and height as resolution",
            )),
        }
    }
}

fn check_resolution([width, height]: [u32; 2]) -> Result<(), Complaint> {
    Image::check_size(width as usize, height as usize).map_err(|error| {
        Complaint::new(
            "source.resolution",
            error.to_string(),
            "choose another resolution",
        )
    })
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
    fn without_a_source_it_is_the_first_camera() {
        let config = read("").unwrap();
        assert_eq!(config.source, SourceConfig::first_camera());
        assert_eq!(
            read("[source]\nkind = \"v4l2\"\n").unwrap().source,
            SourceConfig::first_camera()
        );
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
    fn mistakes_are_reported_with_their_place() {
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
                "[source]\nkind = \"v4l2\"\ndevice = \"/dev/video0\"\nresolution = [640, 480]\nspeed = 1\n",
                "speed",
            ),
            (
                "[source]\nkind = \"command\"\nrun = \"cat 'x\"\nformat = \"mjpeg\"\n",
                "camera.toml:5:7: source.run: it names no program, or a quote is not closed",
            ),
            (
                "[source]\nkind = \"command\"\nrun = []\nformat = \"mjpeg\"\n",
                "it names no program",
            ),
            (
                "[source]\nkind = \"command\"\nrun = [\"cat\"]\nformat = \"grey\"\n",
                "state the images' width and height",
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
        let config = read(
            "[source]\nkind = \"rza2m\"\n[[source.drp]]\n\
            circuit = \"bayer2grayscale\"\ndata = \"b.dat\"\n",
        )
        .unwrap();
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
    fn a_video_is_one_line() {
        let config = read("source = { kind = \"video\", file = \"tags.mp4\" }\n").unwrap();
        let SourceConfig::Video(video) = config.source else {
            panic!("{config:?}")
        };
        assert!(video.file.is_absolute() && video.file.ends_with("tags.mp4"));
        assert_eq!((video.repeat, video.start_ns), (false, None));
    }

    #[test]
    fn a_command_is_a_list_or_a_text_split_like_a_shells() {
        for run in ["[\"my cam\", \"-t\", \"0\"]", "\"'my cam' -t 0\""] {
            let rest = format!("[source]\nkind = \"command\"\nrun = {run}\nformat = \"y4m\"\n");
            let SourceConfig::Command(command) = read(&rest).unwrap().source else {
                panic!("{run}")
            };
            assert_eq!(command.run.words().unwrap(), ["my cam", "-t", "0"]);
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let v4l2 = V4l2Config {
            device: "/dev/video0".into(),
            resolution: [640, 480],
            format: Some("YUYV".to_owned()),
            rate_hz: Some(30.0),
            exposure_us: Some(4000),
            gain: Some(16),
            readout_us: None,
            controls: [("focus_absolute".to_owned(), 0)].into(),
        };
        let command = CommandConfig {
            run: CommandLine::Words(vec!["rpicam-vid".to_owned()]),
            format: StreamFormat::Yuv420,
            row_length: None,
            resolution: Some([640, 480]),
            latency_ms: Some(40.0),
        };
        let video = VideoConfig {
            file: "/tags.mp4".into(),
            repeat: true,
            start_ns: None,
        };
        for source in [
            SourceConfig::simulator("/s.toml"),
            SourceConfig::V4l2(v4l2),
            SourceConfig::Command(command),
            SourceConfig::Video(video),
        ] {
            let config = CameraNodeConfig::new(
                SiteId::new("demo").unwrap(),
                CameraId::new("north").unwrap(),
                source,
                BusOptions::client_of("tcp/127.0.0.1:7447"),
                IceoryxOptions::default(),
            );
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("camera.toml");
            sextant_site_files::write_toml(&file, &config).unwrap();
            assert_eq!(CameraNodeConfig::read(&file).unwrap(), config);
        }
    }
}
