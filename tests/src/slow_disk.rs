//! A disk of one process that is slow.

use crate::preloaded::compiled;
use tempfile::TempDir;

/// A library that is preloaded into a process: each fsync takes 0.7 s more.
#[derive(Debug)]
pub struct SlowDisk {
    folder: TempDir,
}

impl SlowDisk {
    /// Compiles it.
    ///
    /// # Panics
    /// Without a C compiler (`cc`).
    #[must_use]
    pub fn new() -> Self {
        let folder = compiled("slow_disk.c", "disk.so");
        Self { folder }
    }

    /// The command that runs a process on this disk.
    #[must_use]
    pub fn wrapper(&self) -> [String; 2] {
        let library = self.folder.path().join("disk.so");
        [
            "env".to_owned(),
            format!("LD_PRELOAD={}", library.display()),
        ]
    }
}

impl Default for SlowDisk {
    fn default() -> Self {
        Self::new()
    }
}
