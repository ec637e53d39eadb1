//! The two services of a camera, images and wake-up, with every limit set: iceoryx2's defaults would allocate 34
//! images, these nine.

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::prelude::{ServiceName, SignalHandlingMode, ipc};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::port_factory::{event, publish_subscribe};

use rustix::fs::statvfs;

use crate::domain::{Domain, DomainLock, check_name};
use crate::leftovers::{SHARED_MEMORY, tidy};
use crate::{IceoryxOptions, ImageHeader, ImagesError};

/// Readers of one camera's images: detection, preview and two more (a recorder, a program of the user).
pub const MAX_SUBSCRIBERS: usize = 4;
/// Images queued for one reader: one, replaced by the next, so that a reader always gets the newest.
const BUFFER: usize = 1;
/// Images that one reader can hold.
const BORROWED: usize = 1;
/// Images that can be written at a time.
pub(crate) const LOANED: usize = 1;
/// Processes (and threads with a reader of their own) that can open the service.
const MAX_NODES: usize = 8;
/// Images in the shared memory of a camera.
pub(crate) const IMAGES: u64 = (MAX_SUBSCRIBERS * (BUFFER + BORROWED) + LOANED) as u64;

/// Bookkeeping of one process in shared memory, bytes; it uses less.
const BOOKKEEPING_BYTES: u64 = 256 << 10;

type Images = publish_subscribe::PortFactory<ipc::Service, [u8], ImageHeader>;
type WakeUp = event::PortFactory<ipc::Service>;

/// The open services of a camera. The last one to be dropped removes the folder.
#[derive(Debug)]
pub(crate) struct Services {
    pub(crate) camera: String,
    domain: Domain,
    // Fields are dropped in this order: ports (of the owner), services, node.
    open: Option<OpenServices>,
}

#[derive(Debug)]
struct OpenServices {
    images: Images,
    wake_up: WakeUp,
    _node: Node<ipc::Service>,
}

impl Services {
    /// Opens or creates both services and, still under the lock, lets `ports` create its ports. If leftovers of
    /// dead processes are in the way, removes them and tries again. Waits for the lock until `stop`
    /// returns true. Without room for `needed_bytes` it does not begin: a process that writes to shared memory without
    /// room is killed.
    pub(crate) fn open<P>(
        options: &IceoryxOptions,
        camera: &str,
        needed_bytes: u64,
        stop: &dyn Fn() -> bool,
        ports: impl Fn(&Images, &WakeUp) -> Result<P, ImagesError>,
    ) -> Result<(Self, P), ImagesError> {
        check_name("camera", camera)?;
        let domain = Domain::new(options)?;
        let lock = domain.lock(stop)?;
        check_room(camera, needed_bytes)?;
        let attempt = || {
            let open = OpenServices::new(&domain, camera)?;
            let ports = ports(&open.images, &open.wake_up)?;
            Ok((open, ports))
        };
        let opened = attempt().or_else(|first: ImagesError| {
            let removed = tidy(&domain, &lock);
            tracing::debug!(%first, ?removed, "tidied, and trying again");
            attempt()
        });
        match opened {
            Ok((open, ports)) => Ok((
                Self {
                    camera: camera.to_owned(),
                    domain,
                    open: Some(open),
                },
                ports,
            )),
            Err(error) => {
                tidy(&domain, &lock);
                Err(error)
            }
        }
    }

    /// Drops `ports` and the services under the lock, and cleans up if no process is left. If another process does not
    /// release the lock, the next one to open cleans up.
    pub(crate) fn leave<P>(&mut self, ports: Option<P>) {
        let lock = self.domain.lock_briefly();
        drop(ports);
        drop(self.open.take());
        match lock {
            Ok(lock) => drop(tidy_and_release(&self.domain, lock)),
            Err(cause) => tracing::warn!(%cause, "leaving shared memory untidied"),
        }
    }
}

/// Whether shared memory has room for the bookkeeping of a process and so many bytes more.
fn check_room(camera: &str, needed_bytes: u64) -> Result<(), ImagesError> {
    let Ok(space) = statvfs(SHARED_MEMORY) else {
        return Ok(());
    };
    let free_bytes = space.f_bavail.saturating_mul(space.f_frsize);
    let needed_bytes = needed_bytes.saturating_add(BOOKKEEPING_BYTES);
    // A file system without a bound has no blocks.
    if space.f_blocks == 0 || free_bytes >= needed_bytes {
        return Ok(());
    }
    Err(ImagesError::NoRoom {
        camera: camera.to_owned(),
        needed_kib: needed_bytes.div_ceil(1024),
        free_kib: free_bytes / 1024,
    })
}

fn tidy_and_release(domain: &Domain, lock: DomainLock) -> crate::Leftovers {
    let removed = tidy(domain, &lock);
    drop(lock);
    removed
}

impl OpenServices {
    fn new(domain: &Domain, camera: &str) -> Result<Self, ImagesError> {
        let failed = |action, cause: String| ImagesError::Service {
            camera: camera.to_owned(),
            action,
            cause,
        };
        let node = NodeBuilder::new()
            .config(&domain.config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|cause| failed("join", format!("{cause:?}")))?;
        let name = ServiceName::new(&format!("sextant/camera/{camera}/image"))
            .map_err(|cause| failed("name it", format!("{cause:?}")))?;
        let images = node
            .service_builder(&name)
            .publish_subscribe::<[u8]>()
            .user_header::<ImageHeader>()
            .enable_safe_overflow(true)
            .max_publishers(1)
            .max_subscribers(MAX_SUBSCRIBERS)
            .max_nodes(MAX_NODES)
            .history_size(0)
            .subscriber_max_buffer_size(BUFFER)
            .subscriber_max_borrowed_samples(BORROWED)
            .open_or_create()
            .map_err(|cause| open_error(camera, cause))?;
        let wake_up = node
            .service_builder(&name)
            .event()
            .max_notifiers(1)
            .max_listeners(MAX_SUBSCRIBERS)
            .max_nodes(MAX_NODES)
            .event_id_max_value(0)
            .disable_deadline()
            .disable_notifier_created_event()
            .disable_notifier_dropped_event()
            .disable_notifier_dead_event()
            .open_or_create()
            .map_err(|cause| failed("open its wake-up", format!("{cause:?}")))?;
        Ok(Self {
            images,
            wake_up,
            _node: node,
        })
    }
}

fn open_error(camera: &str, cause: PublishSubscribeOpenOrCreateError) -> ImagesError {
    use PublishSubscribeOpenError as OpenServices;
    let camera = camera.to_owned();
    match cause {
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(
            cause @ (OpenServices::IncompatibleTypes
            | OpenServices::IncompatibleMessagingPattern
            | OpenServices::IncompatibleAttributes
            | OpenServices::IncompatibleOverflowBehavior
            | OpenServices::DoesNotSupportRequestedMinBufferSize
            | OpenServices::DoesNotSupportRequestedMinHistorySize
            | OpenServices::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | OpenServices::DoesNotSupportRequestedAmountOfPublishers
            | OpenServices::DoesNotSupportRequestedAmountOfSubscribers
            | OpenServices::DoesNotSupportRequestedAmountOfNodes),
        ) => ImagesError::Incompatible {
            camera,
            cause: format!("{cause:?}"),
        },
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(
            OpenServices::ExceedsMaxNumberOfNodes,
        ) => ImagesError::Full { camera },
        cause => ImagesError::Service {
            camera,
            action: "open its images",
            cause: format!("{cause:?}"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A service with another header type, as another version might create it.
    fn foreign_service(
        domain: &Domain,
        camera: &str,
    ) -> publish_subscribe::PortFactory<ipc::Service, [u8], u64> {
        let node = NodeBuilder::new()
            .config(&domain.config)
            .create::<ipc::Service>()
            .unwrap();
        let name = ServiceName::new(&format!("sextant/camera/{camera}/image")).unwrap();
        node.service_builder(&name)
            .publish_subscribe::<[u8]>()
            .user_header::<u64>()
            .create()
            .unwrap()
    }

    #[test]
    fn a_service_of_another_version_is_called_incompatible() {
        let folder = tempfile::tempdir_in("/tmp").unwrap();
        let options = IceoryxOptions {
            root: folder.path().join("i"),
            prefix: "sxforeign".into(),
        };
        let domain = Domain::new(&options).unwrap();
        let foreign = foreign_service(&domain, "north");
        let error = crate::ImagePublisher::open(&options, "north", 100).unwrap_err();
        assert!(matches!(error, ImagesError::Incompatible { .. }), "{error}");
        drop(foreign);
        crate::ImagePublisher::open(&options, "north", 100).unwrap();
    }
}
