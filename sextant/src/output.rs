//! What goes to standard output, and how: lines for people, or JSON lines for programs. Complaints go to standard
//! error.

use std::io::{self, Write};

/// For whom a command speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// For people.
    Text,
    /// One JSON value a line.
    Json,
}

/// Prints a line and hands it on at once, so that the next program of a pipe sees it.
///
/// # Errors
/// What the system refuses; a reader that has gone away is [`io::ErrorKind::BrokenPipe`], which ends the program
/// quietly.
pub fn print_line(line: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(line.as_bytes())?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Whether an error is a closed output pipe.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<io::Error>()
            .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    })
}
