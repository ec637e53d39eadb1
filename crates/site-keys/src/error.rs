//! Why keys are not made.

use sextant_proto::NodeId;
use sextant_site_files::FileError;
use sextant_zenoh_bus::Role;
use std::io;
use std::path::{Path, PathBuf};

/// Why keys are not made, renewed or revoked.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// The folder of a new authority has contents.
    #[error(
        "{}: there is something in this folder already; name a new one (`sextant keys list {}` \
         says whether it is an authority's)",
        .0.display(), .0.display()
    )]
    NotEmpty(PathBuf),
    /// A folder without an authority.
    #[error("{}: this is no authority's folder; `sextant keys init` makes one", dir.display())]
    NoAuthority {
        /// The folder.
        dir: PathBuf,
        /// What is missing, if that is known.
        source: Option<Box<dyn std::error::Error + Send + Sync>>,
    },
    /// A name that a file of the authority has.
    #[error("a member cannot be called {0}: choose another name")]
    ReservedName(NodeId),
    /// The name of a member.
    #[error(
        "{name} is a member already, as {role}: choose another name, `sextant keys renew` its \
         keys, or `sextant keys revoke` them first"
    )]
    NameTaken {
        /// The name.
        name: NodeId,
        /// The member's role.
        role: Role,
    },
    /// A folder where a new member's keys would be.
    #[error("{}: is in the way, though {name} is no member; move it away", folder.display())]
    InTheWay {
        /// The folder.
        folder: PathBuf,
        /// The new member.
        name: NodeId,
    },
    /// A name that is no member's.
    #[error("{name} is no member: `sextant keys list {}` lists them", dir.display())]
    UnknownMember {
        /// The name.
        name: String,
        /// The authority's folder.
        dir: PathBuf,
    },
    /// A member whose password is lost.
    #[error("the member has no password: revoke it and add it again")]
    NoPassword,
    /// The authority is no longer valid.
    #[error(
        "the authority in {} has expired: make a new one with `sextant keys init`, and new keys for every member",
        .0.display()
    )]
    Expired(PathBuf),
    /// A host that is none.
    #[error("--host {0}: this is neither the name nor the address of a machine")]
    Host(String),
    /// A folder that has no keys and is not removed.
    #[error("{}: is no folder of keys and is left as it is", .0.display())]
    NoKeys(PathBuf),
    /// The system refuses a file or folder.
    #[error("{}{}", path.display(), what)]
    System {
        /// The file or folder.
        path: PathBuf,
        /// What cannot be done with it; empty, or beginning with a colon.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A certificate cannot be made.
    #[error("{what}")]
    Certificate {
        /// Which part of it.
        what: String,
        /// The library's reason.
        source: rcgen::Error,
    },
    /// A time beyond those of certificates.
    #[error("a time of the distant future")]
    Time,
    /// Members or keys that no file can have.
    #[error("{0}")]
    Text(String),
}

impl KeysError {
    /// For `map_err`: an error of the system with `path`.
    pub(crate) fn system(path: &Path, what: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::System { path, what, source }
    }

    /// For `map_err`: an error of the certificate library.
    pub(crate) fn certificate(what: impl Into<String>) -> impl FnOnce(rcgen::Error) -> Self {
        let what = what.into();
        move |source| Self::Certificate { what, source }
    }
}
