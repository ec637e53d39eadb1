//! The camera: sensor, receiver and VIN as one source of raw images in on-chip memory.

use crate::frame_clock::FrameClock;
use crate::imx219::{Identity, Imx219, SHORTEST_FRAME, longest_exposure};
use crate::sensor_bus::ADDRESS;
use crate::{OnChipLayout, PhysicalMemory, SensorBus, vin};
use std::io;
use std::time::Duration;

/// What the sensor needs after its reset: 2 ms in the vendor's demonstration.
const RESET_PAUSE: Duration = Duration::from_millis(10);
/// How long VIN may take to end the image that it is writing, in polls of 1 ms.
const STOP_POLLS: u32 = 200;
/// The first image must arrive within this, ns.
const FIRST_IMAGE_NS: u64 = 2_000_000_000;
/// New exposures and frame lengths hold from the second image after them on; one more is passed over.
const SETTLING: u64 = 3;

/// What is asked of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSettings {
    /// Width, a multiple of 32, and height, even, in pixels; at most 800x480.
    pub resolution: [u16; 2],
    /// Images a second; none: as many as the sensor gives.
    pub rate_hz: Option<f64>,
    /// Exposure in microseconds.
    pub exposure_us: u32,
    /// Analog gain, 1 to 10.66.
    pub gain: f64,
}

/// Why there are no images.
#[derive(Debug, thiserror::Error)]
pub enum CameraError {
    /// Nothing answers on the bus.
    #[error(
        "no sensor answers at I2C address {ADDRESS:#04x} ({0}): check the ribbon cable and its \
         direction, and that the bus is the camera connector's"
    )]
    Silent(io::Error),
    /// Another sensor.
    #[error(
        "the sensor reports model {0:#06x}; only the IMX219 (0x0219, Raspberry Pi Camera Module 2) is supported"
    )]
    OtherSensor(u16),
    /// The sensor's registers can be read, but nothing arrives.
    #[error(
        "the sensor answers over I2C, but no image arrives over CSI-2: check the cable's seat, \
         power the board off and on"
    )]
    NoImage,
    /// VIN keeps writing.
    #[error(
        "VIN does not stop capturing; end other programs that use the camera, or restart the board"
    )]
    Busy,
    /// Size, rate, exposure or gain out of range.
    #[error("{0}")]
    Settings(&'static str),
    /// Memory, registers or a sensor that answered before.
    #[error("{what}: {cause}")]
    Io {
        /// What failed.
        what: &'static str,
        /// Why.
        cause: io::Error,
    },
}

/// A raw image in on-chip memory, there until VIN fills its buffer again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Physical address: width x height bytes, RGGB.
    pub address: u32,
    /// Its number; a gap are images that were lost.
    pub number: u64,
    /// Middle of the middle row's exposure, ns of the caller's monotonic clock.
    pub exposed_ns: u64,
    /// Length of the exposure, ns.
    pub exposure_ns: u32,
    /// How far `exposed_ns` may be off because arrivals are polled, ns.
    pub tolerance_ns: u64,
    buffer: usize,
    arrived_ns: u64,
}

/// A running sensor with its three buffers in on-chip memory.
#[derive(Debug)]
pub struct Camera<B> {
    sensor: Imx219<B>,
    settings: CameraSettings,
    buffers: [u32; 3],
    clock: FrameClock,
    state: CameraState,
    started_ns: Option<u64>,
    polled_ns: u64,
    frame_lines: u16,
    exposure_lines: u16,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CameraState {
    /// Images are counted only, until the frame period is known.
    Measuring,
    /// Images before the exposure holds.
    Settling,
    /// Images are handed over; the first of them had this number.
    Running(u64),
}

impl CameraSettings {
    /// Whether the camera can have them.
    ///
    /// # Errors
    /// What it cannot.
    pub fn check(&self) -> Result<(), CameraError> {
        let [width, height] = self.resolution;
        let in_range = |n: u16, step: u16, least: u16, most: u16| {
            n.is_multiple_of(step) && (least..=most).contains(&n)
        };
        let refuse = |why| Err(CameraError::Settings(why));
        if !in_range(width, vin::WIDTH_STEP, vin::WIDTH_STEP, vin::LARGEST[0])
            || !in_range(height, 2, 16, vin::LARGEST[1])
        {
            return refuse(
                "the resolution must be 32x16 to 800x480, with a width of a multiple of 32 and an even height",
            );
        }
        if !self
            .rate_hz
            .is_none_or(|rate_hz| (0.5..=200.0).contains(&rate_hz))
        {
            return refuse("the rate must be 0.5 to 200 images a second");
        }
        if !(1..=1_000_000).contains(&self.exposure_us) || !(1.0..=10.66).contains(&self.gain) {
            return refuse(
                "the exposure must be 1 to 1000000 microseconds and the gain 1 to 10.66",
            );
        }
        Ok(())
    }
}

fn failed(what: &'static str) -> impl FnOnce(io::Error) -> CameraError {
    move |cause| CameraError::Io { what, cause }
}

impl<B: SensorBus> Camera<B> {
    /// Stops what may be running, sets everything up and starts.
    ///
    /// # Errors
    /// A sensor that does not answer or is another one, settings out of range, registers out of reach.
    pub fn start(
        memory: &mut impl PhysicalMemory,
        bus: B,
        layout: &OnChipLayout,
        settings: CameraSettings,
    ) -> Result<Self, CameraError> {
        settings.check()?;
        let mut sensor = Imx219::new(bus);
        match sensor.identify().map_err(CameraError::Silent)? {
            Identity::Imx219 => {}
            Identity::Other(model) => return Err(CameraError::OtherSensor(model)),
        }
        let registers = failed("the camera path's registers");
        halt(memory)?;
        sensor.reset().map_err(failed("resetting the sensor"))?;
        memory.pause(RESET_PAUSE);
        let exposure_lines = longest_exposure(SHORTEST_FRAME).min(1000);
        sensor
            .set_up()
            .and_then(|()| sensor.set_exposure(exposure_lines))
            .and_then(|()| sensor.set_gain(settings.gain))
            .map_err(failed("setting up the sensor"))?;
        vin::start_receiver(memory).map_err(failed("the CSI-2 receiver's registers"))?;
        sensor.start().map_err(failed("starting the sensor"))?;
        vin::start_capture(memory, layout.raw, settings.resolution).map_err(registers)?;
        Ok(Self {
            sensor,
            settings,
            buffers: layout.raw,
            clock: FrameClock::default(),
            state: CameraState::Measuring,
            started_ns: None,
            polled_ns: 0,
            frame_lines: SHORTEST_FRAME,
            exposure_lines,
        })
    }

    /// Looks whether a new image is there; to be called every millisecond. `now_ns` is a monotonic clock.
    ///
    /// # Errors
    /// A camera that gave no image at all for two seconds; registers or a sensor out of reach.
    pub fn poll(
        &mut self,
        memory: &impl PhysicalMemory,
        now_ns: u64,
    ) -> Result<Option<Frame>, CameraError> {
        let newest = vin::newest_buffer(memory).map_err(failed("reading VIN's status"))?;
        let started_ns = *self.started_ns.get_or_insert(now_ns);
        let before_ns = self.polled_ns.max(started_ns);
        self.polled_ns = now_ns;
        let Some(buffer) = newest else {
            let is_late = now_ns.saturating_sub(started_ns) > FIRST_IMAGE_NS;
            return if is_late {
                Err(CameraError::NoImage)
            } else {
                Ok(None)
            };
        };
        let Some(arrival) = self.clock.arrive(buffer, before_ns, now_ns) else {
            return Ok(None);
        };
        let (period_ns, first) = match (self.state, self.clock.period_ns()) {
            (CameraState::Measuring, Some(period_ns)) => {
                self.apply(period_ns)?;
                return Ok(None);
            }
            (CameraState::Settling, Some(period_ns)) if arrival.number >= SETTLING => {
                self.state = CameraState::Running(arrival.number);
                (period_ns, arrival.number)
            }
            (CameraState::Running(first), Some(period_ns)) => (period_ns, first),
            _ => return Ok(None),
        };
        let line_ns = period_ns as f64 / f64::from(self.frame_lines);
        let exposure_ns = line_ns * f64::from(self.exposure_lines);
        // The last row was read when the image arrived; the middle one half the rows before, after its exposure.
        let rows_ns = line_ns * f64::from(self.settings.resolution[1]);
        Ok(Some(Frame {
            address: self.buffers[buffer],
            number: arrival.number - first,
            exposed_ns: arrival
                .at_ns
                .saturating_sub(((rows_ns + exposure_ns) / 2.0) as u64),
            exposure_ns: exposure_ns as u32,
            tolerance_ns: arrival.tolerance_ns,
            buffer,
            arrived_ns: arrival.at_ns,
        }))
    }

    /// Whether VIN has left an image alone until now: asked after reading it.
    ///
    /// # Errors
    /// Registers out of reach.
    pub fn is_whole(
        &self,
        memory: &impl PhysicalMemory,
        frame: &Frame,
        now_ns: u64,
    ) -> Result<bool, CameraError> {
        let newest = vin::newest_buffer(memory).map_err(failed("reading VIN's status"))?;
        Ok(newest.is_some_and(|newest| {
            self.clock
                .is_whole(frame.buffer, frame.arrived_ns, newest, now_ns)
        }))
    }

    /// Sets frame length and exposure, now that the time of a line is known.
    fn apply(&mut self, period_ns: u64) -> Result<(), CameraError> {
        let line_ns = (period_ns as f64 / f64::from(self.frame_lines)).max(1.0);
        let lines =
            |time_ns: f64| (time_ns / line_ns).round().clamp(1.0, f64::from(u16::MAX)) as u16;
        let wanted = self
            .settings
            .rate_hz
            .map_or(SHORTEST_FRAME, |rate_hz| lines(1e9 / rate_hz));
        self.frame_lines = wanted.max(SHORTEST_FRAME);
        let exposure = lines(f64::from(self.settings.exposure_us) * 1e3);
        self.exposure_lines = exposure.min(longest_exposure(self.frame_lines));
        self.sensor
            .set_frame_length(self.frame_lines)
            .and_then(|()| self.sensor.set_exposure(self.exposure_lines))
            .map_err(failed("setting the sensor's exposure"))?;
        self.clock = FrameClock::with_period((line_ns * f64::from(self.frame_lines)) as u64);
        self.state = CameraState::Settling;
        Ok(())
    }

    /// Images a second, once measured.
    pub fn rate_hz(&self) -> Option<f64> {
        self.clock
            .period_ns()
            .map(|period_ns| 1e9 / period_ns as f64)
    }

    /// Stops sensor, receiver and VIN.
    ///
    /// # Errors
    /// A sensor or registers out of reach.
    pub fn stop(&mut self, memory: &mut impl PhysicalMemory) -> Result<(), CameraError> {
        self.sensor.stop().map_err(failed("stopping the sensor"))?;
        halt(memory)
    }
}

/// Lets the modules' clocks run and stops them, until VIN writes nothing any more.
fn halt(memory: &mut impl PhysicalMemory) -> Result<(), CameraError> {
    vin::enable_clocks(memory).map_err(failed("the modules' clocks"))?;
    vin::stop(memory).map_err(failed("stopping VIN"))?;
    for _ in 0..STOP_POLLS {
        if !vin::is_capturing(memory).map_err(failed("reading VIN's status"))? {
            return Ok(());
        }
        memory.pause(Duration::from_millis(1));
    }
    Err(CameraError::Busy)
}
