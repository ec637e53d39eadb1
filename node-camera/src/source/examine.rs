//! Whether a source can work on this machine, asked before it runs: nothing is started.

use sextant_process::Exit;

use super::command::program::locate;
use super::{SourceError, v4l2, video};
use crate::config::SourceConfig;

/// Looks whether a source's device, program or file is there and fits.
///
/// # Errors
/// What is missing, and how to get it.
pub fn examine(source: &SourceConfig) -> Result<String, SourceError> {
    match source {
        SourceConfig::Simulator { .. } => Ok("simulated images".to_owned()),
        SourceConfig::Images { folder, .. } => {
            readable(folder).map(|()| format!("pictures of {}", folder.display()))
        }
        SourceConfig::Video(config) => {
            readable(&config.file)?;
            video::sync_option()?;
            Ok(format!("{} by ffmpeg", config.file.display()))
        }
        SourceConfig::Command(config) => {
            let words = config.run.words().unwrap_or_default();
            let program = words.first().map_or("", String::as_str);
            match locate(program) {
                Some(path) => Ok(format!("the program {}", path.display())),
                None => Err(SourceError::new(
                    Exit::Input,
                    format!("{program} is not there: install it, or write its whole path in run"),
                )),
            }
        }
        SourceConfig::V4l2(config) => v4l2::examine(config),
        SourceConfig::Rza2m(config) => {
            let mut circuits = config.drp.iter();
            circuits.try_for_each(|circuit| readable(&circuit.data))?;
            readable(std::path::Path::new("/dev/mem"))?;
            Ok("the camera of an RZ/A2M".to_owned())
        }
    }
}

fn readable(path: &std::path::Path) -> Result<(), SourceError> {
    std::fs::File::open(path)
        .map(drop)
        .map_err(|cause| SourceError::new(Exit::Input, format!("{}: {cause}", path.display())))
}
