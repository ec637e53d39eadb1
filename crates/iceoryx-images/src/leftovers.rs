//! Resources left by killed processes, and their removal.

use std::fs::{self, File};
use std::path::Path;
use std::time::Duration;

use iceoryx2::node::{Node, NodeState};
use iceoryx2::prelude::{CallbackProgression, ipc};

use crate::domain::{Domain, DomainLock, NODES, SERVICES};
use crate::folder::{open_own_folder_in, own_entries, remove_empty_folder, remove_own_files};
use crate::{IceoryxOptions, ImagesError};

/// Where POSIX shared memory appears as files.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Time limit for another process that cleans up the same dead node.
const CLEAN_TIMEOUT: Duration = Duration::from_secs(1);

/// Result of a clean-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Leftovers {
    /// Live processes (or threads with ports of their own).
    pub alive: usize,
    /// Dead nodes whose resources were removed.
    pub removed: usize,
    /// Dead nodes whose resources could not be removed, usually because they belong to another user.
    pub failed: usize,
    /// Number of removed files without an owner.
    pub files: usize,
}

/// Removes the ports and images of dead processes and, if no process is alive, every file with the prefix, and the
/// folder if it is empty.
///
/// # Errors
/// A folder that does not belong to this user, or that another process holds locked for longer than a second.
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

/// Removes dead nodes through iceoryx2, then, if no node is left, all files. The lock keeps other processes from
/// opening meanwhile.
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

/// Removes the files with the prefix, then empty folders.
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

/// Each node has a folder below `nodes`, named without the prefix; its files have it.
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
