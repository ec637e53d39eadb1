//! The file that poses go to: JSON lines or TUM text, by its name.

use anyhow::{Context, bail};
use sextant_estimator::ObjectEstimate;
use sextant_process::{Exit, Failure};
use sextant_recordings::{pose_json, pose_tum};
use sextant_site_files::write_atomically;
use std::path::{Path, PathBuf};

/// A file of poses.
pub struct PosesFile {
    path: PathBuf,
    line: fn(&ObjectEstimate) -> String,
}

impl PosesFile {
    /// The file of that name, if any.
    ///
    /// # Errors
    /// [`Exit::Usage`] for an unknown file extension, and for TUM text of several objects, which it cannot distinguish.
    pub fn named(path: Option<&Path>, n_objects: usize) -> anyhow::Result<Option<Self>> {
        let Some(path) = path else { return Ok(None) };
        let wrong = |message: &str| {
            let cause = anyhow::anyhow!("--out {}: {message}", path.display());
            Failure::new(Exit::Usage, cause)
        };
        let line = match path.extension().and_then(|e| e.to_str()) {
            Some("jsonl" | "json") => pose_json,
            Some("tum") if n_objects == 1 => pose_tum,
            Some("tum") => bail!(wrong(
                "TUM text has one object only; give one --object, or write .jsonl"
            )),
            _ => bail!(wrong(
                "the name says no format; let it end with .jsonl or .tum"
            )),
        };
        Ok(Some(Self {
            path: path.to_owned(),
            line,
        }))
    }

    /// Writes the poses, whole or not at all.
    ///
    /// # Errors
    /// An I/O error.
    pub fn write(&self, poses: &[ObjectEstimate]) -> anyhow::Result<()> {
        let mut text = String::new();
        for pose in poses {
            text.push_str(&(self.line)(pose));
            text.push('\n');
        }
        write_atomically(&self.path, text.as_bytes()).context("the poses are lost")
    }
}
