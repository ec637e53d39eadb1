//! The file that poses go to: JSON lines, TUM text or C3D, by its name.

use anyhow::{Context, bail};
use sextant_pose_formats::c3d;
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::{pose_json, pose_tum};
use sextant_site_files::write_atomically;
use sextant_site_report::ObjectEstimate;
use std::path::{Path, PathBuf};

/// A file of poses.
pub struct PosesFile {
    path: PathBuf,
    kind: Kind,
}

enum Kind {
    Lines(fn(&ObjectEstimate) -> String),
    C3d,
}

impl PosesFile {
    /// The file of that name.
    ///
    /// # Errors
    /// [`Exit::Usage`] for an unknown file extension.
    pub fn named(path: &Path) -> anyhow::Result<Self> {
        let kind = match path.extension().and_then(|e| e.to_str()) {
            Some("jsonl" | "json") => Kind::Lines(pose_json),
            Some("tum") => Kind::Lines(pose_tum),
            Some("c3d") => Kind::C3d,
            _ => {
                let cause = anyhow::anyhow!(
                    "--out {}: the name says no format; let it end with .jsonl, .tum or .c3d",
                    path.display()
                );
                bail!(Failure::new(Exit::Usage, cause))
            }
        };
        Ok(Self {
            path: path.to_owned(),
            kind,
        })
    }

    /// Writes the poses, whole or not at all.
    ///
    /// # Errors
    /// An I/O error; [`Exit::Usage`] for TUM text of several objects, which it cannot distinguish, and for what C3D has no room for.
    pub fn write(&self, poses: &[ObjectEstimate]) -> anyhow::Result<()> {
        let is_tum = self.path.extension().is_some_and(|e| e == "tum");
        if is_tum && poses.iter().any(|pose| pose.object != poses[0].object) {
            let cause = anyhow::anyhow!(
                "--out {}: TUM text has one object only; give one --object, or write .jsonl",
                self.path.display()
            );
            bail!(Failure::new(Exit::Usage, cause));
        }
        let bytes = match self.kind {
            Kind::Lines(line) => poses
                .iter()
                .flat_map(|pose| format!("{}\n", line(pose)).into_bytes())
                .collect(),
            Kind::C3d => c3d(poses)
                .with_context(|| format!("--out {}", self.path.display()))
                .exit_with(Exit::Usage)?,
        };
        write_atomically(&self.path, &bytes).context("the poses are lost")
    }
}
