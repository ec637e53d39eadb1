//! A program that runs for us, without a shell: its output as bytes, its standard error line by line.

use std::io::{self, ErrorKind, Read};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::path::{Path, PathBuf};
use std::process::{ChildStderr, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use sextant_process::children::ChildProcess;
use sextant_process::{Exit, Shutdown};

use crate::source::SourceError;

/// The longest line of a program that is kept; the rest of it is passed over.
const MAX_LINE_BYTES: usize = 400;
/// How long a program may take to end, by itself or once it is asked to.
const GRACE: Duration = Duration::from_secs(1);
/// What the pipe holds, if the kernel grants it: some images, so that a program need not wait for us.
const PIPE_BYTES: i32 = 1 << 20;

/// The running program. Dropping it ends it with all that it has started.
#[derive(Debug)]
pub(super) struct Program {
    name: String,
    child: ChildProcess,
    output: ChildStdout,
    errors: Option<ChildStderr>,
    line: Vec<u8>,
    last_words: String,
}

/// Whether the program's output can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Output {
    Readable,
    Nothing,
}

impl Program {
    /// Starts a program.
    ///
    /// # Errors
    /// One that is not there or cannot be started.
    pub(super) fn start(words: &[String]) -> Result<Self, SourceError> {
        let Some((program, arguments)) = words.split_first() else {
            return Err(SourceError::new(Exit::Input, "source.run names no program"));
        };
        let mut command = Command::new(program);
        command
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let cannot = |cause: io::Error| cannot_start(program, &cause);
        let mut child = ChildProcess::spawn_group(program, &mut command).map_err(cannot)?;
        let (output, errors) = (
            child.child_mut().stdout.take(),
            child.child_mut().stderr.take(),
        );
        let (Some(output), Some(errors)) = (output, errors) else {
            return Err(cannot(io::Error::from(ErrorKind::BrokenPipe)));
        };
        never_block(output.as_fd()).map_err(cannot)?;
        never_block(errors.as_fd()).map_err(cannot)?;
        enlarge(output.as_fd());
        Ok(Self {
            name: program.clone(),
            child,
            output,
            errors: Some(errors),
            line: Vec::with_capacity(MAX_LINE_BYTES),
            last_words: String::new(),
        })
    }

    /// Waits for output; tells `hear` each line of standard error that comes meanwhile.
    pub(super) fn wait(
        &mut self,
        shutdown: &Shutdown,
        timeout: Duration,
        hear: &mut dyn FnMut(&str),
    ) -> io::Result<Output> {
        let entry = |fd| libc::pollfd {
            fd,
            events: libc::POLLIN,
            revents: 0,
        };
        let errors = self.errors.as_ref().map_or(-1, AsRawFd::as_raw_fd);
        let mut polled = [
            entry(self.output.as_raw_fd()),
            entry(shutdown.as_fd().as_raw_fd()),
            entry(errors),
        ];
        let timeout_ms = i32::try_from(timeout.as_micros().div_ceil(1000)).unwrap_or(i32::MAX);
        // SAFETY: three valid entries, whose descriptors stay open for the whole call; the kernel ignores -1.
        if unsafe { libc::poll(polled.as_mut_ptr(), 3, timeout_ms) } == -1 {
            let cause = io::Error::last_os_error();
            return match cause.kind() {
                ErrorKind::Interrupted => Ok(Output::Nothing),
                _ => Err(cause),
            };
        }
        if polled[2].revents != 0 {
            self.listen(hear);
        }
        if polled[0].revents == 0 || shutdown.is_requested() {
            return Ok(Output::Nothing);
        }
        Ok(Output::Readable)
    }

    /// Reads output; zero bytes are its end.
    ///
    /// # Errors
    /// `WouldBlock` where there is none now.
    pub(super) fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        self.output.read(room)
    }

    /// Reads standard error as far as there is any.
    pub(super) fn listen(&mut self, hear: &mut dyn FnMut(&str)) {
        let mut chunk = [0; 4096];
        while let Some(errors) = &mut self.errors {
            match errors.read(&mut chunk) {
                Ok(0) => self.errors = None,
                Ok(count) => chunk[..count]
                    .iter()
                    .for_each(|byte| self.take(*byte, hear)),
                Err(cause) if cause.kind() == ErrorKind::WouldBlock => return,
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.errors = None,
            }
        }
    }

    fn take(&mut self, byte: u8, hear: &mut dyn FnMut(&str)) {
        if byte != b'\n' && byte != b'\r' {
            if self.line.len() < MAX_LINE_BYTES {
                self.line.push(byte);
            }
            return;
        }
        let text = String::from_utf8_lossy(&self.line);
        let text = text.trim();
        if !text.is_empty() {
            hear(text);
            text.clone_into(&mut self.last_words);
        }
        self.line.clear();
    }

    /// Waits for the end of a program whose output has ended, and says how it ended.
    pub(super) fn end(mut self, hear: &mut dyn FnMut(&str)) -> Ended {
        let status = self.child.wait_until(Instant::now() + GRACE).ok().flatten();
        self.listen(hear);
        self.take(b'\n', hear);
        let how = match status {
            Some(status) => format!("{} ended ({status})", self.name),
            None => format!("{} closed its output", self.name),
        };
        Ended {
            is_success: status.is_some_and(|status| status.success()),
            words: match self.last_words.as_str() {
                "" => how,
                words => format!("{how}; its last words: {words}"),
            },
        }
    }
}

/// How a program ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ended {
    pub(crate) is_success: bool,
    pub(crate) words: String,
}

impl Drop for Program {
    fn drop(&mut self) {
        self.child.ask_to_stop();
        // One that does not end is killed, with its group.
        if let Err(cause) = self.child.wait_until(Instant::now() + GRACE) {
            tracing::debug!(%cause, program = self.name, "it cannot be waited for");
        }
    }
}

/// Where a program lies, by the search path unless its name has a slash.
pub(crate) fn locate(program: &str) -> Option<PathBuf> {
    let is_program = |path: &PathBuf| path.is_file();
    if program.contains('/') {
        return Some(PathBuf::from(program)).filter(is_program);
    }
    let search_path = std::env::var_os("PATH")?;
    std::env::split_paths(&search_path)
        .map(|folder| folder.join(Path::new(program)))
        .find(is_program)
}

pub(super) fn cannot_start(program: &str, cause: &io::Error) -> SourceError {
    let (exit, remedy) = match cause.kind() {
        ErrorKind::NotFound => (Exit::Input, "; is it installed, and on the search path?"),
        ErrorKind::PermissionDenied => (Exit::Input, "; is it a program?"),
        _ => (Exit::Unavailable, ""),
    };
    SourceError::new(
        exit,
        format!("{program} cannot be started: {cause}{remedy}"),
    )
}

fn never_block(fd: BorrowedFd<'_>) -> io::Result<()> {
    // SAFETY: fcntl with this command touches no memory of ours; the descriptor is open.
    let flags = unsafe { libc::fcntl(fd.as_raw_fd(), libc::F_GETFL) };
    if flags == -1 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: as above.
    let set = unsafe { libc::fcntl(fd.as_raw_fd(), libc::F_SETFL, flags | libc::O_NONBLOCK) };
    if set == -1 {
        return Err(io::Error::last_os_error());
    }
    Ok(())
}

fn enlarge(fd: BorrowedFd<'_>) {
    // SAFETY: fcntl with this command touches no memory of ours; the descriptor is open. A refusal leaves the pipe as
    // it is.
    unsafe { libc::fcntl(fd.as_raw_fd(), libc::F_SETPIPE_SZ, PIPE_BYTES) };
}
