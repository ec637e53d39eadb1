//! Where images come from: one trait, six sources. Images are filled straight into shared memory.

mod backlog;
mod command;
mod common_start;
pub(crate) mod examine;
mod host_clock;
mod images;
mod pixel_formats;
mod reopening;
mod rza2m;
mod simulator;
pub mod v4l2;
mod video;

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use sextant_apriltag::{Image, ImageError};
use sextant_iceoryx_images::{ClockSource, IceoryxOptions, companion_file};
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use sextant_proto::CameraControls;
use sextant_site_model::CameraId;

use self::reopening::Reopening;
use crate::config::SourceConfig;

/// A camera, real or not.
pub trait ImageSource {
    /// Width and height of every image, in pixels.
    fn resolution(&self) -> [u16; 2];

    /// Waits for the next image and fills `pixels` (width x height bytes, row by row without gaps, 0 black) with it.
    /// Returns within 200 ms with [`Next::Nothing`] when there is none, and as soon as `shutdown` is requested. Until
    /// an image was handed over, each call gets the same pixels again, as the last call left them.
    ///
    /// # Errors
    /// What ends the source for good, with the exit code that it deserves.
    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError>;

    /// Images that the CPU had to make in place of an accelerator.
    fn fallbacks(&self) -> u64 {
        0
    }

    /// Exposure, gain and rate that the source has now, with what the site wants left out; none while it cannot be
    /// reached.
    fn controls(&self) -> Option<CameraControls> {
        Some(CameraControls::default())
    }

    /// Takes a changed configuration while it runs, as far as it can.
    ///
    /// # Errors
    /// Settings that the camera cannot have; it keeps its own.
    fn reconfigure(&mut self, _config: &SourceConfig) -> Result<Reconfigured, SourceError> {
        Ok(Reconfigured::NeedsRestart)
    }
}

/// What became of a changed configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reconfigured {
    /// It is in force.
    Done,
    /// It can only be had by opening the source anew.
    NeedsReopening,
    /// It can only be had by starting the node again; nothing has changed.
    NeedsRestart,
}

/// What became of waiting for an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// One was filled in.
    Image(Capture),
    /// None yet.
    Nothing,
    /// There will be none any more: a recording's end.
    End,
}

/// What the source knows of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capture {
    /// Its number among all images that the source had for us, from 0; a gap is an image that was lost before this.
    pub sequence: u64,
    /// Middle of the exposure, ns since the Unix epoch, by the camera's clock.
    pub capture_ns: u64,
    /// Length of the exposure, ns; 0 if unknown.
    pub exposure_ns: u32,
    /// What keeps the camera's clock right.
    pub clock: ClockSource,
    /// Its estimated error, ns, one standard deviation.
    pub clock_error_ns: u64,
    /// The camera's clock minus this host's, ns.
    pub clock_offset_ns: i64,
}

/// A failure of a source, with the exit code that it deserves.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct SourceError {
    exit: Exit,
    message: String,
}

impl SourceError {
    /// A failure; `exit` says whose it is.
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self {
            exit,
            message: message.into(),
        }
    }
}

impl SourceError {
    /// The same, of a device.
    pub(crate) fn for_device(self, device: &Path) -> Self {
        Self::new(self.exit, format!("{}: {}", device.display(), self.message))
    }

    /// As the end of a process.
    pub(crate) fn into_failure(self) -> anyhow::Error {
        Failure::new(self.exit, self).into()
    }
}

/// Opens the source of a camera.
pub(crate) fn open(
    config: &SourceConfig,
    camera: &CameraId,
    place: &IceoryxOptions,
    shutdown: &Shutdown,
) -> anyhow::Result<Box<dyn ImageSource>> {
    match config {
        SourceConfig::Simulator { .. } => Ok(Box::new(
            simulator::SimulatedCamera::open(config, camera).exit_with(Exit::Input)?,
        )),
        SourceConfig::Images {
            folder,
            pace,
            repeat,
            start_ns,
        } => {
            let play = images::Play {
                pace: *pace,
                repeat: *repeat,
                start_ns: *start_ns,
                shared: Some(shared_by_players(folder, place)?),
            };
            let player = images::Player::open(folder, camera, play);
            Ok(Box::new(player.exit_with(Exit::Input)?))
        }
        SourceConfig::V4l2(v4l2) => {
            let period = v4l2.rate_hz.map(|hz| Duration::from_secs_f64(1.0 / hz));
            reopening(config, camera, shutdown, period)
        }
        SourceConfig::Rza2m(rza2m) => {
            let period = rza2m.rate_hz.map(|hz| Duration::from_secs_f64(1.0 / hz));
            reopening(config, camera, shutdown, period)
        }
        SourceConfig::Command(_) => reopening(config, camera, shutdown, None),
        SourceConfig::Video(video) => {
            let player = video::VideoPlayer::open(video, shutdown);
            let player = player.map_err(SourceError::into_failure);
            Ok(Box::new(
                player.with_context(|| format!("camera {camera}"))?,
            ))
        }
    }
}

/// The file that the nodes of this host share which play the recording in this folder.
fn shared_by_players(folder: &Path, place: &IceoryxOptions) -> anyhow::Result<PathBuf> {
    let mut hasher = DefaultHasher::new();
    std::fs::canonicalize(folder)
        .unwrap_or_else(|_| folder.to_owned())
        .hash(&mut hasher);
    let name = format!("playing-{:016x}", hasher.finish());
    companion_file(place, &name).exit_with(Exit::Input)
}

/// A source that may fail and come back.
fn reopening(
    config: &SourceConfig,
    camera: &CameraId,
    shutdown: &Shutdown,
    period: Option<Duration>,
) -> anyhow::Result<Box<dyn ImageSource>> {
    let shutdown = shutdown.clone();
    let open = move |config: &SourceConfig| match config {
        SourceConfig::V4l2(config) => v4l2::open(config),
        SourceConfig::Rza2m(config) => rza2m::open(config),
        SourceConfig::Command(config) => command::open(config, &shutdown),
        SourceConfig::Simulator { .. } | SourceConfig::Images { .. } | SourceConfig::Video(_) => {
            Err(SourceError::new(Exit::Input, "another source than before"))
        }
    };
    let opened = Reopening::new(config, open, period).map_err(SourceError::into_failure);
    Ok(Box::new(
        opened.with_context(|| format!("camera {camera}"))?,
    ))
}

/// A resolution as messages have it, or why the detector does not take images of this size.
pub(crate) fn checked_resolution(width: usize, height: usize) -> Result<[u16; 2], ImageError> {
    Image::check_size(width, height)?;
    Ok([width as u16, height as u16])
}
