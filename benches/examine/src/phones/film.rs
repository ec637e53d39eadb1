//! Films: the images of each camera as JPEGs one after the other, which is what Chromium plays in the place of a
//! webcam.

use super::scene::{RATE_HZ, Wanted, scenario};
use anyhow::Context;
use jpeg_encoder::{ColorType, Encoder};
use sextant_simulator::{Renderer, Scenario};
use sextant_site_files::write_toml;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

const QUALITY: u8 = 85;

/// Writes the films and the scenario.
///
/// # Errors
/// Files that cannot be written.
pub fn write(folder: &Path, wanted: &Wanted) -> anyhow::Result<()> {
    let scenario = scenario(wanted);
    scenario.validate()?;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    write_toml(&folder.join("scenario.toml"), &scenario)?;
    (0..scenario.cameras.len()).try_for_each(|camera| film(folder, &scenario, camera, wanted))
}

fn film(folder: &Path, scenario: &Scenario, camera: usize, wanted: &Wanted) -> anyhow::Result<()> {
    let mut renderer = Renderer::new(scenario, camera)?;
    let schedule = renderer.camera().schedule();
    let [width, height] = wanted.resolution;
    let mut grey = vec![0; width as usize * height as usize];
    let path = folder.join(format!("{}.mjpeg", scenario.cameras[camera].id));
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    let mut file = BufWriter::new(file);
    for n in 0..u64::from(wanted.seconds) * RATE_HZ as u64 {
        renderer.render(n * schedule.period_ns(), &mut grey)?;
        let encoder = Encoder::new(&mut file, QUALITY);
        encoder.encode(&grey, width as u16, height as u16, ColorType::Luma)?;
    }
    file.flush().with_context(|| path.display().to_string())?;
    let exposure_ms = renderer.camera().exposure_ns as f64 * 1e-6;
    println!("{}: exposures of {exposure_ms:.1} ms", path.display());
    Ok(())
}
