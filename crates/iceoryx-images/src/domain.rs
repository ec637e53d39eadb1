//! A meeting place of processes: iceoryx2's configuration for it, and the lock under which it is entered, left and tidied.
//!
//! The lock is a `flock` on the root folder itself, so that it leaves no file. It is held only for the moments of opening
//! and closing; the last one out removes the folder, and the lock makes sure that nobody is just coming in.

use std::fs::{self, File};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::sync::Once;

use iceoryx2::prelude::{
    Config, FileName, LogLevel, Path as IceoryxPath, SemanticString, set_log_level,
};

use crate::{IceoryxOptions, ImagesError};

/// Longest root in bytes. A socket's path has 107: root, a slash, our prefix (20 at most), an id (39), `.event` (6).
const MAX_ROOT_BYTES: usize = 40;
/// How much of the given prefix shows in file names; the rest counts through the hash.
const SHOWN_PREFIX_BYTES: usize = 10;

/// A checked meeting place.
#[derive(Debug, Clone)]
pub(crate) struct Domain {
    pub(crate) root: PathBuf,
    /// Start of every file name of this place, in the root and in `/dev/shm`.
    pub(crate) prefix: String,
    pub(crate) config: Config,
}

impl Domain {
    /// Checks the options; touches no file.
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

    /// Enters the lock, making the folder when it is missing.
    pub(crate) fn lock(&self) -> Result<DomainLock, ImagesError> {
        self.try_lock()
            .map_err(|cause| root_error(&self.root, cause.to_string()))
    }

    fn try_lock(&self) -> io::Result<DomainLock> {
        loop {
            make_folder(&self.root)?;
            let folder = match File::open(&self.root) {
                Err(cause) if cause.kind() == io::ErrorKind::NotFound => continue,
                opened => opened?,
            };
            exclusive(&folder)?;
            // Whoever held the lock before may have removed the folder that we opened.
            match fs::metadata(&self.root) {
                Ok(now) if now.ino() == folder.metadata()?.ino() => {
                    return Ok(DomainLock { _folder: folder });
                }
                Ok(_) => {}
                Err(cause) if cause.kind() == io::ErrorKind::NotFound => {}
                Err(cause) => return Err(cause),
            }
        }
    }
}

/// Held while a process enters, leaves or tidies; released on drop.
#[derive(Debug)]
pub(crate) struct DomainLock {
    _folder: File,
}

/// Ids that may stand in names of services and files.
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

/// The one name of a folder, whether or not it exists yet: absolute, links followed as far as there are any.
fn absolute(root: &Path) -> Result<PathBuf, ImagesError> {
    let given = std::path::absolute(root).map_err(|cause| root_error(root, cause.to_string()))?;
    let found = given
        .ancestors()
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

fn exclusive(folder: &File) -> io::Result<()> {
    loop {
        // SAFETY: flock touches no memory of ours; the descriptor stays open through the borrow.
        if unsafe { libc::flock(folder.as_raw_fd(), libc::LOCK_EX) } == 0 {
            return Ok(());
        }
        let cause = io::Error::last_os_error();
        if cause.kind() != io::ErrorKind::Interrupted {
            return Err(cause);
        }
    }
}

fn root_error(root: &Path, cause: String) -> ImagesError {
    ImagesError::Root {
        root: root.to_owned(),
        cause,
    }
}

/// iceoryx2 formats a message before `tracing` can refuse it, so what nobody reads is refused at its door.
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
    fn a_folder_that_cannot_be_made_is_named() {
        let error = Domain::new(&options("/proc/none", "x"))
            .unwrap()
            .lock()
            .unwrap_err();
        assert!(error.to_string().contains("/proc/none"), "{error}");
    }
}
