//! What can be wrong with a file, said so that a person can mend it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It is missing, may not be read, or is no text.
    #[error("{}: {}; {remedy}", path.display(), cause_of(source))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// It says something wrong.
    #[error(transparent)]
    InvalidFile(Box<InvalidFile>),
    /// What stands in its place is something else and is left alone.
    #[error("{}: is left as it is, since it is no file of {expected} ({cause}); move it away", path.display())]
    Occupied {
        /// The file.
        path: PathBuf,
        /// What was to be written: `the rig`, `object cube`.
        expected: String,
        /// How that is known.
        cause: String,
    },
    /// It cannot be written; the old one, if there was one, is untouched.
    #[error("{}: cannot be written: {}", path.display(), cause_of(source))]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// An error in a file, with its location.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InvalidFile {
    /// The file.
    pub path: PathBuf,
    /// Line and column, from 1; none when it is about the whole file.
    pub place: Option<(usize, usize)>,
    /// What is wrong there.
    pub complaint: Complaint,
}

/// What is wrong with a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Complaint {
    /// Path of the value inside the file, such as `camera[1].lens`; empty for the whole file.
    pub key: String,
    /// What is wrong.
    pub cause: String,
    /// What to do; empty where the cause says it.
    pub remedy: String,
}

impl Complaint {
    /// A complaint about the value of a key.
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
    /// What is wrong with a file as a whole.
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
    /// The file that it is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::Unreadable { path, .. }
            | Self::Occupied { path, .. }
            | Self::Unwritable { path, .. } => path,
            Self::InvalidFile(wrong) => &wrong.path,
        }
    }

    /// The wrong place, when there is one.
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

/// The system's words without its error number.
fn cause_of(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "this is a folder, not a file".into(),
        io::ErrorKind::InvalidData => "this is not UTF-8 text".into(),
        _ => error.to_string(),
    }
}
