//! The `[shared_memory]` section of a camera's configuration: where processes of one host share images.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use rustix::process::geteuid;
use serde::{Deserialize, Serialize};

use crate::folder::open_own_folder;

/// Largest length of the root in bytes. A socket path has 107: root, a slash, the prefix (at most 20), an id (39),
/// `.event` (6).
pub(crate) const MAX_ROOT_BYTES: usize = 40;

/// Folder and prefix of the shared memory. Processes with equal values share images; others never interfere, since all
/// names derive from both values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IceoryxOptions {
    /// Folder of the bookkeeping files. It belongs to this process's user alone, is created when missing and removed by
    /// the last process to leave. At most 40 bytes, since socket paths are short. All processes must run as the same
    /// user. Default: `$XDG_RUNTIME_DIR/sextant` where that is a folder of this user, else `/tmp/sextant-<user id>`.
    pub root: PathBuf,
    /// Prefix of every name in `/dev/shm`: 1 to 32 of a-z, 0-9, _ and -.
    pub prefix: String,
}

impl Default for IceoryxOptions {
    fn default() -> Self {
        Self {
            root: default_root(std::env::var_os("XDG_RUNTIME_DIR").as_deref()),
            prefix: "sextant".to_owned(),
        }
    }
}

/// Another user's folder, which `sudo` may pass on, is ignored.
fn default_root(runtime_folder: Option<&OsStr>) -> PathBuf {
    let folder = runtime_folder
        .map(Path::new)
        .filter(|folder| folder.is_absolute() && open_own_folder(folder).is_ok());
    folder
        .map(|folder| folder.join("sextant"))
        .filter(|root| root.as_os_str().len() <= MAX_ROOT_BYTES)
        .unwrap_or_else(|| format!("/tmp/sextant-{}", geteuid().as_raw()).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_root_is_a_folder_of_this_user_alone() {
        let runtime = tempfile::tempdir_in("/tmp").unwrap();
        let own = default_root(Some(runtime.path().as_os_str()));
        assert_eq!(own, runtime.path().join("sextant"));
        let fallback = default_root(None);
        assert_eq!(
            fallback,
            Path::new(&format!("/tmp/sextant-{}", geteuid().as_raw()))
        );
        for unfit in ["", "tmp", "/none", "/dev/null", "/tmp"] {
            assert_eq!(default_root(Some(OsStr::new(unfit))), fallback, "{unfit}");
        }
    }
}
