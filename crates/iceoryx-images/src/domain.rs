//! The site of shared memory on one host: its iceoryx2 configuration, and the lock for opening, closing and cleaning it
//! up.
//!
//! The root folder belongs to this user; any other is refused. The lock is a `flock` on the folder, so that it leaves
//! no file. It is held only while services are opened and closed; the last process to leave removes the folder, and the
//! lock ensures that no other process is opening it at that moment.

use std::ffi::CStr;
use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{
    Config, FileName, LogLevel, Path as IceoryxPath, SemanticString, set_log_level,
};

use crate::folder::{open_own_folder, open_own_folder_in};
use crate::options::MAX_ROOT_BYTES;
use crate::{IceoryxOptions, ImagesError};

/// iceoryx2's folders in the root.
pub(crate) const NODES: &CStr = c"nodes";
pub(crate) const SERVICES: &CStr = c"services";
/// Retry interval for the lock, which others hold for milliseconds.
const LOCK_PERIOD: Duration = Duration::from_millis(10);
/// Time limit for the lock when closing or cleaning up: a process that ends must end.
const BRIEFLY: Duration = Duration::from_secs(1);
/// Length of the prefix's readable part in file names; a hash covers the rest.
const SHOWN_PREFIX_BYTES: usize = 10;

/// Checked options.
#[derive(Debug, Clone)]
pub(crate) struct Domain {
    pub(crate) root: PathBuf,
    /// Prefix of every file name, in the root and in `/dev/shm`.
    pub(crate) prefix: String,
    pub(crate) config: Config,
}

impl Domain {
    /// Checks the options without touching a file.
    pub(crate) fn new(options: &IceoryxOptions) -> Result<Self, ImagesError> {
        quieten();
        let root = absolute(&options.root)?;
        check_name("prefix", &options.prefix)?;
        let prefix = file_prefix(&root, &options.prefix);
        let config = iceoryx_config(&root, &prefix).map_err(|cause| root_error(&root, cause))?;
        Ok(Self {
            root,
            prefix,
            config,
        })
    }

    /// Takes the lock and creates the folder if it is missing. Gives up when `stop` returns true.
    ///
    /// # Errors
    /// [`ImagesError::Root`] for a folder that is not this user's own, [`ImagesError::Abandoned`] after `stop`.
    pub(crate) fn lock(&self, stop: &dyn Fn() -> bool) -> Result<DomainLock, ImagesError> {
        let locked = self.wait_for_lock(stop);
        let locked = locked.map_err(|cause| root_error(&self.root, cause.to_string()))?;
        locked.ok_or_else(|| ImagesError::Abandoned {
            root: self.root.clone(),
        })
    }

    /// Takes the lock, or gives up after a second.
    pub(crate) fn lock_briefly(&self) -> Result<DomainLock, ImagesError> {
        let deadline = Instant::now() + BRIEFLY;
        self.lock(&|| Instant::now() >= deadline)
    }

    fn wait_for_lock(&self, stop: &dyn Fn() -> bool) -> io::Result<Option<DomainLock>> {
        loop {
            make_folder(&self.root)?;
            let folder = match open_own_folder(&self.root) {
                Err(cause) if cause.kind() == io::ErrorKind::NotFound => continue,
                opened => opened?,
            };
            if !exclusive(&folder, stop)? {
                return Ok(None);
            }
            // The previous holder of the lock may have removed the opened folder.
            match fs::symlink_metadata(&self.root) {
                Ok(now) if now.ino() == folder.metadata()?.ino() => {
                    check_inside(&folder)?;
                    return Ok(Some(DomainLock { folder }));
                }
                Err(cause) if cause.kind() != io::ErrorKind::NotFound => return Err(cause),
                _ => {}
            }
        }
    }
}

/// Locks a folder; false if `stop` returns true first.
fn exclusive(folder: &File, stop: &dyn Fn() -> bool) -> io::Result<bool> {
    loop {
        match folder.try_lock() {
            Ok(()) => return Ok(true),
            Err(TryLockError::WouldBlock) if stop() => return Ok(false),
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_PERIOD),
            Err(TryLockError::Error(cause)) => return Err(cause),
        }
    }
}

/// Path of a small file that the processes share beside their images. The last process to leave removes it.
///
/// # Errors
/// [`ImagesError::Root`] and [`ImagesError::Name`] for wrong options.
pub fn companion_file(options: &IceoryxOptions, name: &str) -> Result<PathBuf, ImagesError> {
    let Domain { root, prefix, .. } = Domain::new(options)?;
    Ok(root.join(format!("{prefix}{name}")))
}

/// iceoryx2 follows links, so there must be none.
fn check_inside(root: &File) -> io::Result<()> {
    for name in [NODES, SERVICES] {
        match open_own_folder_in(root, name) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                let name = name.to_string_lossy();
                return Err(io::Error::new(
                    cause.kind(),
                    format!("{name} in it: {cause}"),
                ));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Lock held while a process opens, closes or cleans up; released on drop.
#[derive(Debug)]
pub(crate) struct DomainLock {
    pub(crate) folder: File,
}

/// Whether an id may be part of names of services and files.
pub(crate) fn check_name(what: &'static str, value: &str) -> Result<(), ImagesError> {
    let is_good = |byte: u8| {
        byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_' || byte == b'-'
    };
    if (1..=32).contains(&value.len()) && value.bytes().all(is_good) {
        Ok(())
    } else {
        Err(ImagesError::Name {
            what,
            value: value.to_owned(),
        })
    }
}

/// Canonical absolute path of the folder, which need not exist: links in its existing ancestors are resolved. The
/// folder itself may not be a link.
fn absolute(root: &Path) -> Result<PathBuf, ImagesError> {
    let given = std::path::absolute(root).map_err(|cause| root_error(root, cause.to_string()))?;
    let found = given
        .ancestors()
        .skip(1)
        .find_map(|part| Some((part, part.canonicalize().ok()?)));
    let root: PathBuf = match found {
        Some((part, real)) => real
            .join(given.strip_prefix(part).unwrap_or(Path::new("")))
            .components()
            .collect(),
        None => given,
    };
    if root.as_os_str().len() > MAX_ROOT_BYTES {
        let cause = format!(
            "the path is longer than {MAX_ROOT_BYTES} bytes, which socket names need; choose a shorter one"
        );
        return Err(root_error(&root, cause));
    }
    Ok(root)
}

fn iceoryx_config(root: &Path, prefix: &str) -> Result<Config, String> {
    let mut config = Config::default();
    let root = IceoryxPath::new(root.as_os_str().as_encoded_bytes())
        .map_err(|cause| format!("{cause:?}"))?;
    config.global.set_root_path(&root);
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(|cause| format!("{cause:?}"))?;
    config.global.service.cleanup_dead_nodes_on_open = true;
    config.global.node.cleanup_dead_nodes_on_creation = true;
    config.global.node.cleanup_dead_nodes_on_destruction = true;
    Ok(config)
}

fn make_folder(root: &Path) -> io::Result<()> {
    fs::DirBuilder::new()
        .recursive(true)
        .mode(0o700)
        .create(root)
}

fn root_error(root: &Path, cause: String) -> ImagesError {
    ImagesError::Root {
        root: root.to_owned(),
        cause,
    }
}

/// iceoryx2 formats a message before `tracing` can filter it, so unwanted levels are filtered in iceoryx2.
fn quieten() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| set_log_level(LogLevel::Warn));
}

fn file_prefix(root: &Path, prefix: &str) -> String {
    let hash = fnv1a(
        root.as_os_str()
            .as_encoded_bytes()
            .iter()
            .chain([0].iter())
            .chain(prefix.as_bytes()),
    );
    let shown = &prefix[..prefix.len().min(SHOWN_PREFIX_BYTES)];
    format!("{shown}_{hash:08x}_")
}

/// FNV-1a, 32 bits (Fowler, Noll, Vo 1991): a short name for a path.
fn fnv1a<'a>(bytes: impl Iterator<Item = &'a u8>) -> u32 {
    bytes.fold(0x811c_9dc5, |hash, byte| {
        (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(root: &str, prefix: &str) -> IceoryxOptions {
        IceoryxOptions {
            root: root.into(),
            prefix: prefix.into(),
        }
    }

    #[test]
    fn other_roots_and_prefixes_have_other_names() {
        let prefix = |root, prefix| Domain::new(&options(root, prefix)).unwrap().prefix;
        assert_ne!(prefix("/tmp/a", "x"), prefix("/tmp/b", "x"));
        assert_ne!(prefix("/tmp/a", "x"), prefix("/tmp/a", "y"));
        assert_ne!(
            prefix("/tmp/a", "a-long-prefix-1"),
            prefix("/tmp/a", "a-long-prefix-2")
        );
        assert_eq!(prefix("/tmp/a", "x"), prefix("/tmp/a/", "x"));
    }

    #[test]
    fn a_long_root_and_a_bad_prefix_are_refused_with_the_reason() {
        let long = Domain::new(&options(&"/long".repeat(10), "x")).unwrap_err();
        assert!(long.to_string().contains("shorter"), "{long}");
        assert!(Domain::new(&options("/tmp/a", "a/b")).is_err());
        assert!(Domain::new(&options("/tmp/a", "")).is_err());
    }

    #[test]
    fn a_root_is_made_for_its_user_alone_and_a_link_to_one_is_refused() {
        let parent = tempfile::tempdir_in("/tmp").unwrap();
        let (real, link) = (parent.path().join("r"), parent.path().join("l"));
        let lock = |root: &Path| {
            Domain::new(&options(&root.display().to_string(), "x"))
                .unwrap()
                .lock(&|| true)
        };
        lock(&real).unwrap();
        assert_eq!(fs::metadata(&real).unwrap().mode() & 0o777, 0o700);
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let refusal = lock(&link).unwrap_err().to_string();
        assert!(refusal.contains("link"), "{refusal}");
        std::os::unix::fs::symlink(parent.path(), real.join("nodes")).unwrap();
        let refusal = lock(&real).unwrap_err().to_string();
        assert!(refusal.contains("nodes"), "{refusal}");
    }

    #[test]
    fn a_lock_that_another_holds_is_waited_for_until_asked_to_stop() {
        let parent = tempfile::tempdir_in("/tmp").unwrap();
        let domain = Domain::new(&options(
            &parent.path().join("r").display().to_string(),
            "x",
        ));
        let domain = domain.unwrap();
        let held = domain.lock(&|| false).unwrap();
        let asked = std::cell::Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) == 3;
        let refusal = domain.lock(&stop).unwrap_err();
        assert!(
            matches!(refusal, ImagesError::Abandoned { .. }),
            "{refusal}"
        );
        drop(held);
        domain.lock(&|| true).unwrap();
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let error = Domain::new(&options("/proc/none", "x"))
            .unwrap()
            .lock(&|| false)
            .unwrap_err();
        assert!(error.to_string().contains("/proc/none"), "{error}");
    }
}
