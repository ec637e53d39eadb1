//! Status of a camera node, about once a second, with the quality of its clock.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::{MAX_CAMERA_NOTICES, MAX_TIME_NS};
use crate::messages::camera_notice::CameraNotice;
use crate::messages::camera_settings::CameraControls;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// What disciplines a clock. On the wire the number of the variant, from 0.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum ClockSource {
    /// Unknown.
    #[default]
    Unknown,
    /// The board's own crystal, not set by anything.
    FreeRunning,
    /// NTP, as chrony or systemd-timesyncd keep it.
    Ntp,
    /// PTP.
    Ptp,
    /// Time stamps of recorded images.
    Recorded,
    /// The simulator's virtual clock.
    Simulated,
    /// The board's clock when the image arrived, later than its exposure by an unknown delay.
    Arrival,
}

impl ClockSource {
    /// Its name on every surface.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::FreeRunning => "free-running",
            Self::Ntp => "ntp",
            Self::Ptp => "ptp",
            Self::Recorded => "recorded",
            Self::Simulated => "simulated",
            Self::Arrival => "arrival",
        }
    }
}

/// A clock's source and error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ClockQuality {
    /// What disciplines it.
    pub source: ClockSource,
    /// Estimated error, ns, one standard deviation; 0 where it does not apply (recorded, simulated).
    pub error_ns: u64,
}

impl ClockQuality {
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        holds(self.error_ns <= MAX_TIME_NS, "clock.error_ns")
    }
}

/// Status of a camera node. Counts are since the process started.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraStatus {
    /// The camera; the same as in the key.
    pub camera: CameraId,
    /// Version of the software.
    pub version: String,
    /// Name of the machine.
    pub host: String,
    /// Images that the capture process took.
    pub captured: u64,
    /// Images that went through the detector.
    pub detected: u64,
    /// Images captured but not detected, because a newer one was there.
    pub dropped: u64,
    /// Images detected per second, over the last seconds.
    pub rate_hz: f32,
    /// Time of detection an image, milliseconds: median and 99th percentile of the last seconds.
    pub detect_ms: [f32; 2],
    /// The board's clock.
    pub clock: ClockQuality,
    /// Seconds since the process started.
    pub uptime_s: u64,
    /// Observations handed to the network.
    pub published: u64,
    /// Images that the CPU made in place of an accelerator, since the camera was opened.
    pub fallbacks: u64,
    /// Mean grey level of the last image, 0 to 255; 0 before the first.
    pub brightness: f32,
    /// Exposure, gain and rate.
    pub controls: CameraControls,
    /// What a person should know.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_CAMERA_NOTICES>")]
    pub notices: Vec<CameraNotice>,
}

impl Message for CameraStatus {
    const KIND: MessageKind = MessageKind::CameraStatus;

    fn check(&self) -> Result<(), OutOfRange> {
        check::name(&self.version, "version")?;
        check::name(&self.host, "host")?;
        check::amount(f64::from(self.rate_hz), "rate_hz")?;
        for ms in self.detect_ms {
            check::amount(f64::from(ms), "detect_ms")?;
        }
        self.clock.check()?;
        holds((0.0..=255.0).contains(&self.brightness), "brightness")?;
        self.controls.check()?;
        holds(self.notices.len() <= MAX_CAMERA_NOTICES, "notices")?;
        self.notices.iter().try_for_each(CameraNotice::check)
    }
}
