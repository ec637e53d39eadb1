//! What a demo may leave behind on a machine: shared memory and temporary files.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The names of ours in shared memory and the temporary folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Traces {
    names: BTreeSet<String>,
}

impl Traces {
    /// Those of the demo whose parent has this process id.
    #[must_use]
    pub fn demo(demo: u32) -> Self {
        let mut names = BTreeSet::new();
        collect(Path::new("/dev/shm"), &format!("sx{demo}_"), &mut names);
        collect(
            &std::env::temp_dir(),
            &format!("sextant-demo-{demo}"),
            &mut names,
        );
        Self { names }
    }

    /// Whether nothing is there.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.names.is_empty()
    }
}

fn collect(folder: &Path, prefix: &str, names: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(prefix) {
            names.insert(entry.path().display().to_string());
        }
    }
}
