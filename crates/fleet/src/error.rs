//! Why a deployment cannot begin, or not on one host.

use sextant_site_files::FileError;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::BusError;
use std::io;
use std::path::{Path, PathBuf};

/// What is wrong here, before a host is changed.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// A configuration cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The keys do not go with a configuration.
    #[error(transparent)]
    Security(#[from] BusError),
    /// A configuration of another camera or site.
    #[error(
        "{}: it is for camera {} of site {}, not for camera {} of site {} (--site)",
        file.display(), found[0], found[1], wanted[0], wanted[1]
    )]
    OtherCamera {
        /// The file.
        file: PathBuf,
        /// Its camera and site.
        found: [String; 2],
        /// The camera and the site that are wanted.
        wanted: [String; 2],
    },
    /// A configuration names keys, and no authority has them.
    #[error(
        "{}: it names keys; name the folder of `sextant keys` with --authority, which has them",
        .0.display()
    )]
    NoAuthority(PathBuf),
    /// Keys would lie outside the state folder.
    #[error(
        "{}: [security] keys = {place:?}: name a folder below that of the file, such as \"keys\"",
        file.display()
    )]
    KeysPlace {
        /// The file.
        file: PathBuf,
        /// The place.
        place: String,
    },
    /// The router listens on this machine only.
    #[error(
        "camera {camera}: hosts cannot reach the router at {router}; name its address with --router, or write {}",
        file.display()
    )]
    LocalRouter {
        /// The camera.
        camera: CameraId,
        /// The router's endpoint.
        router: String,
        /// The configuration that would name another one.
        file: PathBuf,
    },
    /// The authority has no keys of a camera.
    #[error("camera {0} has no keys; make them with `sextant keys add DIR {0} --role camera`")]
    NoKeys(CameraId),
    /// A folder without packages.
    #[error(
        "{}: no packages of camera nodes; `cargo xtask package` makes them, --packages names their folder",
        folder.display()
    )]
    NoPackages {
        /// The folder.
        folder: PathBuf,
        /// The system's reason, if it cannot be read.
        source: Option<io::Error>,
    },
    /// The system refuses a file.
    #[error("{}: {cause}", path.display())]
    System {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        cause: io::Error,
    },
    /// The archive for a host cannot be made.
    #[error("tar: {0}")]
    Archive(String),
}

impl FleetError {
    /// For `map_err`: an error of the system with `path`.
    pub(crate) fn system(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |cause| Self::System { path, cause }
    }
}
