//! What killed processes leave behind, and its removal.

use std::fs;
use std::path::Path;
use std::time::Duration;

use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};

use crate::domain::{Domain, DomainLock};
use crate::{IceoryxOptions, ImagesError};

/// Where POSIX shared memory appears as files.
const SHARED_MEMORY: &str = "/dev/shm";
/// How long another process may take that is cleaning up the same dead node.
const CLEAN_TIMEOUT: Duration = Duration::from_secs(1);

/// What a cleaning found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Leftovers {
    /// Processes (or threads with ports of their own) that are alive.
    pub alive: usize,
    /// Dead ones whose resources were removed.
    pub removed: usize,
    /// Dead ones whose resources could not be removed: usually another user's.
    pub failed: usize,
    /// Files removed that belonged to nobody.
    pub files: usize,
}

/// Removes what dead processes left in a meeting place: their ports, their images, and, when nobody is alive there, every
/// file with its name, the folder included.
pub fn remove_dead(options: &IceoryxOptions) -> Result<Leftovers, ImagesError> {
    let domain = Domain::new(options)?;
    if !domain.root.exists() && files_in(Path::new(SHARED_MEMORY), &domain.prefix).is_empty() {
        return Ok(Leftovers::default());
    }
    let lock = domain.lock()?;
    Ok(tidy(&domain, &lock))
}

/// Removes dead nodes politely, then, when nobody is left, all files. The lock says that nobody is coming in meanwhile.
pub(crate) fn tidy(domain: &Domain, _lock: &DomainLock) -> Leftovers {
    let mut found = remove_dead_nodes(domain);
    if found.alive == 0 && found.failed == 0 {
        found.files = remove_all_files(domain);
    }
    found
}

fn remove_dead_nodes(domain: &Domain) -> Leftovers {
    let mut found = Leftovers::default();
    let listed = Node::<ipc::Service>::list(&domain.config, |state| {
        match state {
            NodeState::Alive(_) => found.alive += 1,
            NodeState::Dead(dead) => match dead.blocking_remove_stale_resources(CLEAN_TIMEOUT) {
                Ok(()) => found.removed += 1,
                Err(cause) => {
                    tracing::debug!(?cause, "a dead process's shared memory stays for now");
                    found.failed += 1;
                }
            },
            NodeState::Inaccessible(_) | NodeState::Undefined(_) => found.failed += 1,
        }
        CallbackProgression::Continue
    });
    if let Err(cause) = listed {
        tracing::warn!(?cause, "cannot list the users of shared memory");
        found.failed += 1;
    }
    found
}

fn remove_all_files(domain: &Domain) -> usize {
    let mut removed = 0;
    let service_folder = domain.root.join("services");
    let node_folder = domain.root.join("nodes");
    for folder in [
        Path::new(SHARED_MEMORY),
        &service_folder,
        &node_folder,
        &domain.root,
    ] {
        for file in files_in(folder, &domain.prefix) {
            removed += usize::from(fs::remove_file(file).is_ok());
        }
    }
    remove_empty_folders(&node_folder);
    for folder in [&service_folder, &node_folder, &domain.root] {
        // A folder with something in it that is not ours stays.
        let _ = fs::remove_dir(folder);
    }
    removed
}

/// Each node has a folder of its own below `nodes`, whose files carry the prefix as well.
fn remove_empty_folders(nodes: &Path) {
    for entry in fs::read_dir(nodes).into_iter().flatten().flatten() {
        let _ = fs::remove_dir_all(entry.path());
    }
}

fn files_in(folder: &Path, prefix: &str) -> Vec<std::path::PathBuf> {
    fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix))
        .filter(|entry| entry.file_type().is_ok_and(|kind| !kind.is_dir()))
        .map(|entry| entry.path())
        .collect()
}
