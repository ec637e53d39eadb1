//! What can be wrong with a recording.

use std::io;
use std::path::{Path, PathBuf};

/// A recording that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// A file or folder is missing or may not be read.
    #[error("{}: {}; {remedy}", path.display(), cause_of(source))]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// A file says something wrong.
    #[error("{}: {cause}; {remedy}", place(path, *line))]
    Wrong {
        /// The file or folder.
        path: PathBuf,
        /// The line, from 1; none when it is about the whole.
        line: Option<usize>,
        /// What is wrong.
        cause: String,
        /// What to do.
        remedy: &'static str,
    },
}

impl RecordingError {
    pub(crate) fn wrong(
        path: &Path,
        line: impl Into<Option<usize>>,
        cause: impl Into<String>,
        remedy: &'static str,
    ) -> Self {
        Self::Wrong {
            path: path.to_owned(),
            line: line.into(),
            cause: cause.into(),
            remedy,
        }
    }

    pub(crate) fn unreadable(
        path: &Path,
        remedy: &'static str,
    ) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Unreadable {
            path,
            source,
            remedy,
        }
    }
}

fn place(path: &Path, line: Option<usize>) -> String {
    match line {
        Some(line) => format!("{}:{line}", path.display()),
        None => path.display().to_string(),
    }
}

/// The system's words without its error number.
fn cause_of(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::NotADirectory => "this is a file, not a folder".into(),
        io::ErrorKind::IsADirectory => "this is a folder, not a file".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::InvalidData => "this is not UTF-8 text".into(),
        _ => error.to_string(),
    }
}
