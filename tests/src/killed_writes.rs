//! A process that is killed before one of the calls by which it changes its files.

use crate::preloaded::compiled;
use std::ffi::OsString;
use std::path::Path;
use tempfile::TempDir;

/// A library that is preloaded into a process and kills it (SIGKILL) before a call that changes files of a folder:
/// creating, writing, flushing, renaming, removing.
#[derive(Debug)]
pub struct KilledWrites {
    folder: TempDir,
}

impl KilledWrites {
    /// Compiles it.
    ///
    /// # Panics
    /// Without a C compiler (`cc`).
    #[must_use]
    pub fn new() -> Self {
        let folder = compiled("killed_writes.c", "writes.so");
        Self { folder }
    }

    /// The environment of a process that ends before the `nth` call (from 1) on files below `folder`, counted from when
    /// the file `armed` is there.
    #[must_use]
    pub fn environment(
        &self,
        nth: usize,
        folder: &Path,
        armed: &Path,
    ) -> [(OsString, OsString); 4] {
        let library = self.folder.path().join("writes.so");
        [
            ("LD_PRELOAD".into(), library.into()),
            ("KILL_AT".into(), nth.to_string().into()),
            ("KILL_IN".into(), folder.into()),
            ("KILL_ARMED".into(), armed.into()),
        ]
    }
}

impl Default for KilledWrites {
    fn default() -> Self {
        Self::new()
    }
}
