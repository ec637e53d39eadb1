//! Lines that are written whole or not at all, also on a full disk.

use std::fs::File;
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};

/// Appends `line`, including its line feed, to a file. A partially written line is truncated again,
/// unless the file is not a regular one or another process has appended to it.
///
/// # Errors
/// An error of the system, as on a full disk.
pub fn write_line(file: &File, line: &[u8]) -> io::Result<()> {
    let mut left = line;
    while !left.is_empty() {
        let mut writer = file;
        let cause = match writer.write(left) {
            Ok(0) => ErrorKind::WriteZero.into(),
            Ok(written) => {
                left = &left[written..];
                continue;
            }
            Err(cause) if cause.kind() == ErrorKind::Interrupted => continue,
            Err(cause) => cause,
        };
        // The first error is the relevant one.
        let _ = take_back(file, line.len() - left.len());
        return Err(cause);
    }
    Ok(())
}

fn take_back(mut file: &File, written: usize) -> io::Result<()> {
    let metadata = file.metadata()?;
    if written == 0 || !metadata.is_file() || file.stream_position()? != metadata.len() {
        return Ok(());
    }
    let start = metadata.len().saturating_sub(written as u64);
    file.set_len(start)?;
    file.seek(SeekFrom::Start(start))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, OpenOptions};
    use std::process::{Command, Stdio};

    const LINE: &str = "a line of twenty-four B\n";
    /// Not a multiple of the line length.
    const ROOM_BYTES: u64 = 100;

    /// Limits the size of files of this process to [`ROOM_BYTES`]: a disk that becomes full in the middle of a line.
    fn fill_disk() {
        let limit = libc::rlimit {
            rlim_cur: ROOM_BYTES,
            rlim_max: ROOM_BYTES,
        };
        // SAFETY: `limit` is a valid rlimit; ignoring a signal has no precondition.
        unsafe {
            assert_eq!(libc::setrlimit(libc::RLIMIT_FSIZE, &raw const limit), 0);
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        }
    }

    /// Runs a test of this module again as a process with a full disk and its standard error in a file.
    fn on_a_full_disk(name: &str, append: bool) -> String {
        let log = tempfile::NamedTempFile::new().unwrap();
        let file = OpenOptions::new()
            .write(true)
            .append(append)
            .open(log.path());
        let done = Command::new(std::env::current_exe().unwrap())
            .args([
                &format!("whole_lines::tests::{name}"),
                "--exact",
                "--nocapture",
            ])
            .env(CHILD, "1")
            .env("SEXTANT_LOG", "debug")
            .stdout(Stdio::null())
            .stderr(file.unwrap())
            .status();
        assert!(done.unwrap().success());
        fs::read_to_string(log.path()).unwrap()
    }

    const CHILD: &str = "SEXTANT_TEST_FULL_DISK";

    #[test]
    fn a_full_disk_ends_a_file_with_a_whole_line() {
        if std::env::var_os(CHILD).is_some() {
            fill_disk();
            let file = File::from(
                std::os::fd::AsFd::as_fd(&io::stderr())
                    .try_clone_to_owned()
                    .unwrap(),
            );
            let written = (0..9).filter(|_| write_line(&file, LINE.as_bytes()).is_ok());
            assert_eq!(written.count(), 4);
            return;
        }
        for append in [true, false] {
            let text = on_a_full_disk("a_full_disk_ends_a_file_with_a_whole_line", append);
            assert_eq!(text, LINE.repeat(4));
        }
    }

    #[test]
    fn a_full_disk_ends_a_log_with_a_whole_line_and_nothing_else() {
        if std::env::var_os(CHILD).is_some() {
            fill_disk();
            crate::logging::init("test");
            (0..9).for_each(|number| tracing::debug!(number, "it is logged"));
            return;
        }
        let name = "a_full_disk_ends_a_log_with_a_whole_line_and_nothing_else";
        let text = on_a_full_disk(name, true);
        assert!(text.ends_with('\n'), "{text}");
        assert!(
            text.lines()
                .all(|line| line.contains("it is logged number=")),
            "{text}"
        );
    }
}
