//! Exit codes, common to all programs of Sextant, and the printing of error chains.

use std::fmt;
use std::process::ExitCode;

/// Exit code of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// Success.
    Success = 0,
    /// Any other fault at run time.
    Fault = 1,
    /// Wrong usage of the command line (clap's own code).
    Usage = 2,
    /// A given file is missing or invalid.
    Input = 3,
    /// A port, camera or service is in use or unreachable; or a calibration is partial: some of its cameras or tags
    /// could not be placed.
    Unavailable = 4,
    /// A thread panicked: a defect of the program (Rust's own code for it).
    Panic = 101,
    /// Interrupted before there was a result.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// An error with its exit code.
#[derive(Debug)]
pub struct Failure {
    exit: Exit,
    error: anyhow::Error,
}

impl Failure {
    /// Wraps `error`, which ends the process with `exit`.
    pub fn new(exit: Exit, error: impl Into<anyhow::Error>) -> Self {
        Self {
            exit,
            error: error.into(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.error, f)
    }
}

impl std::error::Error for Failure {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.error.source()
    }
}

/// Assigns an exit code to the error of a result: `read_rig(path).exit_with(Exit::Input)?`.
pub trait WithExit<T> {
    /// The result, whose error ends the process with `exit`.
    fn exit_with(self, exit: Exit) -> anyhow::Result<T>;
}

impl<T, E: Into<anyhow::Error>> WithExit<T> for Result<T, E> {
    fn exit_with(self, exit: Exit) -> anyhow::Result<T> {
        self.map_err(|error| Failure::new(exit, error).into())
    }
}

/// Exit code of an error: that of the outermost [`Failure`] in its chain, else [`Exit::Fault`]. A file that could not
/// be read for want of handles or memory, or by a fault of the disk, is not a wrong file: units start their node again
/// after [`Exit::Fault`], not after [`Exit::Input`].
pub fn exit_of(error: &anyhow::Error) -> Exit {
    let direct = error.downcast_ref::<Failure>();
    let within = || error.chain().find_map(|cause| cause.downcast_ref());
    match direct.or_else(within) {
        None => Exit::Fault,
        Some(Failure {
            exit: Exit::Input,
            error: cause,
        }) if cause.chain().any(passes) => Exit::Fault,
        Some(failure) => failure.exit,
    }
}

/// Whether a cause is an error of the system that may be gone at the next try.
fn passes(cause: &(dyn std::error::Error + 'static)) -> bool {
    const PASSING: [i32; 6] = [
        libc::EMFILE,
        libc::ENFILE,
        libc::ENOMEM,
        libc::EIO,
        libc::ESTALE,
        libc::ENOLCK,
    ];
    let system = cause.downcast_ref::<std::io::Error>();
    system.is_some_and(|error| {
        error.kind() == std::io::ErrorKind::OutOfMemory
            || error
                .raw_os_error()
                .is_some_and(|code| PASSING.contains(&code))
    })
}

/// The end of `main`: prints the chain of an error once, on stderr, and returns the exit code.
pub fn report(result: anyhow::Result<()>) -> ExitCode {
    match result {
        Ok(()) => Exit::Success.into(),
        Err(error) => {
            eprintln!("error: {error:#}");
            exit_of(&error).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    fn missing_file() -> std::io::Result<()> {
        Err(std::io::Error::from(std::io::ErrorKind::NotFound))
    }

    #[test]
    fn a_plain_error_is_a_fault() {
        assert_eq!(exit_of(&anyhow::anyhow!("no")), Exit::Fault);
    }

    #[test]
    fn the_code_survives_context() {
        let error = missing_file()
            .exit_with(Exit::Input)
            .context("reading the rig")
            .unwrap_err();
        assert_eq!(exit_of(&error), Exit::Input);
        assert_eq!(format!("{error:#}"), "reading the rig: entity not found");
    }

    #[test]
    fn what_may_be_gone_at_the_next_try_is_no_wrong_file() {
        let of = |code| std::io::Error::from_raw_os_error(code);
        for code in [libc::EMFILE, libc::ENOMEM, libc::EIO] {
            let error = Err::<(), _>(of(code)).context("reading f.toml");
            let error = error
                .exit_with(Exit::Input)
                .context("starting")
                .unwrap_err();
            assert_eq!(exit_of(&error), Exit::Fault, "{code}");
        }
        for code in [libc::ENOENT, libc::EACCES, libc::EISDIR] {
            let error = Err::<(), _>(of(code)).exit_with(Exit::Input).unwrap_err();
            assert_eq!(exit_of(&error), Exit::Input, "{code}");
        }
    }

    #[test]
    fn the_outermost_code_wins() {
        let inner = missing_file().exit_with(Exit::Input);
        assert_eq!(
            exit_of(&inner.exit_with(Exit::Unavailable).unwrap_err()),
            Exit::Unavailable
        );
    }
}
