//! Errors of shared memory, by who has to act.

use std::path::PathBuf;

/// Errors of publishing and receiving images.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImagesError {
    /// The folder of the shared memory's bookkeeping cannot be used.
    #[error("shared memory folder {}: {cause}", root.display())]
    Root {
        /// The folder.
        root: PathBuf,
        /// Cause and remedy.
        cause: String,
    },
    /// The caller gave up while another process held the folder's lock.
    #[error(
        "shared memory folder {}: gave up waiting while another process held it locked",
        root.display()
    )]
    Abandoned {
        /// The folder.
        root: PathBuf,
    },
    /// A camera id or prefix that cannot be part of a file name.
    #[error("{what} {value:?} cannot name shared memory: use up to 32 of a-z, 0-9, _ and -")]
    Name {
        /// What the value would name.
        what: &'static str,
        /// The offending value.
        value: String,
    },
    /// Shared memory has no room for the camera's images.
    #[error(
        "no room in shared memory for camera {camera}: {needed_kib} KiB needed, {free_kib} KiB free in /dev/shm; \
         remove files there or give it more room"
    )]
    NoRoom {
        /// The camera.
        camera: String,
        /// KiB that are needed.
        needed_kib: u64,
        /// KiB that are free.
        free_kib: u64,
    },
    /// Another process publishes the images of this camera.
    #[error("another process captures camera {camera}; end it first")]
    InUse {
        /// The camera.
        camera: String,
    },
    /// All subscriber slots are taken.
    #[error("camera {camera} has no place for another reader of its images")]
    Full {
        /// The camera.
        camera: String,
    },
    /// The existing service was created by another version or with other settings.
    #[error(
        "the images of camera {camera} are shared by a process of another version or with other settings ({cause}); \
         end all processes of this camera and start them again"
    )]
    Incompatible {
        /// The camera.
        camera: String,
        /// iceoryx2's name for the difference.
        cause: String,
    },
    /// iceoryx2 failed for another reason.
    #[error("shared memory of camera {camera}: cannot {action}: {cause}")]
    Service {
        /// The camera.
        camera: String,
        /// The operation that failed.
        action: &'static str,
        /// iceoryx2's name for the error.
        cause: String,
    },
}
