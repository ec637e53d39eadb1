//! A wall clock of one process that a test sets while the process runs.

use crate::preloaded::compiled;
use std::fs;
use std::os::unix::fs::FileExt;
use tempfile::TempDir;

/// A library that is preloaded into a process, and the offset that it reads.
#[derive(Debug)]
pub struct SteppedClock {
    folder: TempDir,
    offset: fs::File,
}

impl SteppedClock {
    /// A clock that is right.
    ///
    /// # Panics
    /// Without a C compiler (`cc`).
    #[must_use]
    pub fn new() -> Self {
        let folder = compiled("stepped_clock.c", "clock.so");
        let offset = fs::File::create(folder.path().join("offset")).expect("a file");
        let clock = Self { folder, offset };
        clock.set(0);
        clock
    }

    /// Sets the clock to be ahead of this machine's by so many ns.
    ///
    /// # Panics
    /// When the file cannot be written.
    pub fn set(&self, by_ns: i64) {
        let written = self.offset.write_all_at(&by_ns.to_le_bytes(), 0);
        written.expect("a file");
    }

    /// The command that runs a process by this clock.
    #[must_use]
    pub fn wrapper(&self) -> [String; 3] {
        let path = |name: &str| self.folder.path().join(name).display().to_string();
        [
            "env".to_owned(),
            format!("LD_PRELOAD={}", path("clock.so")),
            format!("CLOCK_OFFSET={}", path("offset")),
        ]
    }
}

impl Default for SteppedClock {
    fn default() -> Self {
        Self::new()
    }
}
