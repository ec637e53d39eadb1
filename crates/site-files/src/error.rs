//! Errors of files, with location, cause and remedy.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a file cannot be used, with its place and a remedy.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It is missing, unreadable, or not text.
    #[error("{}: {}; {remedy}", path.display(), cause_of(source))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
        /// The remedy.
        remedy: &'static str,
    },
    /// Its contents are invalid.
    #[error(transparent)]
    InvalidFile(Box<InvalidFile>),
    /// A file with other contents exists at this path and is not replaced.
    #[error("{}: is left as it is, since it is no file of {expected} ({cause}); move it away", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
        /// What would be written: `the rig`, `object cube`.
        expected: String,
        /// How the contents are recognised as other.
        cause: String,
    },
    /// It cannot be written; an existing file is unchanged.
    #[error("{}: cannot be written: {}", path.display(), cause_of(source))]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
}

/// An error in a file, with its location.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InvalidFile {
    /// The file.
    pub path: PathBuf,
    /// Line and column, from 1; `None` for the whole file.
    pub place: Option<(usize, usize)>,
    /// The cause.
    pub complaint: Complaint,
}

/// An invalid value: its key, the cause and a remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Complaint {
    /// Path of the value inside the file, such as `camera[1].lens`; empty for the whole file.
    pub key: String,
    /// The cause.
    pub cause: String,
    /// The remedy; empty if the cause implies it.
    pub remedy: String,
}

impl Complaint {
    /// An error in the value of a key.
    pub fn new(
        key: impl Into<String>,
        cause: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            key: key.into(),
            cause: cause.into(),
            remedy: remedy.into(),
        }
    }
}

impl InvalidFile {
    /// An error of the whole file.
    pub(crate) fn with_all(path: &Path, complaint: Complaint) -> Self {
        Self {
            path: path.to_owned(),
            place: None,
            complaint,
        }
    }
}

impl fmt::Display for InvalidFile {
    /// `file:line:column: key: cause; remedy`
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.path.display())?;
        if let Some((line, column)) = self.place {
            write!(out, ":{line}:{column}")?;
        }
        let Complaint { key, cause, remedy } = &self.complaint;
        if !key.is_empty() {
            write!(out, ": {key}")?;
        }
        write!(out, ": {cause}")?;
        if !remedy.is_empty() {
            write!(out, "; {remedy}")?;
        }
        Ok(())
    }
}

impl std::error::Error for InvalidFile {}

impl FileError {
    /// The file that cannot be used.
    pub fn path(&self) -> &Path {
        match self {
            Self::Unreadable { path, .. }
            | Self::Occupied { path, .. }
            | Self::Unwritable { path, .. } => path,
            Self::InvalidFile(wrong) => &wrong.path,
        }
    }

    /// The location, if there is one.
    pub fn wrong(&self) -> Option<&InvalidFile> {
        match self {
            Self::InvalidFile(wrong) => Some(wrong),
            _ => None,
        }
    }
}

impl From<InvalidFile> for FileError {
    fn from(wrong: InvalidFile) -> Self {
        Self::InvalidFile(Box::new(wrong))
    }
}

/// The system's message without its error number.
fn cause_of(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "this is a folder, not a file".into(),
        io::ErrorKind::InvalidData => "this is not UTF-8 text".into(),
        _ => error.to_string(),
    }
}
