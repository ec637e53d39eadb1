//! What can be wrong with keys, by what a person has to do.

use std::path::PathBuf;

/// Keys or endpoints that do not go with the profile.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SecurityError {
    /// The profile needs keys.
    #[error(
        "[security] profile \"{profile}\" needs keys: make some with `sextant keys add DIR NAME \
         --role ROLE` and name their folder, keys = \"DIR/NAME\" (--keys DIR/NAME on the command line)"
    )]
    NoKeys {
        /// The profile's word.
        profile: &'static str,
    },
    /// The profile makes no use of keys.
    #[error(
        "[security] profile \"{profile}\" makes no use of keys: write profile = \"site\" \
         (certificates) or \"lab\" (user and password), or remove keys"
    )]
    KeysWithoutUse {
        /// The profile's word.
        profile: &'static str,
    },
    /// The folder is no folder of keys.
    #[error("{}: these are no keys of a node ({cause}); name a folder that `sextant keys add` \
        has made", path.display())]
    NotKeys {
        /// The folder.
        path: PathBuf,
        /// What is missing or wrong.
        cause: String,
    },
    /// A secret that others can read.
    #[error("{}: other users of this machine can read this secret; run `chmod 600` on it", path.display())]
    Readable {
        /// The file.
        path: PathBuf,
    },
    /// Keys of another node or site.
    #[error("{}: these are the keys of {found}, but {expected} is configured; name the folder of \
        its own keys", path.display())]
    OtherIdentity {
        /// The folder.
        path: PathBuf,
        /// Whose they are.
        found: String,
        /// Whose they should be.
        expected: String,
    },
    /// A process that would let in everybody on the network.
    #[error(
        "{endpoint} can be reached from other machines, and [security] profile \"demo\" lets \
         everybody in: choose profile = \"site\" or \"lab\" (docs/security-setup.md), listen on \
         127.0.0.1, or write profile = \"open\" to let everybody in knowingly"
    )]
    OpenDoor {
        /// The endpoint.
        endpoint: String,
    },
    /// An endpoint of another protocol than the profile's.
    #[error(
        "{endpoint} does not go with [security] profile \"{profile}\": write {protocol}/ADDRESS:PORT"
    )]
    Protocol {
        /// The endpoint.
        endpoint: String,
        /// The profile's word.
        profile: &'static str,
        /// The profile's protocol.
        protocol: &'static str,
    },
    /// A node that listens without knowing the members.
    #[error(
        "{}: only keys of the role fusion can be a router's: they include the list of members; \
         create them with `sextant keys add DIR NAME --role fusion`", path.display()
    )]
    NotARouter {
        /// The folder of keys.
        path: PathBuf,
    },
}
