//! Publisher of images: one process per camera.

use iceoryx2::port::LoanError;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::{DegradationAction, DegradationCause, DegradationInfo};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;

use crate::service::{IMAGES, LOANED, Services};
use crate::{IceoryxOptions, ImageHeader, ImagesError};

/// Publishes the images of one camera.
#[derive(Debug)]
pub struct ImagePublisher {
    ports: Option<Ports>,
    services: Services,
    max_bytes: usize,
}

#[derive(Debug)]
struct Ports {
    images: Publisher<ipc::Service, [u8], ImageHeader>,
    wake_up: Notifier<ipc::Service>,
}

/// Memory for the next image. Dropping it without sending returns it.
#[derive(Debug)]
pub struct BlankImage {
    sample: SampleMut<ipc::Service, [u8], ImageHeader>,
}

impl BlankImage {
    /// Header and pixels, to be written. The pixels initially hold zeros or an earlier image.
    pub fn parts(&mut self) -> (&mut ImageHeader, &mut [u8]) {
        let header: *mut ImageHeader = self.sample.user_header_mut();
        // SAFETY: header and payload of a sample are disjoint memory of the same exclusively borrowed sample.
        let header = unsafe { &mut *header };
        (header, self.sample.payload_mut())
    }
}

impl ImagePublisher {
    /// Opens the publisher of a camera's images of at most `max_bytes` bytes. Resources of a killed predecessor are
    /// removed.
    pub fn open(
        options: &IceoryxOptions,
        camera: &str,
        max_bytes: usize,
    ) -> Result<Self, ImagesError> {
        Self::open_unless(options, camera, max_bytes, &|| false)
    }

    /// As [`Self::open`]; while other processes open or close, waits until `stop` returns true (polled a hundred times
    /// per second).
    ///
    /// # Errors
    /// As [`Self::open`], and [`ImagesError::Abandoned`] after `stop`.
    pub fn open_unless(
        options: &IceoryxOptions,
        camera: &str,
        max_bytes: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<Self, ImagesError> {
        let (services, ports) = Services::open(
            options,
            camera,
            IMAGES.saturating_mul(max_bytes as u64),
            stop,
            |images, wake_up| {
                let images = images
                    .publisher_builder()
                    .initial_max_slice_len(max_bytes.max(1))
                    .allocation_strategy(AllocationStrategy::Static)
                    .max_loaned_samples(LOANED)
                    .backpressure_strategy(BackpressureStrategy::DiscardData)
                    .set_degradation_handler(note_degradation)
                    .create()
                    .map_err(|cause| create_error(camera, cause))?;
                let wake_up = wake_up
                    .notifier_builder()
                    .create()
                    .map_err(|cause| failed(camera, "make its notifier", &cause))?;
                Ok(Ports { images, wake_up })
            },
        )?;
        Ok(Self {
            ports: Some(ports),
            services,
            max_bytes,
        })
    }

    /// Largest image in bytes.
    pub fn max_bytes(&self) -> usize {
        self.max_bytes
    }

    /// Memory of `bytes` bytes for the next image; one at a time.
    pub fn blank(&self, bytes: usize) -> Result<BlankImage, ImagesError> {
        let sample = self
            .ports()?
            .images
            .loan_slice_uninit(bytes)
            .map_err(|cause| self.loan_error(bytes, cause))?;
        // SAFETY: the bytes lie in a shared memory segment that the kernel zeroed when it was made; since then only
        // whole bytes were written there, and every value is a valid u8.
        let sample = unsafe { sample.assume_init() };
        Ok(BlankImage { sample })
    }

    /// Publishes an image to all readers; it replaces an older one that a reader has not taken.
    pub fn send(&self, image: BlankImage) -> Result<(), ImagesError> {
        image
            .sample
            .send()
            .map_err(|cause| failed(&self.services.camera, "lend an image", &cause))?;
        if let Err(cause) = self.ports()?.wake_up.notify() {
            tracing::debug!(%cause, "a reader was not woken");
        }
        Ok(())
    }

    fn ports(&self) -> Result<&Ports, ImagesError> {
        self.ports
            .as_ref()
            .ok_or_else(|| failed(&self.services.camera, "lend an image", &"it is closed"))
    }

    fn loan_error(&self, bytes: usize, cause: LoanError) -> ImagesError {
        let cause = match cause {
            LoanError::ExceedsMaxLoanSize => {
                format!("{bytes} bytes are more than the {} agreed", self.max_bytes)
            }
            other => format!("{other:?}"),
        };
        failed(&self.services.camera, "take a place for an image", &cause)
    }
}

impl Drop for ImagePublisher {
    fn drop(&mut self) {
        self.services.leave(self.ports.take());
    }
}

/// A dead reader keeps its slot until the next opening cleans up; reported once, not for each image.
pub(crate) fn note_degradation(_: DegradationCause, info: &DegradationInfo) -> DegradationAction {
    tracing::trace!(
        reader = info.receiver_port_id,
        "a connection of shared memory is broken"
    );
    DegradationAction::Ignore
}

pub(crate) fn failed(
    camera: &str,
    action: &'static str,
    cause: &dyn std::fmt::Display,
) -> ImagesError {
    ImagesError::Service {
        camera: camera.to_owned(),
        action,
        cause: cause.to_string(),
    }
}

fn create_error(camera: &str, cause: PublisherCreateError) -> ImagesError {
    match cause {
        PublisherCreateError::ExceedsMaxSupportedPublishers => ImagesError::InUse {
            camera: camera.to_owned(),
        },
        cause => failed(camera, "make its publisher", &cause),
    }
}
