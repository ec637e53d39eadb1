//! The images of a scenario's cameras, in the EuRoC layout.

use crate::progress::Progress;
use anyhow::{Context, bail};
use sextant_process::Shutdown;
use sextant_recordings::{GreyImage, write_grey_png};
use sextant_simulator::{Network, NetworkFaults, Renderer, Scenario};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Writes every camera's pictures up to `until_ns`; the true times at which there are any.
///
/// # Errors
/// A folder that can't be written, and a wish to stop.
pub fn write(
    folder: &Path,
    scenario: &Scenario,
    until_ns: u64,
    shutdown: &Shutdown,
) -> anyhow::Result<BTreeSet<u64>> {
    let mut network = Network::new(scenario);
    let mut times = BTreeSet::new();
    for camera in 0..scenario.cameras.len() {
        let folder = folder.join(&scenario.cameras[camera].id);
        fs::create_dir_all(folder.join("data")).with_context(|| folder.display().to_string())?;
        let mut taken = CameraRecording::new(scenario, camera, &mut network)?;
        let mut due_ns = taken.next_ns(scenario.start_ns);
        let mut progress = Progress::new(taken.count(due_ns, until_ns), "images of a camera");
        while due_ns < until_ns {
            if shutdown.is_requested() {
                bail!("stopped; the recording ends where it was");
            }
            taken.write(&folder, due_ns)?;
            times.insert(due_ns);
            progress.step();
            due_ns = taken.next_ns(due_ns + 1);
        }
        fs::write(folder.join("data.csv"), taken.table)
            .with_context(|| folder.display().to_string())?;
    }
    Ok(times)
}

/// One camera's recording.
struct CameraRecording<'a> {
    scenario: &'a Scenario,
    camera: usize,
    renderer: Renderer,
    network: &'a mut Network<()>,
    table: String,
}

impl<'a> CameraRecording<'a> {
    fn new(
        scenario: &'a Scenario,
        camera: usize,
        network: &'a mut Network<()>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            renderer: Renderer::new(scenario, camera)?,
            scenario,
            camera,
            network,
            table: "#timestamp [ns],filename\n".to_owned(),
        })
    }

    fn next_ns(&self, from_ns: u64) -> u64 {
        self.renderer.camera().schedule().next_at_or_after(from_ns)
    }

    /// How many images there are.
    fn count(&self, from_ns: u64, until_ns: u64) -> u64 {
        let next = |due_ns: &u64| Some(self.next_ns(due_ns + 1));
        let due = std::iter::successors(Some(from_ns), next);
        due.take_while(|due_ns| *due_ns < until_ns).count() as u64
    }

    fn write(&mut self, folder: &Path, true_ns: u64) -> anyhow::Result<()> {
        let clock = self.scenario.clock(self.camera);
        let stamp_ns = clock.map_or(true_ns, |clock| clock.camera_ns(true_ns));
        let Some(arrival) = self.arrival(true_ns, stamp_ns) else {
            return Ok(());
        };
        let [width, height] = self.renderer.camera().resolution.map(|n| n as usize);
        let mut image = GreyImage {
            width,
            height,
            pixels: vec![0; width * height],
        };
        self.renderer.render(true_ns, &mut image.pixels)?;
        let name = format!("{stamp_ns}.png");
        write_grey_png(&folder.join("data").join(&name), &image)?;
        let _ = writeln!(self.table, "{stamp_ns},{name}{arrival}");
        Ok(())
    }

    /// The column with the arrival, where the camera's network has faults; none for an image that gets lost.
    fn arrival(&mut self, true_ns: u64, stamp_ns: u64) -> Option<String> {
        let camera = self.renderer.camera();
        if camera.network == NetworkFaults::default() {
            return Some(String::new());
        }
        let whole_ns = camera.exposure_ns + (2e9 * camera.row_after_s(0.0).abs()) as u64;
        let complete_ns = true_ns + whole_ns / 2;
        self.network.send(self.camera, complete_ns, stamp_ns, ());
        let first = self.network.receive(u64::MAX);
        while self.network.receive(u64::MAX).is_some() {}
        first.map(|arrival| format!(",{}", arrival.arrival_ns))
    }
}
