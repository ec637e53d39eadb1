//! Whether the wanted `[source]` has changed: exposure, gain and rate are tuned while the camera runs, in `camera.toml`
//! or by the site.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use sextant_proto::CameraSettings;

use crate::config::{CameraNodeConfig, SourceConfig};
use crate::settings_files::SettingsFiles;

/// How often the files are looked at.
const PERIOD: Duration = Duration::from_millis(250);

/// Both files as they were last seen.
#[derive(Debug)]
pub(super) struct FileChanges {
    file: WatchedFile,
    settings: WatchedFile,
    files: SettingsFiles,
    source: SourceConfig,
    /// The source with the site's settings, as it was last wanted.
    wanted: SourceConfig,
    site: Option<CameraSettings>,
    looked: Instant,
}

/// What is wanted of a source.
#[derive(Debug, PartialEq)]
pub(super) struct Wanted {
    /// What the file says, with what the site sets; none where that is unchanged.
    pub source: Option<SourceConfig>,
    /// What the site sets.
    pub site: Option<CameraSettings>,
    /// Why a source of this kind has no such settings, and the remedy.
    pub refusal: Option<&'static str>,
}

impl FileChanges {
    /// Of a node whose file was read just now. What the site wants is the first change.
    pub(super) fn new(file: &Path, source: &SourceConfig, files: &SettingsFiles) -> Self {
        Self {
            file: WatchedFile {
                seen: version(file),
                path: file.to_owned(),
            },
            settings: WatchedFile {
                path: files.settings_file().to_owned(),
                seen: None,
            },
            files: files.clone(),
            source: source.clone(),
            wanted: source.clone(),
            site: None,
            looked: Instant::now(),
        }
    }

    /// Whether it is time to [`Self::look`].
    pub(super) fn is_due(&mut self) -> bool {
        let is_due = self.looked.elapsed() >= PERIOD;
        if is_due {
            self.looked = Instant::now();
        }
        is_due
    }

    /// What is wanted, if it is something else than before. A file that is wrong or missing changes nothing.
    pub(super) fn look(&mut self) -> Option<Wanted> {
        let is_edited = self.look_at_file();
        let is_set = self.look_at_settings();
        (is_edited || is_set).then(|| self.wanted())
    }

    fn wanted(&mut self) -> Wanted {
        let source = match &self.site {
            Some(site) => self.source.with(site),
            None => Ok(self.source.clone()),
        };
        let refusal = source.as_ref().err().copied();
        let source = source.unwrap_or_else(|_| self.source.clone());
        let is_other = source != self.wanted;
        self.wanted.clone_from(&source);
        Wanted {
            source: is_other.then_some(source),
            site: self.site.clone(),
            refusal,
        }
    }

    fn look_at_file(&mut self) -> bool {
        if !self.file.is_changed() || self.file.seen.is_none() {
            return false;
        }
        match CameraNodeConfig::read(&self.file.path) {
            Ok(config) if config.source == self.source => false,
            Ok(config) => {
                self.source = config.source;
                true
            }
            Err(cause) => {
                tracing::warn!(%cause, "the file has changed, but is wrong; all stays as it was");
                false
            }
        }
    }

    fn look_at_settings(&mut self) -> bool {
        if !self.settings.is_changed() {
            return false;
        }
        let site = self.files.settings();
        let is_other = site != self.site;
        self.site = site;
        is_other
    }
}

#[derive(Debug)]
struct WatchedFile {
    path: PathBuf,
    seen: Option<Version>,
}

impl WatchedFile {
    fn is_changed(&mut self) -> bool {
        let version = version(&self.path);
        let is_changed = version != self.seen;
        self.seen = version;
        is_changed
    }
}

/// Tells one content of a file from the next: inode, time of change in s and ns, length.
type Version = [i64; 4];

fn version(file: &Path) -> Option<Version> {
    let about = std::fs::metadata(file).ok()?;
    let (inode, length) = (about.ino() as i64, about.len() as i64);
    Some([inode, about.mtime(), about.mtime_nsec(), length])
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Node(tempfile::TempDir);

    impl Node {
        fn new() -> Self {
            Self(tempfile::tempdir().unwrap())
        }

        fn write(&self, source: &str, rest: &str) {
            // Replaced in one step, as editors do.
            let text = format!("site = \"s\"\ncamera = \"c\"\n{rest}[source]\n{source}\n");
            let other = self.0.path().join("other");
            std::fs::write(&other, text).unwrap();
            std::fs::rename(other, self.file()).unwrap();
        }

        fn file(&self) -> PathBuf {
            self.0.path().join("camera.toml")
        }

        fn settings_files(&self) -> SettingsFiles {
            SettingsFiles::in_folder(self.0.path())
        }

        fn changes(&self) -> FileChanges {
            let source = CameraNodeConfig::read(&self.file()).unwrap().source;
            FileChanges::new(&self.file(), &source, &self.settings_files())
        }
    }

    fn images(folder: &str) -> String {
        format!("kind = \"images\"\nfolder = \"{folder}\"")
    }

    fn from_file(source: SourceConfig) -> Option<Wanted> {
        Some(Wanted {
            source: Some(source),
            site: None,
            refusal: None,
        })
    }

    #[test]
    fn only_another_source_that_is_right_is_a_change() {
        let node = Node::new();
        node.write(&images("/a"), "");
        let mut changes = node.changes();
        assert_eq!(changes.look(), None);
        node.write(&images("/a"), "# a remark\n");
        assert_eq!(changes.look(), None);
        node.write(&images("/b"), "");
        assert_eq!(changes.look(), from_file(SourceConfig::images("/b")));
        node.write(&images("/c"), "nonsense = 1\n");
        assert_eq!(changes.look(), None);
        std::fs::remove_file(node.file()).unwrap();
        assert_eq!(changes.look(), None);
        node.write(&images("/c"), "");
        assert_eq!(changes.look(), from_file(SourceConfig::images("/c")));
    }

    #[test]
    fn the_site_has_the_last_word_until_it_removes_its_settings() {
        let node = Node::new();
        node.write(
            "kind = \"simulator\"\nscenario = \"/s.toml\"\nrate_hz = 10.0",
            "",
        );
        let (mut changes, files) = (node.changes(), node.settings_files());
        let own = changes.source.clone();
        let none = CameraSettings::none("c".parse().unwrap());
        let settings = CameraSettings {
            rate_hz: Some(5.0),
            ..none.clone()
        };
        files.write_settings(&settings).unwrap();
        let wanted = changes.look().unwrap();
        assert_eq!(wanted.source, own.with(&settings).ok());
        assert_eq!(wanted.site, Some(settings));
        assert_eq!(changes.look(), None);
        files.write_settings(&none).unwrap();
        assert_eq!(changes.look(), from_file(own));
    }

    #[test]
    fn a_source_without_settings_says_so_and_stays_as_the_file_has_it() {
        let node = Node::new();
        node.write(&images("/a"), "");
        let mut changes = node.changes();
        let settings = CameraSettings {
            gain: Some(5.0),
            ..CameraSettings::none("c".parse().unwrap())
        };
        node.settings_files().write_settings(&settings).unwrap();
        let wanted = changes.look().unwrap();
        assert_eq!(wanted.source, None);
        assert!(wanted.refusal.unwrap().contains("recorded"));
    }
}
