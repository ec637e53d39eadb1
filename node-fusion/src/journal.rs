//! The journal of a change: all that it writes, in one file beside `fusion.toml`, before any other file is touched.
//!
//! The journal is written atomically and removed last. A node that starts and finds one was ended in the middle of a
//! change, and completes it: what the journal says counts, whatever of it the other files hold already.

use crate::models::Change;
use crate::replica::{KeepJob, ModelsRecord};
use anyhow::Context;
use serde::{Deserialize, Serialize};
use sextant_proto::{CameraSettings, ModelsState, ModelsVersion, NodeId};
use sextant_site_files::{
    FileError, object_toml, parse_object, parse_rig, read_toml, rig_toml, write_toml,
};
use sextant_site_model::ObjectId;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// What the files hold once the change is made, as written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JournalText {
    record: RecordText,
    #[serde(default)]
    changes: Vec<ChangeText>,
}

/// A change; rigs and objects as the text of their files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ChangeText {
    Rig(String),
    Object(String),
    Removal(ObjectId),
    Camera(CameraSettings),
}

/// Which version of the models the files hold, as written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordText {
    /// Changes since the first version; this and the next two are missing where the files are of no version.
    counter: Option<u64>,
    /// When the last change was made, ns since the Unix epoch.
    t_ns: Option<u64>,
    /// The fusion node that made it.
    author: Option<NodeId>,
    /// Of the models, hexadecimal: TOML has no unsigned numbers of 64 bits.
    fingerprint: String,
    /// The newest version that the node knows of, where it could not get it.
    newer: Option<NewerText>,
}

/// A version that another node has.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NewerText {
    version: ModelsVersion,
    holder: NodeId,
}

impl From<&ModelsRecord> for RecordText {
    fn from(record: &ModelsRecord) -> Self {
        let (version, newer) = (record.state.version.as_ref(), record.newer.clone());
        Self {
            counter: version.map(|version| version.counter),
            t_ns: version.map(|version| version.t_ns),
            author: version.map(|version| version.author.clone()),
            fingerprint: format!("{:016x}", record.state.fingerprint),
            newer: newer.map(|(version, holder)| NewerText { version, holder }),
        }
    }
}

impl From<RecordText> for ModelsRecord {
    fn from(text: RecordText) -> Self {
        let numbers = text.counter.zip(text.t_ns).zip(text.author);
        let version = numbers.map(|((counter, t_ns), author)| ModelsVersion {
            counter,
            t_ns,
            author,
        });
        Self {
            state: ModelsState {
                version,
                fingerprint: u64::from_str_radix(&text.fingerprint, 16).unwrap_or_default(),
            },
            newer: text.newer.map(|newer| (newer.version, newer.holder)),
        }
    }
}

impl From<&Change> for ChangeText {
    fn from(change: &Change) -> Self {
        match change {
            Change::Rig(rig) => Self::Rig(rig_toml(rig)),
            Change::Object(model) => Self::Object(object_toml(model)),
            Change::Removal(id) => Self::Removal(id.clone()),
            Change::Camera(settings) => Self::Camera(settings.clone()),
        }
    }
}

impl ChangeText {
    fn change(self, journal: &Path) -> Result<Change, FileError> {
        Ok(match self {
            Self::Rig(text) => Change::Rig(parse_rig(journal, &text)?),
            Self::Object(text) => Change::Object(parse_object(journal, &text)?),
            Self::Removal(id) => Change::Removal(id),
            Self::Camera(settings) => Change::Camera(settings),
        })
    }
}

/// The file `fusion.toml.change`, beside the configuration of the node.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
}

impl Journal {
    /// Of the node with this configuration file.
    pub fn new(config: &Path) -> Self {
        let mut name = config.as_os_str().to_owned();
        name.push(".change");
        Self { path: name.into() }
    }

    /// Writes down what a job is going to write; it is on the disk afterwards.
    ///
    /// # Errors
    /// What the system refuses; nothing has changed then.
    pub fn begin(&self, job: &KeepJob) -> Result<(), FileError> {
        let text = JournalText {
            record: RecordText::from(&job.record),
            changes: job.changes.iter().map(ChangeText::from).collect(),
        };
        write_toml(&self.path, &text)
    }

    /// Ends the change: all of it is written, or none.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn end(&self) -> Result<(), FileError> {
        let removed = fs::remove_file(&self.path).and_then(|()| {
            let folder = self
                .path
                .parent()
                .filter(|path| !path.as_os_str().is_empty());
            File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
        });
        match removed {
            Err(source) if source.kind() != io::ErrorKind::NotFound => Err(FileError::Unwritable {
                path: self.path.clone(),
                source,
            }),
            _ => Ok(()),
        }
    }

    /// The job that was interrupted; none where none was.
    ///
    /// # Errors
    /// A journal that cannot be read.
    pub fn interrupted(&self) -> anyhow::Result<Option<KeepJob>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let read = || -> Result<KeepJob, FileError> {
            let text: JournalText = read_toml(&self.path)?;
            let changes = text.changes.into_iter();
            Ok(KeepJob {
                changes: changes
                    .map(|change| change.change(&self.path))
                    .collect::<Result<_, _>>()?,
                undo: Vec::new(),
                record: text.record.into(),
            })
        };
        let remedy = "this node was ended in the middle of a change, and the rest of it cannot be read: look at the \
            rig and the objects, put them right, and remove this file";
        read().context(remedy).map(Some)
    }
}
