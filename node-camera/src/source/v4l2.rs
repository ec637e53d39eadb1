//! A camera of this host by Video4Linux 2: any format that [`super::pixel_formats`] reads, memory-mapped buffers, time
//! stamps of the driver. Our own few calls, since no crate fits 32-bit boards with old kernels.
//!
//! - `device`: the requests, a trait. `kernel`: the device's file behind it, with the kernel's structures in `abi`.
//! - `negotiation`: format and size. `controls`: exposure, gain and the like. `timing`: what stamps and numbers mean.
//! - `stream`: buffers that go round between driver and us.
//! - `probe`: what cameras there are, and a first `camera.toml`.

mod abi;
mod controls;
mod device;
#[cfg(test)]
mod fake;
mod kernel;
mod negotiation;
pub mod probe;
mod stream;
#[cfg(test)]
mod tests;
mod timing;

use std::path::Path;
use std::time::{Duration, Instant};

use sextant_process::clock::{monotonic_ns, wall_from_monotonic_ns};
use sextant_process::{Exit, Shutdown};
use sextant_proto::{CameraControls, Control};

use self::controls::InForce;
use self::device::{Api, Device, Format, Identity, Wake};
use self::kernel::KernelDevice;
use self::stream::{Stream, StreamError};
use self::timing::{SequenceCounter, Stamp};
use super::backlog::{Backlog, LOOK};
use super::host_clock::{HostClock, Stamped, Taken};
use super::pixel_formats::{Coding, Geometry, GreyReader, PixelFormat};
use super::{Capture, ImageSource, Next, Reconfigured, SourceError, checked_resolution};
use crate::config::{SourceConfig, V4l2Config};

/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);
/// Before a driver is asked again that woke us for nothing.
const IDLE_WAKE: Duration = Duration::from_millis(2);

const CAP_VIDEO_CAPTURE: u32 = 0x0000_0001;
const CAP_VIDEO_CAPTURE_MPLANE: u32 = 0x0000_1000;
const CAP_STREAMING: u32 = 0x0400_0000;
const FLAG_ERROR: u32 = 0x0000_0040;

/// The camera, streaming.
struct V4l2Camera<D: Device> {
    config: V4l2Config,
    stream: Stream<D>,
    reader: GreyReader,
    resolution: [u16; 2],
    in_force: InForce,
    rate_hz: Control,
    sequence: SequenceCounter,
    clock: HostClock,
    /// Of drivers that do not say when an image was taken.
    backlog: Backlog,
}

/// Opens a camera, sets it up as the file says and starts it.
pub(crate) fn open(config: &V4l2Config) -> Result<Box<dyn ImageSource>, SourceError> {
    let config = &with_device(config)?;
    Ok(Box::new(V4l2Camera::start(open_device(config)?, config)?))
}

/// Looks whether a camera is there and has what the file asks for.
///
/// # Errors
/// As [`open`].
pub(crate) fn examine(config: &V4l2Config) -> Result<String, SourceError> {
    let config = &with_device(config)?;
    let setup = Setup::choose(&open_device(config)?, config)?;
    let Setup {
        identity, format, ..
    } = setup;
    let [width, height] = format.size;
    let name = PixelFormat::name(format.fourcc);
    Ok(format!("{}: {width}x{height} in {name}", identity.card))
}

/// The configuration with the first camera's device where none is named.
fn with_device(config: &V4l2Config) -> Result<V4l2Config, SourceError> {
    let mut config = config.clone();
    if config.device.as_os_str().is_empty() {
        let cameras = probe::cameras().into_iter().flatten();
        let mut readable =
            cameras.filter(|camera| camera.formats.iter().any(|format| format.is_readable));
        let Some(first) = readable.next() else {
            let message = "this host has no camera that is read by V4L2; name another [source] (docs/cameras.md)";
            return Err(SourceError::new(Exit::Unavailable, message));
        };
        config.device = first.device;
    }
    Ok(config)
}

fn open_device(config: &V4l2Config) -> Result<KernelDevice, SourceError> {
    let opened = KernelDevice::open(&config.device);
    opened.map_err(|cause| device_error(&config.device, "cannot be opened", &cause))
}

/// What a camera and the file have agreed upon.
struct Setup {
    identity: Identity,
    api: Api,
    format: Format,
    coding: Coding,
}

impl Setup {
    fn choose(device: &impl Device, config: &V4l2Config) -> Result<Self, SourceError> {
        let path = &config.device;
        let identity = device
            .identity()
            .map_err(|cause| device_error(path, "cannot be asked what it is", &cause))?;
        let unusable = |lack: &str| unusable(path, &identity, lack);
        let api = api_of(&identity).map_err(unusable)?;
        let negotiated = negotiation::negotiate(device, api, config);
        let (format, coding) = negotiated.map_err(|lack| unusable(&lack))?;
        Ok(Self {
            identity,
            api,
            format,
            coding,
        })
    }
}

impl<D: Device> V4l2Camera<D> {
    fn start(device: D, config: &V4l2Config) -> Result<Self, SourceError> {
        let path = &config.device;
        let Setup {
            identity,
            api,
            format,
            coding,
        } = Setup::choose(&device, config)?;
        let geometry = geometry(&format, coding);
        let resolution = checked_resolution(geometry.width, geometry.height)
            .map_err(|error| unusable(path, &identity, &error.to_string()))?;
        let rate_hz = Control {
            wanted: None,
            value: set_rate(&device, api, config),
            range: rate_range(&device, &format),
        };
        let in_force =
            controls::apply(&device, config, None).map_err(|cause| cause.for_device(path))?;
        tracing::info!(
            device = %path.display(),
            card = identity.card,
            format = PixelFormat::name(format.fourcc),
            width = geometry.width,
            height = geometry.height,
            "camera"
        );
        let stream = Stream::start(device, api).map_err(|failure| stream_error(path, failure))?;
        Ok(Self {
            config: config.clone(),
            stream,
            reader: GreyReader::new(coding, geometry),
            resolution,
            in_force,
            rate_hz,
            sequence: SequenceCounter::default(),
            clock: HostClock::default(),
            backlog: Backlog::default(),
        })
    }

    fn failed(&self, failure: StreamError) -> SourceError {
        stream_error(&self.config.device, failure)
    }

    fn capture(&mut self, sequence: u64, stamp: Stamp) -> Capture {
        let readout_ns = self.config.readout_us.unwrap_or(0).saturating_mul(1000);
        let exposure_ns = self.in_force.exposure_ns();
        let middle_ns = stamp.middle_of_exposure_ns(exposure_ns, readout_ns, monotonic_ns());
        self.clock.capture(Taken {
            sequence,
            capture_ns: wall_from_monotonic_ns(middle_ns),
            exposure_ns,
            stamped: match stamp {
                Stamp::None => Stamped::OnArrival,
                Stamp::StartOfExposure(_) | Stamp::EndOfFrame(_) => Stamped::ByDriver,
            },
        })
    }
}

impl<D: Device> ImageSource for V4l2Camera<D> {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let begun = Instant::now();
        let woken = self.stream.wait(shutdown, LONGEST_WAIT.min(LOOK));
        self.backlog.looked(begun, Instant::now());
        match woken.map_err(|failure| self.failed(failure))? {
            Wake::Ready => {}
            Wake::Nothing => return Ok(Next::Nothing),
            Wake::Changed => {
                let message = format!(
                    "{}: its source has images of another kind now",
                    self.config.device.display()
                );
                return Err(SourceError::new(Exit::Unavailable, message));
            }
        }
        let taken = self.stream.take();
        let Some(buffer) = taken.map_err(|failure| self.failed(failure))? else {
            shutdown.wait(IDLE_WAKE);
            return Ok(Next::Nothing);
        };
        let sequence = self.sequence.count(buffer.sequence);
        let mut read = Ok(());
        let reader = &mut self.reader;
        let mut look = |image: &[u8]| read = reader.read(image, pixels);
        self.stream.device().look_at(&buffer, &mut look);
        let given_back = self.stream.give_back(buffer.index);
        given_back.map_err(|failure| self.failed(failure))?;
        if buffer.flags & FLAG_ERROR != 0 {
            tracing::warn!("the driver says that an image is damaged; it is passed over");
            return Ok(Next::Nothing);
        }
        if let Err(cause) = read {
            tracing::warn!(%cause, "an image is damaged; it is passed over");
            return Ok(Next::Nothing);
        }
        let stamp = Stamp::from_buffer(&buffer);
        let is_known = self.backlog.is_time_known(Instant::now());
        self.backlog.image_ended();
        if stamp == Stamp::None && !is_known {
            tracing::warn!(
                "an image waited while this process stood still; its driver does not say when it \
                 was taken, and it is dropped"
            );
            return Ok(Next::Nothing);
        }
        Ok(Next::Image(self.capture(sequence, stamp)))
    }

    fn controls(&self) -> Option<CameraControls> {
        Some(CameraControls {
            exposure_us: self.in_force.exposure_us,
            gain: self.in_force.gain,
            rate_hz: self.rate_hz,
            ..CameraControls::default()
        })
    }

    fn reconfigure(&mut self, config: &SourceConfig) -> Result<Reconfigured, SourceError> {
        let SourceConfig::V4l2(config) = config else {
            return Ok(Reconfigured::NeedsRestart);
        };
        let mut config = config.clone();
        if config.device.as_os_str().is_empty() {
            config.device.clone_from(&self.config.device);
        }
        let config = &config;
        let streams_alike = V4l2Config {
            exposure_us: config.exposure_us,
            gain: config.gain,
            readout_us: config.readout_us,
            controls: config.controls.clone(),
            ..self.config.clone()
        };
        if streams_alike != *config {
            let fits = config.resolution == self.config.resolution;
            return Ok(if fits {
                Reconfigured::NeedsReopening
            } else {
                Reconfigured::NeedsRestart
            });
        }
        let applied = controls::apply(self.stream.device(), config, Some(&self.config));
        self.in_force = applied.map_err(|cause| cause.for_device(&config.device))?;
        self.config = config.clone();
        Ok(Reconfigured::Done)
    }
}

/// The interface by which a device captures.
fn api_of(identity: &Identity) -> Result<Api, &'static str> {
    let has = |ability: u32| identity.abilities & ability != 0;
    let api = if has(CAP_VIDEO_CAPTURE) {
        Api::SinglePlanar
    } else if has(CAP_VIDEO_CAPTURE_MPLANE) {
        Api::MultiPlanar
    } else {
        return Err(
            "it does not capture video; a camera often has several devices, of which the first captures",
        );
    };
    if has(CAP_STREAMING) {
        Ok(api)
    } else {
        Err("it does not stream into mapped memory")
    }
}

fn geometry(format: &Format, coding: Coding) -> Geometry {
    let [width, height] = format.size.map(|length| length as usize);
    let stride = match coding {
        Coding::Luma(_) | Coding::Mosaic(_) => format.stride as usize,
        Coding::Jpeg => 0,
    };
    Geometry {
        width,
        height,
        stride,
    }
}

/// Asks for the rate that is configured and returns the one that the driver takes; a driver without a choice keeps its
/// own.
fn set_rate(device: &impl Device, api: Api, config: &V4l2Config) -> Option<f64> {
    let requested = device::Fraction([1000, (config.rate_hz? * 1000.0).round() as u32]);
    match device.set_interval(api, requested) {
        Ok(interval) => {
            tracing::info!(rate_hz = interval.rate_hz(), "images a second");
            interval.rate_hz()
        }
        Err(cause) => {
            tracing::warn!(%cause, "the camera keeps its own rate");
            None
        }
    }
}

/// Least and greatest rate of a format.
fn rate_range(device: &impl Device, format: &Format) -> Option<[f64; 2]> {
    let rates = negotiation::rates_hz(device, format.fourcc, format.size);
    Some([*rates.last()?, *rates.first()?])
}

fn stream_error(path: &Path, StreamError { what, cause }: StreamError) -> SourceError {
    device_error(path, what, &cause)
}

/// A device that lacks something.
fn unusable(path: &Path, identity: &Identity, lack: &str) -> SourceError {
    let (path, card) = (path.display(), &identity.card);
    let message = format!("{path} ({card}) cannot be used: {lack}");
    SourceError::new(Exit::Unavailable, message)
}

/// An error of a device: out of reach, busy, or not what is needed.
fn device_error(path: &Path, what: &str, cause: &std::io::Error) -> SourceError {
    let remedy = match cause.raw_os_error() {
        Some(libc::ENOENT) => "; is it plugged in? `sextant camera --probe` lists the cameras",
        Some(libc::EACCES) => "; join the group that owns it (usually `video`)",
        Some(libc::EBUSY) => "; another program uses it",
        Some(libc::ENODEV | libc::ENXIO) => "; it was unplugged",
        Some(libc::ENOTTY | libc::EINVAL) => "; is it a camera?",
        Some(libc::ENOSPC) => {
            "; the USB bus has no bandwidth left: choose a smaller size or rate, MJPG, or another port"
        }
        _ => "",
    };
    SourceError::new(
        Exit::Unavailable,
        format!("{}: {what}: {cause}{remedy}", path.display()),
    )
}
