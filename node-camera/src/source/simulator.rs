//! A simulated camera: images of a scenario at the instants when its camera would take them, in this host's time.
//!
//! Each image is drawn ahead of its time and handed over when a real camera would have finished exposing it, so that
//! the time of drawing is not mistaken for latency. A host too slow for that hands images over late; when one would be
//! later than [`LATEST_NS`] it is passed over and counts as lost. Drawing waits a little where there is time, since it
//! would take the processors from those who work on the image before.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use sextant_iceoryx_images::ClockSource;
use sextant_process::{Exit, Shutdown, now_ns};
use sextant_proto::{CameraControls, Control};
use sextant_simulator::{Clock, Renderer, Scenario, SceneCamera, Schedule};
use sextant_site_files::{Complaint, read_toml_checked};
use sextant_site_model::CameraId;

use super::{Capture, ImageSource, Next, Reconfigured, SourceError, checked_resolution};
use crate::config::SourceConfig;

/// How late an image may be begun, in ns: three images of a usual camera.
const LATEST_NS: u64 = 100_000_000;
/// How long drawing waits at most after an image.
const LONGEST_REST_NS: u64 = 20_000_000;
/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);

/// Ranges of what a scenario's camera may have.
const GAINS: [f64; 2] = [0.05, 20.0];
const RATES_HZ: [f64; 2] = [0.1, 1000.0];

/// The camera.
pub(crate) struct SimulatedCamera {
    config: SourceConfig,
    camera: CameraId,
    /// As it is set; that of the renderer's camera includes the exposure.
    gain: f64,
    renderer: Renderer,
    schedule: Schedule,
    clock: Clock,
    resolution: [u16; 2],
    sequence: u64,
    /// True time of the next image.
    due_ns: u64,
    /// Whether that image is drawn already and waits for its time.
    is_drawn: bool,
    /// When the last image was handed over, and how long it took to draw it.
    handed_over_ns: u64,
    drawing_ns: u64,
}

/// Sets the exposure by hand; brightness follows, within what the sensor can do.
fn expose(camera: &mut SceneCamera, exposure_us: f64) {
    let exposure_ns = exposure_us * 1000.0;
    let ratio = match camera.exposure_ns {
        0 => 1.0,
        before => exposure_ns / before as f64,
    };
    let [least, greatest] = GAINS;
    camera.gain = (camera.gain * ratio).clamp(least, greatest);
    camera.exposure_ns = exposure_ns.round() as u64;
    camera.auto_exposure = None;
}

/// A scenario, and the index of a camera in it.
fn read_scenario(file: &Path, camera: &CameraId) -> anyhow::Result<(Scenario, usize)> {
    let scenario: Scenario = read_toml_checked(file, |scenario: &Scenario| {
        scenario
            .validate()
            .map_err(|cause| Complaint::new("", cause.to_string(), ""))
    })?;
    let Some(index) = scenario.camera_index(camera.as_str()) else {
        bail!(
            "{}: there is no camera {camera}; name one of the scenario's, or add it there",
            file.display()
        );
    };
    Ok((scenario, index))
}

fn check_exposure(camera: &SceneCamera) -> anyhow::Result<()> {
    let (rate_hz, longest_us) = (camera.rate_hz, longest_exposure_us(camera.rate_hz));
    let exposure_us = camera.exposure_ns as f64 / 1000.0;
    if exposure_us > longest_us {
        let [exposure_ms, longest_ms] = [exposure_us, longest_us].map(|us| us / 1000.0);
        bail!(
            "an exposure of {exposure_ms} ms does not fit into {rate_hz} images/s: choose at \
             most {longest_ms} ms, or a lower rate"
        );
    }
    Ok(())
}

fn longest_exposure_us(rate_hz: f64) -> f64 {
    (1e6 / rate_hz).floor()
}

impl SimulatedCamera {
    /// The camera of that name in a scenario's file.
    pub(crate) fn open(config: &SourceConfig, camera: &CameraId) -> anyhow::Result<Self> {
        let SourceConfig::Simulator {
            scenario: file,
            exposure_us,
            gain,
            rate_hz,
        } = config
        else {
            bail!("another source than before");
        };
        let file = file.as_path();
        let (mut scenario, index) = read_scenario(file, camera)?;
        let own = &mut scenario.cameras[index];
        let gain = gain.unwrap_or(own.gain);
        own.gain = gain;
        own.rate_hz = rate_hz.unwrap_or(own.rate_hz);
        if let Some(us) = *exposure_us {
            expose(own, us);
        }
        check_exposure(own)?;
        let renderer =
            Renderer::new(&scenario, index).with_context(|| file.display().to_string())?;
        let clock = scenario
            .clock(index)
            .with_context(|| file.display().to_string())?;
        let SceneCamera {
            resolution: [width, height],
            ..
        } = *renderer.camera();
        let resolution = checked_resolution(width as usize, height as usize)
            .with_context(|| format!("{}: camera {camera}", file.display()))?;
        let schedule = renderer.camera().schedule();
        let due_ns = schedule.next_at_or_after(now_ns().saturating_add(schedule.period_ns()));
        Ok(Self {
            config: config.clone(),
            camera: camera.clone(),
            gain,
            renderer,
            schedule,
            clock,
            resolution,
            sequence: 0,
            due_ns,
            is_drawn: false,
            handed_over_ns: 0,
            drawing_ns: u64::MAX,
        })
    }

    /// When to begin to draw the next image: after a quarter of the time between two, or so early that it may take
    /// twice as long as the last one.
    fn drawing_begins_ns(&self) -> u64 {
        let latest_ns = (self.complete_ns()).saturating_sub(self.drawing_ns.saturating_mul(2));
        latest_ns.min(self.handed_over_ns + LONGEST_REST_NS.min(self.schedule.period_ns() / 4))
    }

    /// Passes over the images that it is too late for.
    fn catch_up(&mut self, now_ns: u64) {
        while self.due_ns.saturating_add(LATEST_NS) < now_ns {
            self.advance();
        }
    }

    fn advance(&mut self) {
        self.sequence += 1;
        self.due_ns = self
            .schedule
            .next_at_or_after(self.due_ns.saturating_add(1));
    }

    /// When a real camera has the image: at the end of its last row's exposure.
    fn complete_ns(&self) -> u64 {
        let camera = self.renderer.camera();
        let readout_ns = 2.0 * camera.row_after_s(0.0).abs() * 1e9;
        self.due_ns
            .saturating_add((camera.exposure_ns + readout_ns as u64) / 2)
    }

    fn capture(&self) -> Capture {
        let camera = self.renderer.camera();
        let capture_ns = self.clock.camera_ns(self.due_ns);
        Capture {
            sequence: self.sequence,
            capture_ns,
            exposure_ns: u32::try_from(camera.exposure_ns).unwrap_or(u32::MAX),
            clock: ClockSource::Simulated,
            clock_error_ns: camera.clock.error_ns,
            clock_offset_ns: capture_ns.wrapping_sub(self.due_ns) as i64,
        }
    }
}

impl ImageSource for SimulatedCamera {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        if !self.is_drawn {
            let wait = Duration::from_nanos(self.drawing_begins_ns().saturating_sub(now_ns()));
            if shutdown.wait(wait.min(LONGEST_WAIT)) || wait > LONGEST_WAIT {
                return Ok(Next::Nothing);
            }
            let begun_ns = now_ns();
            self.catch_up(begun_ns);
            self.renderer
                .render(self.due_ns, pixels)
                .map_err(|cause| SourceError::new(Exit::Fault, cause.to_string()))?;
            self.drawing_ns = now_ns().saturating_sub(begun_ns);
            self.is_drawn = true;
        }
        let wait = Duration::from_nanos(self.complete_ns().saturating_sub(now_ns()));
        if shutdown.wait(wait.min(LONGEST_WAIT)) || wait > LONGEST_WAIT {
            return Ok(Next::Nothing);
        }
        let capture = self.capture();
        self.handed_over_ns = now_ns();
        self.advance();
        self.is_drawn = false;
        Ok(Next::Image(capture))
    }

    fn controls(&self) -> Option<CameraControls> {
        let camera = self.renderer.camera();
        let control = |value, range| Control {
            wanted: None,
            value,
            range: Some(range),
        };
        let exposure_us = camera.exposure_ns as f64 / 1000.0;
        let is_automatic = camera.auto_exposure.is_some();
        Some(CameraControls {
            exposure_us: control(
                (!is_automatic).then_some(exposure_us),
                [1.0, longest_exposure_us(camera.rate_hz)],
            ),
            gain: control(Some(self.gain), GAINS),
            rate_hz: control(Some(camera.rate_hz), RATES_HZ),
            ..CameraControls::default()
        })
    }

    /// Another exposure, gain or rate; images are counted on.
    fn reconfigure(&mut self, config: &SourceConfig) -> Result<Reconfigured, SourceError> {
        let (
            SourceConfig::Simulator {
                scenario: other, ..
            },
            SourceConfig::Simulator { scenario, .. },
        ) = (config, &self.config)
        else {
            return Ok(Reconfigured::NeedsRestart);
        };
        if other != scenario {
            return Ok(Reconfigured::NeedsRestart);
        }
        let changed = Self::open(config, &self.camera);
        let changed =
            changed.map_err(|cause| SourceError::new(Exit::Input, format!("{cause:#}")))?;
        *self = Self {
            sequence: self.sequence,
            ..changed
        };
        Ok(Reconfigured::Done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn scenario_file(edit: impl FnOnce(&mut Scenario)) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let mut scenario = Scenario::demo(1, 1, 1);
        edit(&mut scenario);
        sextant_site_files::write_toml(&folder.path().join("s.toml"), &scenario).unwrap();
        folder
    }

    fn open(folder: &tempfile::TempDir, camera: &str) -> anyhow::Result<SimulatedCamera> {
        SimulatedCamera::open(
            &SourceConfig::simulator(folder.path().join("s.toml")),
            &CameraId::new(camera).unwrap(),
        )
    }

    fn next_image(camera: &mut SimulatedCamera, pixels: &mut [u8]) -> Capture {
        let shutdown = Shutdown::manual().unwrap();
        loop {
            if let Next::Image(capture) = camera.next(pixels, &shutdown).unwrap() {
                return capture;
            }
        }
    }

    #[test]
    fn images_come_at_their_instants_by_the_cameras_clock() {
        let mut id = String::new();
        let folder = scenario_file(|scenario| {
            scenario.cameras[0].clock.offset_ns = 5_000_000_000;
            id = scenario.cameras[0].id.clone();
        });
        let mut camera = open(&folder, &id).unwrap();
        let [width, height] = camera.resolution();
        let mut pixels = vec![0; usize::from(width) * usize::from(height)];
        let first = next_image(&mut camera, &mut pixels);
        let second = next_image(&mut camera, &mut pixels);
        let period = camera.schedule.period_ns();
        assert_eq!(
            (second.capture_ns - first.capture_ns) / period,
            second.sequence - first.sequence
        );
        assert_eq!(second.clock_offset_ns, 5_000_000_000);
        assert!(
            second.capture_ns > now_ns(),
            "the clock is five seconds ahead"
        );
        assert!(pixels.iter().any(|pixel| *pixel != pixels[0]), "a picture");
    }

    #[test]
    fn exposure_and_rate_change_while_images_are_counted_on() {
        let mut id = String::new();
        let folder = scenario_file(|scenario| id = scenario.cameras[0].id.clone());
        let mut camera = open(&folder, &id).unwrap();
        let [width, height] = camera.resolution();
        let mut pixels = vec![0; usize::from(width) * usize::from(height)];
        let before = next_image(&mut camera, &mut pixels);
        let mean = |pixels: &[u8]| {
            pixels.iter().map(|pixel| f64::from(*pixel)).sum::<f64>() / pixels.len() as f64
        };
        let mean_before = mean(&pixels);
        let wanted = |exposure_us| SourceConfig::Simulator {
            scenario: folder.path().join("s.toml"),
            exposure_us: Some(exposure_us),
            gain: None,
            rate_hz: Some(20.0),
        };
        assert_eq!(
            camera.reconfigure(&wanted(1500.0)).unwrap(),
            Reconfigured::Done
        );
        let after = next_image(&mut camera, &mut pixels);
        let controls = camera.controls().unwrap();
        assert_eq!(controls.exposure_us.value, Some(1500.0));
        assert_eq!(controls.rate_hz.value, Some(20.0));
        let brighter = 1.5e6 / f64::from(before.exposure_ns);
        assert!(brighter != 1.0, "the test needs another exposure");
        assert_eq!(mean(&pixels) > mean_before, brighter > 1.0);
        assert_eq!(after.exposure_ns, 1_500_000);
        assert_eq!(camera.schedule.period_ns(), 50_000_000);
        assert!(after.sequence > before.sequence);
        let refused = camera.reconfigure(&wanted(900_000.0)).unwrap_err();
        assert!(refused.to_string().contains("at most 50 ms"), "{refused}");
        assert_eq!(next_image(&mut camera, &mut pixels).exposure_ns, 1_500_000);
        let elsewhere = SourceConfig::simulator("/elsewhere");
        assert_eq!(
            camera.reconfigure(&elsewhere).unwrap(),
            Reconfigured::NeedsRestart
        );
    }

    #[test]
    fn what_is_too_late_is_passed_over_and_leaves_a_gap() {
        let mut id = String::new();
        let folder = scenario_file(|scenario| id = scenario.cameras[0].id.clone());
        let mut camera = open(&folder, &id).unwrap();
        let late_by = 10 * camera.schedule.period_ns();
        camera.catch_up(camera.due_ns + late_by + LATEST_NS);
        assert_eq!(camera.sequence, 10);
    }

    #[test]
    fn a_missing_camera_and_a_missing_file_are_named() {
        let folder = scenario_file(|_| {});
        assert!(
            open(&folder, "nobody")
                .err()
                .unwrap()
                .to_string()
                .contains("no camera nobody")
        );
        fs::remove_file(folder.path().join("s.toml")).unwrap();
        assert!(
            open(&folder, "nobody")
                .err()
                .unwrap()
                .to_string()
                .contains("s.toml")
        );
    }
}
