//! When the nodes of this host that play one recording began. A node that starts later goes on where the others are, so
//! that their images stay simultaneous.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

/// A share in the playing of a recording, for as long as it lives.
#[derive(Debug)]
pub(crate) struct CommonStart {
    /// Holds the start as text. Locked for sharing: a file that no node has locked is a leftover of an earlier run.
    file: File,
    start_ns: u64,
}

impl CommonStart {
    /// Joins those who share the file, or begins at `now_ns`.
    ///
    /// # Errors
    /// A file that cannot be made or locked.
    pub(crate) fn join(path: &Path, now_ns: u64) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let file = options.open(path)?;
        let mut share = Self {
            start_ns: now_ns,
            file,
        };
        if share.file.try_lock().is_ok() {
            share.begin(now_ns)?;
        }
        // One of several that begin at once may have written last.
        share.file.lock_shared()?;
        let mut text = String::new();
        share.file.rewind()?;
        (&share.file).take(32).read_to_string(&mut text)?;
        share.start_ns = text.trim().parse().unwrap_or(now_ns);
        Ok(share)
    }

    /// When the recording's first image was played, or is, by this host's clock, ns.
    pub(crate) fn start_ns(&self) -> u64 {
        self.start_ns
    }

    /// Begins anew for all who join from now on.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn begin(&mut self, now_ns: u64) -> io::Result<()> {
        self.start_ns = now_ns;
        self.file.rewind()?;
        self.file.write_all(format!("{now_ns:<20}").as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_comes_later_joins_and_who_comes_after_all_have_left_begins() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("start");
        let join = |now_ns: u64| CommonStart::join(&path, now_ns).unwrap();
        let first = join(1_000_000_000);
        let second = join(7_000_000_000);
        assert_eq!(
            (first.start_ns(), second.start_ns()),
            (1_000_000_000, 1_000_000_000)
        );
        drop(first);
        let third = join(8_000_000_000);
        assert_eq!(third.start_ns(), 1_000_000_000);
        drop((second, third));
        assert_eq!(join(9).start_ns(), 9);
    }
}
