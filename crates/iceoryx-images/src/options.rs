//! The `[shared_memory]` section of a camera's configuration: where processes of one host meet.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The meeting place. Processes that name the same one share images; others never interfere, since the names of all
/// shared memory derive from both values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IceoryxOptions {
    /// Folder of the bookkeeping files; made when missing, removed when the last process leaves. At most 40 bytes, since
    /// socket paths are short. All processes must run as the same user.
    pub root: PathBuf,
    /// Start of every name in `/dev/shm`, up to 32 of a-z, 0-9, _ and -.
    pub prefix: String,
}

impl Default for IceoryxOptions {
    fn default() -> Self {
        Self {
            root: PathBuf::from("/tmp/sextant"),
            prefix: "sextant".to_owned(),
        }
    }
}
