//! A simulated camera: images of a scenario at the instants when its camera would take them, in this host's time.
//!
//! Each image is drawn ahead of its time and handed over when a real camera would have finished exposing it, so that the
//! time of drawing is not mistaken for latency. A host too slow for that hands images over late; when one would be later
//! than [`LATEST_NS`] it is passed over and counts as lost.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use sextant_estimator::CameraId;
use sextant_iceoryx_images::ClockSource;
use sextant_process::{Exit, Shutdown, now_ns};
use sextant_simulator::{Clock, Renderer, Scenario, SceneCamera, Schedule};
use sextant_site_files::{Complaint, read_toml_checked};

use super::{Capture, ImageSource, Next, SourceError, checked_resolution};

/// How late an image may be begun, in ns: three images of a usual camera.
const LATEST_NS: u64 = 100_000_000;
/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);

/// The camera.
pub(crate) struct SimulatedCamera {
    renderer: Renderer,
    schedule: Schedule,
    clock: Clock,
    resolution: [u16; 2],
    sequence: u64,
    /// True time of the next image.
    due_ns: u64,
    /// Whether that image is drawn already and waits for its time.
    is_drawn: bool,
}

impl SimulatedCamera {
    /// The camera of that name in a scenario's file.
    pub(crate) fn open(file: &Path, camera: &CameraId) -> anyhow::Result<Self> {
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
        let renderer =
            Renderer::new(&scenario, index).with_context(|| file.display().to_string())?;
        let clock = scenario
            .clock(index)
            .with_context(|| file.display().to_string())?;
        let SceneCamera {
            resolution: [width, height],
            ..
        } = *renderer.camera();
        let Some(resolution) = checked_resolution(width as usize, height as usize) else {
            bail!(
                "{}: camera {camera} has {width}x{height} pixels; use 16x16 to 4096x3072",
                file.display()
            );
        };
        let schedule = renderer.camera().schedule();
        let due_ns = schedule.next_at_or_after(now_ns().saturating_add(schedule.period_ns()));
        Ok(Self {
            renderer,
            schedule,
            clock,
            resolution,
            sequence: 0,
            due_ns,
            is_drawn: false,
        })
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
            self.catch_up(now_ns());
            self.renderer
                .render(self.due_ns, pixels)
                .map_err(|cause| SourceError::new(Exit::Fault, cause.to_string()))?;
            self.is_drawn = true;
        }
        let wait = Duration::from_nanos(self.complete_ns().saturating_sub(now_ns()));
        if shutdown.wait(wait.min(LONGEST_WAIT)) || wait > LONGEST_WAIT {
            return Ok(Next::Nothing);
        }
        let capture = self.capture();
        self.advance();
        self.is_drawn = false;
        Ok(Next::Image(capture))
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
            &folder.path().join("s.toml"),
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
