//! The file that poses go to: JSON lines or TUM text, by its name.

use anyhow::{Context, bail};
use sextant_process::{Exit, Failure};
use sextant_recordings::{pose_json, pose_tum};
use sextant_site_files::write_atomically;
use sextant_site_report::ObjectEstimate;
use std::path::{Path, PathBuf};

/// A file of poses.
pub struct PosesFile {
    path: PathBuf,
    line: fn(&ObjectEstimate) -> String,
}

impl PosesFile {
    /// The file of that name.
    ///
    /// # Errors
    /// [`Exit::Usage`] for an unknown file extension.
    pub fn named(path: &Path) -> anyhow::Result<Self> {
        let line = match path.extension().and_then(|e| e.to_str()) {
            Some("jsonl" | "json") => pose_json,
            Some("tum") => pose_tum,
            _ => {
                let cause = anyhow::anyhow!(
                    "--out {}: the name says no format; let it end with .jsonl or .tum",
                    path.display()
                );
                bail!(Failure::new(Exit::Usage, cause))
            }
        };
        Ok(Self {
            path: path.to_owned(),
            line,
        })
    }

    /// Writes the poses, whole or not at all.
    ///
    /// # Errors
    /// An I/O error, and [`Exit::Usage`] for TUM text of several objects, which it cannot distinguish.
    pub fn write(&self, poses: &[ObjectEstimate]) -> anyhow::Result<()> {
        let is_tum = self.path.extension().is_some_and(|e| e == "tum");
        if is_tum && poses.iter().any(|pose| pose.object != poses[0].object) {
            let cause = anyhow::anyhow!(
                "--out {}: TUM text has one object only; give one --object, or write .jsonl",
                self.path.display()
            );
            bail!(Failure::new(Exit::Usage, cause));
        }
        let mut text = String::new();
        for pose in poses {
            text.push_str(&(self.line)(pose));
            text.push('\n');
        }
        write_atomically(&self.path, text.as_bytes()).context("the poses are lost")
    }
}
