//! What killed processes leave behind, and its removal.

use std::fs::{self, File};
use std::path::Path;
use std::time::Duration;

use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};

use crate::domain::{Domain, DomainLock, NODES, SERVICES};
use crate::folder::{open_own_folder_in, own_entries, remove_empty_folder, remove_own_files};
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
    /// Number of removed files without an owner.
    pub files: usize,
}

/// Removes what dead processes left in a meeting place: their ports, their images, and, when nobody is alive there, every
/// file with its name, and the folder if nothing else is in it.
///
/// # Errors
/// A folder that is not this user's own, or that another process holds locked for longer than a second.
pub fn remove_dead(options: &IceoryxOptions) -> Result<Leftovers, ImagesError> {
    let domain = Domain::new(options)?;
    if fs::symlink_metadata(&domain.root).is_err() && !has_shared_memory(&domain) {
        return Ok(Leftovers::default());
    }
    let lock = domain.lock_briefly()?;
    Ok(tidy(&domain, &lock))
}

fn has_shared_memory(domain: &Domain) -> bool {
    let folder = File::open(SHARED_MEMORY);
    folder.is_ok_and(|folder| !own_entries(&folder, &domain.prefix, false).is_empty())
}

/// Removes dead nodes politely, then, when nobody is left, all files. The lock says that nobody is coming in meanwhile.
pub(crate) fn tidy(domain: &Domain, lock: &DomainLock) -> Leftovers {
    let mut found = remove_dead_nodes(domain);
    if found.alive == 0 && found.failed == 0 {
        found.files = remove_all_files(domain, lock);
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

/// Removes the files with this place's prefix, then the folders that are empty: another prefix's files keep theirs.
fn remove_all_files(domain: &Domain, lock: &DomainLock) -> usize {
    let prefix = &domain.prefix;
    let mut removed =
        File::open(SHARED_MEMORY).map_or(0, |folder| remove_own_files(&folder, prefix));
    for name in [SERVICES, NODES] {
        let Ok(folder) = open_own_folder_in(&lock.folder, name) else {
            continue;
        };
        removed += remove_own_files(&folder, prefix);
        if name == NODES {
            removed += remove_node_folders(&folder, prefix);
        }
        remove_empty_folder(&lock.folder, name);
    }
    removed += remove_own_files(&lock.folder, prefix);
    let _ = fs::remove_dir(Path::new(&domain.root));
    removed
}

/// Each node has a folder of its own below `nodes`, named without the prefix; its files carry it.
fn remove_node_folders(nodes: &File, prefix: &str) -> usize {
    let mut removed = 0;
    for name in own_entries(nodes, "", true) {
        if let Ok(folder) = open_own_folder_in(nodes, &name) {
            removed += remove_own_files(&folder, prefix);
            remove_empty_folder(nodes, &name);
        }
    }
    removed
}
