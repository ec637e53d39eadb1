//! `sextant camera`: the camera node; with `--probe` which cameras this machine has, and a first `camera.toml` for one.

use crate::output::{Format, print_line};
use anyhow::{Context, bail};
use clap::Args;
use node_camera::probe::{self, Camera, Mute};
use node_camera::{CameraArguments, Part};
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a person may choose of `camera`.
#[derive(Args, Debug)]
#[command(
    after_help = "For example: sextant camera --probe --write camera.toml && sextant camera --config camera.toml
With --probe --json, a line a camera: {\"device\",\"card\",\"driver\",\"bus\",\"formats\":[{\"format\",\"is_readable\",
\"sizes\":[{\"resolution\",\"rates_hz\"}]}],\"controls\":[{\"name\",\"range\",\"step\",\"default\",\"value\",
\"menu\"}]}; of a device that cannot be asked {\"device\",\"cause\"}."
)]
pub struct CameraCommand {
    /// The node's configuration (`sextant config camera` prints one).
    #[arg(long, value_name = "FILE", required_unless_present = "probe")]
    config: Option<PathBuf>,
    /// Run one part only; without it both run, as two processes.
    #[arg(long, value_enum)]
    part: Option<Part>,
    /// List this machine's cameras with their formats, sizes, rates and controls.
    #[arg(long, conflicts_with_all = ["config", "part"])]
    probe: bool,
    /// Only this device.
    #[arg(long, value_name = "FILE", requires = "probe")]
    device: Option<PathBuf>,
    /// Write a configuration for the first camera, in its best format.
    #[arg(long, value_name = "FILE", requires = "probe")]
    write: Option<PathBuf>,
}

/// Runs a camera node until a signal or the end of its recording, or looks for cameras.
///
/// # Errors
/// As [`node_camera::run`]; a file that is there already; no camera to write one for.
pub fn run(command: &CameraCommand, format: Format) -> anyhow::Result<()> {
    match &command.config {
        Some(config) => {
            let arguments = CameraArguments {
                config: config.clone(),
                part: command.part,
            };
            node_camera::run(&arguments, &["camera"], &Shutdown::install()?)
        }
        None => look(command, format),
    }
}

fn look(command: &CameraCommand, format: Format) -> anyhow::Result<()> {
    let found = match &command.device {
        Some(device) => probe::camera(device).transpose().into_iter().collect(),
        None => probe::cameras(),
    };
    for camera in &found {
        print_line(line(camera, format).trim_end())?;
    }
    if found.is_empty() && format == Format::Text {
        print_line(
            "no camera: no device /dev/video* that captures. A Raspberry Pi's own camera and \
             network cameras are taken through a program (docs/cameras.md)",
        )?;
    }
    match &command.write {
        Some(file) => write(file, found.iter().flatten()),
        None => Ok(()),
    }
}

fn line(camera: &Result<Camera, Mute>, format: Format) -> String {
    match (camera, format) {
        // Texts and numbers that are finite: there is nothing that JSON could refuse.
        (Ok(camera), Format::Json) => serde_json::to_string(camera).unwrap_or_default(),
        (Err(mute), Format::Json) => serde_json::to_string(mute).unwrap_or_default(),
        (Ok(camera), Format::Text) => camera.to_string(),
        (Err(mute), Format::Text) => mute.cause.clone(),
    }
}

fn write<'a>(file: &Path, mut cameras: impl Iterator<Item = &'a Camera>) -> anyhow::Result<()> {
    let Some(text) = cameras.find_map(Camera::first_config) else {
        let cause = anyhow::anyhow!("no camera with a format that is read here");
        bail!(Failure::new(Exit::Unavailable, cause));
    };
    let created = std::fs::File::create_new(file);
    created
        .and_then(|mut created| created.write_all(text.as_bytes()))
        .with_context(|| format!("{} cannot be written", file.display()))
        .exit_with(Exit::Input)?;
    eprintln!(
        "{}: written; name site, camera and router in it",
        file.display()
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_there_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("camera.toml");
        let size = probe::CameraSize {
            resolution: [640, 480],
            rates_hz: vec![30.0],
        };
        let grey = probe::CameraFormat {
            format: "GREY".to_owned(),
            is_readable: true,
            sizes: vec![size],
        };
        let camera = Camera {
            device: "/dev/video0".into(),
            card: "One".to_owned(),
            driver: "one".to_owned(),
            bus: "usb".to_owned(),
            formats: vec![grey],
            controls: Vec::new(),
        };
        assert!(write(&file, std::iter::empty()).is_err());
        write(&file, std::iter::once(&camera)).unwrap();
        assert!(node_camera::CameraNodeConfig::read(&file).is_ok());
        assert!(write(&file, std::iter::once(&camera)).is_err());
        assert!(line(&Ok(camera), Format::Json).starts_with("{\"device\":\"/dev/video0\""));
    }
}
