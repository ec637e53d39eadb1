//! A camera of this host by Video4Linux 2: grey or YUYV (of which the luma is taken), memory-mapped buffers, time stamps of
//! the driver. Our own few calls, since no crate fits 32-bit boards with old kernels.
//!
//! - `abi`: the kernel's structures and call numbers.
//! - `device`: the calls, safe.
//! - `stream`: mapped buffers that go round between driver and us.

mod abi;
mod device;
mod stream;

use std::path::{Path, PathBuf};
use std::time::Duration;

use sextant_iceoryx_images::ClockSource;
use sextant_process::clock::wall_from_monotonic_ns;
use sextant_process::{ClockQuality, Exit, Shutdown, now_ns};

use self::abi::{FOURCC_GREY, FOURCC_YUYV};
use self::device::{Device, Layout};
use self::stream::{Frame, Stamp, Stream};
use super::{Capture, ImageSource, Next, SourceError, checked_resolution};

/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);
/// How often the clock's quality is read, in images.
const QUALITY_PERIOD: u64 = 30;

/// What is asked of the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wish {
    pub(crate) resolution: [u32; 2],
    pub(crate) rate_hz: Option<f64>,
    pub(crate) exposure_us: Option<u32>,
    pub(crate) readout_us: Option<u32>,
}

/// The camera, streaming.
pub(crate) struct V4l2Camera {
    path: PathBuf,
    stream: Stream,
    layout: Layout,
    resolution: [u16; 2],
    exposure_ns: u32,
    readout_ns: u32,
    first_sequence: Option<u32>,
    taken: u64,
    quality: ClockQuality,
}

impl V4l2Camera {
    /// Opens the device, sets it up as wished and starts it.
    pub(crate) fn open(path: &Path, wish: &Wish) -> Result<Self, SourceError> {
        let device = Device::open(path)?;
        let layout = choose_layout(&device, wish)?;
        let resolution = checked_resolution(layout.width, layout.height)
            .ok_or_else(|| device.unusable("a resolution outside 16x16 to 4096x3072"))?;
        if let Some(rate_hz) = wish.rate_hz {
            device.set_rate(rate_hz);
        }
        let exposure_ns = wish.exposure_us.map_or(0, |wished_us| {
            device.set_exposure_us(wished_us).saturating_mul(1000)
        });
        tracing::info!(device = %path.display(), card = device.card(), width = layout.width, height = layout.height, "camera");
        Ok(Self {
            path: path.to_owned(),
            stream: Stream::start(device)?,
            layout,
            resolution,
            exposure_ns,
            readout_ns: wish.readout_us.unwrap_or(0).saturating_mul(1000),
            first_sequence: None,
            taken: 0,
            quality: ClockQuality::read(),
        })
    }

    fn capture(&mut self, frame: &Frame<'_>) -> Capture {
        if self.taken.is_multiple_of(QUALITY_PERIOD) {
            self.quality = ClockQuality::read();
        }
        let first = *self.first_sequence.get_or_insert(frame.sequence);
        // Some drivers never count; then our own count is all there is.
        let sequence = u64::from(frame.sequence.wrapping_sub(first)).max(self.taken);
        self.taken = sequence + 1;
        Capture {
            sequence,
            capture_ns: middle_of_exposure_ns(frame.stamp, self.exposure_ns, self.readout_ns),
            exposure_ns: self.exposure_ns,
            clock: if self.quality.synchronised {
                ClockSource::Ntp
            } else {
                ClockSource::FreeRunning
            },
            clock_error_ns: self.quality.error_ns,
            clock_offset_ns: 0,
        }
    }
}

impl ImageSource for V4l2Camera {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        if !self.stream.wait(shutdown, LONGEST_WAIT)? {
            return Ok(Next::Nothing);
        }
        let Some(frame) = self.stream.take()? else {
            return Ok(Next::Nothing);
        };
        let is_whole = self.layout.copy_luma(frame.bytes, pixels);
        let (sequence, stamp) = (frame.sequence, frame.stamp);
        self.stream.give_back(frame.index)?;
        if !is_whole {
            tracing::warn!(device = %self.path.display(), "an incomplete image is passed over");
            return Ok(Next::Nothing);
        }
        Ok(Next::Image(self.capture(&Frame {
            bytes: &[],
            index: 0,
            sequence,
            stamp,
        })))
    }
}

/// Grey if the camera has it, else YUYV, in exactly the resolution that was asked for.
fn choose_layout(device: &Device, wish: &Wish) -> Result<Layout, SourceError> {
    let [width, height] = wish.resolution;
    let mut offers = Vec::new();
    for fourcc in [FOURCC_GREY, FOURCC_YUYV] {
        let layout = device.set_format(width, height, fourcc)?;
        if layout.fourcc == fourcc
            && (layout.width, layout.height) == (width as usize, height as usize)
        {
            return Ok(layout);
        }
        offers.push(layout.to_string());
    }
    let offers = offers.join(" or ");
    Err(device.unusable(&format!(
        "no {width}x{height} image in GREY or YUYV; it offers {offers} instead"
    )))
}

/// The driver stamps the start of the exposure or the end of the transfer; without a stamp of the monotonic clock there is
/// only the time at which we got the image. The middle row is exposed half the readout after the first and before the last.
fn middle_of_exposure_ns(stamp: Stamp, exposure_ns: u32, readout_ns: u32) -> u64 {
    let half = (u64::from(exposure_ns) + u64::from(readout_ns)) / 2;
    match stamp {
        Stamp::StartOfExposure(monotonic_ns) => {
            wall_from_monotonic_ns(monotonic_ns).saturating_add(half)
        }
        Stamp::EndOfFrame(monotonic_ns) => {
            wall_from_monotonic_ns(monotonic_ns).saturating_sub(half)
        }
        Stamp::None => now_ns().saturating_sub(half),
    }
}

/// An error of a device: out of reach, busy, or not what is needed.
fn device_error(path: &Path, what: &str, cause: &std::io::Error) -> SourceError {
    let remedy = match cause.raw_os_error() {
        Some(libc::ENOENT) => "; is it plugged in?",
        Some(libc::EACCES) => "; join the group that owns it (usually `video`)",
        Some(libc::EBUSY) => "; another program uses it",
        Some(libc::ENODEV | libc::ENXIO) => "; it was unplugged",
        Some(libc::ENOTTY | libc::EINVAL) => "; is it a camera?",
        _ => "",
    };
    SourceError::new(
        Exit::Unavailable,
        format!("{}: {what}: {cause}{remedy}", path.display()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const WISH: Wish = Wish {
        resolution: [640, 480],
        rate_hz: None,
        exposure_us: None,
        readout_us: None,
    };

    fn refusal(path: &str) -> String {
        V4l2Camera::open(Path::new(path), &WISH)
            .err()
            .unwrap()
            .to_string()
    }

    #[test]
    fn what_is_no_camera_is_refused_with_a_remedy() {
        assert!(refusal("/dev/video-none").contains("is it plugged in?"));
        assert!(refusal("/dev/null").contains("is it a camera?"));
    }

    #[test]
    fn the_middle_of_the_exposure_lies_on_the_right_side_of_the_stamp() {
        let stamp = sextant_process::clock::monotonic_ns();
        for readout_ns in [0, 20_000_000] {
            let start =
                middle_of_exposure_ns(Stamp::StartOfExposure(stamp), 10_000_000, readout_ns);
            let end = middle_of_exposure_ns(Stamp::EndOfFrame(stamp), 10_000_000, readout_ns);
            let whole = 10_000_000 + u64::from(readout_ns);
            assert!((start - end).abs_diff(whole) < 5_000_000, "{start} {end}");
        }
    }
}
