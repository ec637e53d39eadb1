//! Whether somebody has changed the `[source]` of `camera.toml`: exposure, gain and rate are tuned while the camera runs.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::config::{CameraNodeConfig, SourceConfig};

/// How often the file is looked at.
const PERIOD: Duration = Duration::from_millis(500);

/// The file as it was last seen.
#[derive(Debug)]
pub(super) struct FileChanges {
    file: PathBuf,
    source: SourceConfig,
    seen: Option<Version>,
    looked: Instant,
}

/// Tells one content of a file from the next: inode, time of change in s and ns, length.
type Version = [i64; 4];

impl FileChanges {
    /// The file from which `source` was read just now.
    pub(super) fn new(file: &Path, source: &SourceConfig) -> Self {
        Self {
            file: file.to_owned(),
            source: source.clone(),
            seen: version(file),
            looked: Instant::now(),
        }
    }

    /// The `[source]`, if it is another than before. A file that is wrong or missing changes nothing.
    pub(super) fn take(&mut self) -> Option<SourceConfig> {
        if self.looked.elapsed() < PERIOD {
            return None;
        }
        self.looked = Instant::now();
        self.look()
    }

    fn look(&mut self) -> Option<SourceConfig> {
        let version = version(&self.file)?;
        if self.seen == Some(version) {
            return None;
        }
        self.seen = Some(version);
        match CameraNodeConfig::read(&self.file) {
            Ok(config) if config.source == self.source => None,
            Ok(config) => {
                self.source = config.source.clone();
                Some(config.source)
            }
            Err(cause) => {
                tracing::warn!(%cause, "the file has changed, but is wrong; all stays as it was");
                None
            }
        }
    }
}

fn version(file: &Path) -> Option<Version> {
    let about = std::fs::metadata(file).ok()?;
    let (inode, length) = (about.ino() as i64, about.len() as i64);
    Some([inode, about.mtime(), about.mtime_nsec(), length])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_another_source_that_is_right_is_a_change() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("camera.toml");
        let write = |name: &str, rest: &str| {
            // Replaced in one step, as editors do.
            let text = format!(
                "site = \"s\"\ncamera = \"c\"\n{rest}[source]\nkind = \"images\"\nfolder = \"{name}\"\n"
            );
            let other = folder.path().join("other");
            std::fs::write(&other, text).unwrap();
            std::fs::rename(other, &file).unwrap();
        };
        write("/a", "");
        let source = CameraNodeConfig::read(&file).unwrap().source;
        let mut changes = FileChanges::new(&file, &source);
        assert_eq!(changes.look(), None);
        write("/a", "# a remark\n");
        assert_eq!(changes.look(), None);
        write("/b", "");
        assert_eq!(changes.look(), Some(SourceConfig::images("/b")));
        write("/c", "nonsense = 1\n");
        assert_eq!(changes.look(), None);
        std::fs::remove_file(&file).unwrap();
        assert_eq!(changes.look(), None);
        write("/c", "");
        assert_eq!(changes.look(), Some(SourceConfig::images("/c")));
    }
}
