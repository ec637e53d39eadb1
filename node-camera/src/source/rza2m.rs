//! The camera of an RZ/A2M: raw images polled in on-chip memory, made grey by the DRP or the CPU. What touches hardware
//! is in `sextant_rza2m`; here are the file's settings, the loop and the clock.

use std::path::Path;
use std::time::Duration;

use sextant_process::clock::{monotonic_ns, wall_from_monotonic_ns};
use sextant_process::{Exit, Shutdown};
use sextant_proto::{CameraControls, Control};
use sextant_rza2m::drp::{CircuitData, DrpError, PipelineError};
use sextant_rza2m::{
    Accelerated, Camera, CameraError, CameraSettings, Cpu, DevMem, DrpFile, Frame, I2cBus,
    OnChipLayout, PhysicalMemory, Preprocess, SensorBus,
};

use super::host_clock::{HostClock, Stamped, Taken};
use super::{Capture, ImageSource, Next, Reconfigured, SourceError};
use crate::config::{DrpCircuitConfig, Rza2mConfig, SourceConfig};

/// Between two looks at VIN's status: no interrupt reaches user space.
const POLL: Duration = Duration::from_millis(1);
/// How long one call waits at most.
const LONGEST_WAIT_NS: u64 = 200_000_000;
/// Data of the library's circuits has up to 380 kB.
const MOST_DATA_BYTES: u64 = 1 << 20;

/// The bus of the camera connector and the DRP's driver, by the vendor's device tree.
const I2C: &str = "/dev/i2c-2";
const DRP: &str = "/dev/drp";

/// The camera, running.
pub(crate) struct Rza2mCamera<M: PhysicalMemory, B: SensorBus> {
    config: Rza2mConfig,
    memory: M,
    camera: Camera<B>,
    preprocess: Box<dyn Preprocess<M>>,
    /// Images that the CPU made because the DRP was refused.
    refused: Option<u64>,
    resolution: [u16; 2],
    clock: HostClock,
}

/// Opens the board's devices and starts the camera as the file says.
pub(crate) fn open(config: &Rza2mConfig) -> Result<Box<dyn ImageSource>, SourceError> {
    let mut memory = DevMem::open().map_err(|cause| unavailable("/dev/mem", &cause))?;
    let bus = I2cBus::open(Path::new(I2C)).map_err(|cause| unavailable(I2C, &cause))?;
    let circuits = read_circuits(&config.drp)?;
    let sizes: Vec<usize> = circuits.iter().map(|data| data.bytes.len()).collect();
    let [width, height] = config.resolution.map(usize::from);
    let layout = OnChipLayout::plan(width * height, &sizes)
        .map_err(|cause| SourceError::new(Exit::Input, cause.to_string()))?;
    // The camera stops before anything is put where it may have written.
    let camera =
        Camera::start(&mut memory, bus, &layout, config.settings()).map_err(camera_error)?;
    let accelerated = match circuits.is_empty() {
        true => None,
        false => Some(accelerate(&mut memory, circuits, [width, height], layout)),
    };
    let (preprocess, refused): (Box<dyn Preprocess<DevMem>>, _) = match accelerated {
        Some(Ok(accelerated)) => (Box::new(accelerated), None),
        Some(Err(cause)) => {
            tracing::warn!(%cause, "the DRP is not used; the CPU makes images grey");
            (Box::new(Cpu::new([width, height])), Some(0))
        }
        None => (Box::new(Cpu::new([width, height])), None),
    };
    Ok(Box::new(Rza2mCamera {
        config: config.clone(),
        memory,
        camera,
        preprocess,
        refused,
        resolution: config.resolution,
        clock: HostClock::default(),
    }))
}

/// The DRP, once its circuits give what their models give.
fn accelerate(
    memory: &mut DevMem,
    circuits: Vec<CircuitData>,
    size: [usize; 2],
    layout: OnChipLayout,
) -> Result<Accelerated<DrpFile>, PipelineError> {
    let request = "opening /dev/drp";
    let device =
        DrpFile::open(Path::new(DRP)).map_err(|cause| DrpError::Call { request, cause })?;
    let (accelerated, tests) = Accelerated::start(device, memory, circuits, size, layout)?;
    tracing::info!(version = accelerated.version(), "DRP");
    for test in tests {
        tracing::info!("{test}");
    }
    Ok(accelerated)
}

/// The circuits' data from the files that the user named.
fn read_circuits(circuits: &[DrpCircuitConfig]) -> Result<Vec<CircuitData>, SourceError> {
    let read = |config: &DrpCircuitConfig| {
        let wrong = |cause: String| {
            let path = config.data.display();
            SourceError::new(Exit::Input, format!("{path}: circuit data: {cause}"))
        };
        let metadata = std::fs::metadata(&config.data).map_err(|cause| wrong(cause.to_string()))?;
        if !(1..=MOST_DATA_BYTES).contains(&metadata.len()) {
            return Err(wrong(format!("{} bytes are none", metadata.len())));
        }
        let bytes = std::fs::read(&config.data).map_err(|cause| wrong(cause.to_string()))?;
        let circuit = config.circuit.into();
        Ok(CircuitData { circuit, bytes })
    };
    circuits.iter().map(read).collect()
}

impl<M: PhysicalMemory, B: SensorBus> Rza2mCamera<M, B> {
    /// The pixels of a raw image, grey; none if the camera has begun to overwrite it meanwhile.
    fn take(&mut self, frame: &Frame, pixels: &mut [u8]) -> Result<Option<Capture>, SourceError> {
        let made = self.preprocess.run(&mut self.memory, frame.address, pixels);
        made.map_err(|cause| unavailable("on-chip memory", &cause))?;
        if let Some(cause) = self.preprocess.take_failure() {
            tracing::warn!(%cause, "the DRP failed; the CPU takes over for some images");
        }
        let is_whole = self.camera.is_whole(&self.memory, frame, monotonic_ns());
        if !is_whole.map_err(camera_error)? {
            return Ok(None);
        }
        self.refused = self.refused.map(|images| images + 1);
        let capture = self.clock.capture(Taken {
            sequence: frame.number,
            capture_ns: wall_from_monotonic_ns(frame.exposed_ns),
            exposure_ns: frame.exposure_ns,
            stamped: Stamped::ByDriver,
        });
        Ok(Some(Capture {
            clock_error_ns: capture.clock_error_ns.saturating_add(frame.tolerance_ns),
            ..capture
        }))
    }
}

impl<M: PhysicalMemory, B: SensorBus> ImageSource for Rza2mCamera<M, B> {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let started_ns = monotonic_ns();
        loop {
            let now_ns = monotonic_ns();
            let frame = self
                .camera
                .poll(&self.memory, now_ns)
                .map_err(camera_error)?;
            if let Some(frame) = frame
                && let Some(capture) = self.take(&frame, pixels)?
            {
                return Ok(Next::Image(capture));
            }
            if now_ns.saturating_sub(started_ns) >= LONGEST_WAIT_NS || shutdown.wait(POLL) {
                return Ok(Next::Nothing);
            }
        }
    }

    fn controls(&self) -> Option<CameraControls> {
        let control = |value, range| Control {
            wanted: None,
            value,
            range: Some(range),
        };
        let CameraSettings {
            rate_hz,
            exposure_us,
            gain,
            ..
        } = self.config.settings();
        Some(CameraControls {
            exposure_us: control(Some(f64::from(exposure_us)), [1.0, 1e6]),
            gain: control(Some(gain), [1.0, 10.66]),
            rate_hz: control(rate_hz, [0.5, 200.0]),
            ..CameraControls::default()
        })
    }

    fn reconfigure(&mut self, config: &SourceConfig) -> Result<Reconfigured, SourceError> {
        let SourceConfig::Rza2m(config) = config else {
            return Ok(Reconfigured::NeedsRestart);
        };
        config.settings().check().map_err(camera_error)?;
        let is_alike = config.resolution == self.config.resolution && config.drp == self.config.drp;
        Ok(match is_alike {
            true => Reconfigured::NeedsReopening,
            false => Reconfigured::NeedsRestart,
        })
    }

    fn fallbacks(&self) -> u64 {
        self.refused.unwrap_or_else(|| self.preprocess.fallbacks())
    }
}

impl<M: PhysicalMemory, B: SensorBus> Drop for Rza2mCamera<M, B> {
    fn drop(&mut self) {
        if let Err(cause) = self.camera.stop(&mut self.memory) {
            tracing::debug!(%cause, "the camera does not stop");
        }
    }
}

fn camera_error(cause: CameraError) -> SourceError {
    let exit = match cause {
        CameraError::Settings(_) => Exit::Input,
        _ => Exit::Unavailable,
    };
    SourceError::new(exit, format!("{cause}"))
}

fn unavailable(what: &str, cause: &std::io::Error) -> SourceError {
    let remedy = match cause.raw_os_error() {
        Some(libc::ENOENT) => "; does the kernel have it (docs/rza2m.md)?",
        Some(libc::EACCES | libc::EPERM) => "; run as root",
        _ => "",
    };
    SourceError::new(Exit::Unavailable, format!("{what}: {cause}{remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::io;

    const RESOLUTION: [u16; 2] = [64, 48];
    const VIN_STATUS: u32 = 0xe803_f004;

    /// A board whose sensor fills the next buffer at every eighth look at VIN's status, always with the same grey.
    #[derive(Default)]
    struct Board {
        looks: Cell<u32>,
    }

    impl PhysicalMemory for Board {
        fn read_byte(&self, _: u32) -> io::Result<u8> {
            Ok(0)
        }

        fn write_byte(&mut self, _: u32, _: u8) -> io::Result<()> {
            Ok(())
        }

        fn read_word(&self, address: u32) -> io::Result<u32> {
            if address != VIN_STATUS {
                return Ok(0);
            }
            self.looks.set(self.looks.get() + 1);
            Ok((self.looks.get() / 8 % 3) << 3)
        }

        fn write_word(&mut self, _: u32, _: u32) -> io::Result<()> {
            Ok(())
        }

        fn copy_out(&self, _: u32, bytes: &mut [u8]) -> io::Result<()> {
            bytes.fill(0x80);
            Ok(())
        }

        fn copy_in(&mut self, _: u32, _: &[u8]) -> io::Result<()> {
            Ok(())
        }

        fn pause(&mut self, _: Duration) {}
    }

    struct Sensor;

    impl SensorBus for Sensor {
        fn read(&mut self, register: u16) -> io::Result<u8> {
            Ok(if register == 0 { 0x02 } else { 0x19 })
        }

        fn write(&mut self, _: u16, _: u8) -> io::Result<()> {
            Ok(())
        }
    }

    fn config() -> Rza2mConfig {
        Rza2mConfig {
            resolution: RESOLUTION,
            rate_hz: None,
            exposure_us: 1000,
            gain: 1.0,
            drp: Vec::new(),
        }
    }

    fn camera(refused: Option<u64>) -> Rza2mCamera<Board, Sensor> {
        let mut memory = Board::default();
        let size = RESOLUTION.map(usize::from);
        let layout = OnChipLayout::plan(size[0] * size[1], &[]).unwrap();
        let camera = Camera::start(&mut memory, Sensor, &layout, config().settings()).unwrap();
        Rza2mCamera {
            config: config(),
            memory,
            camera,
            preprocess: Box::new(Cpu::new(size)),
            refused,
            resolution: RESOLUTION,
            clock: HostClock::default(),
        }
    }

    #[test]
    fn images_come_grey_and_in_order() {
        let shutdown = Shutdown::manual().unwrap();
        let mut camera = camera(None);
        let mut last = None;
        while last < Some(3) {
            let mut pixels = vec![0; 64 * 48];
            if let Next::Image(capture) = camera.next(&mut pixels, &shutdown).unwrap() {
                assert!(pixels.iter().all(|pixel| *pixel == 0x80));
                assert!(Some(capture.sequence) > last);
                assert!(capture.capture_ns < sextant_process::now_ns());
                last = Some(capture.sequence);
            }
        }
        assert_eq!(camera.fallbacks(), 0);
    }

    #[test]
    fn without_the_drp_that_was_asked_for_every_image_is_a_fallback() {
        let shutdown = Shutdown::manual().unwrap();
        let mut camera = camera(Some(0));
        let mut images = 0;
        while images < 3 {
            let next = camera.next(&mut vec![0; 64 * 48], &shutdown).unwrap();
            images += u64::from(matches!(next, Next::Image(_)));
        }
        assert_eq!(camera.fallbacks(), 3);
    }

    #[test]
    fn exposure_and_gain_change_by_opening_anew_and_are_checked_before() {
        let mut camera = camera(None);
        let mut changed = |gain, resolution| {
            let config = Rza2mConfig {
                gain,
                resolution,
                ..config()
            };
            camera.reconfigure(&SourceConfig::Rza2m(config))
        };
        let smaller = [32, 16];
        assert_eq!(
            changed(2.0, RESOLUTION).unwrap(),
            Reconfigured::NeedsReopening
        );
        assert_eq!(changed(2.0, smaller).unwrap(), Reconfigured::NeedsRestart);
        assert!(changed(20.0, RESOLUTION).is_err());
        assert_eq!(camera.controls().unwrap().gain.value, Some(1.0));
    }

    #[test]
    fn another_machine_is_left_alone() {
        let refusal = open(&config()).err().unwrap().to_string();
        assert!(refusal.contains("no RZ/A2M"), "{refusal}");
    }

    #[test]
    fn circuit_data_that_is_not_there_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for data in [file.path(), Path::new("/no/such.dat")] {
            let circuit = DrpCircuitConfig {
                circuit: crate::config::DrpCircuit::Bayer2grayscale,
                data: data.to_owned(),
            };
            let refusal = read_circuits(&[circuit]).unwrap_err().to_string();
            assert!(refusal.contains(&*data.to_string_lossy()), "{refusal}");
        }
    }
}
