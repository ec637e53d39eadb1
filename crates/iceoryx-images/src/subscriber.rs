//! Subscriber of images: up to four per camera.

use std::time::{Duration, Instant};

use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;

use crate::publisher::{failed, note_degradation};
use crate::service::Services;
use crate::{IceoryxOptions, ImageHeader, ImagesError};

/// Reads the images of one camera.
#[derive(Debug)]
pub struct ImageSubscriber {
    ports: Option<Ports>,
    services: Services,
    malformed: u64,
}

#[derive(Debug)]
struct Ports {
    images: Subscriber<ipc::Service, [u8], ImageHeader>,
    wake_up: Listener<ipc::Service>,
}

/// An image in shared memory, on loan: the publisher does not write to it until it is dropped.
#[derive(Debug)]
pub struct LentImage<'a> {
    sample: Sample<ipc::Service, [u8], ImageHeader>,
    /// One image at a time: the loan borrows its subscriber.
    _subscriber: std::marker::PhantomData<&'a mut ImageSubscriber>,
}

impl LentImage<'_> {
    /// The header; it describes an image that fits its pixels.
    pub fn header(&self) -> &ImageHeader {
        self.sample.user_header()
    }

    /// The rows, `stride` bytes apart.
    pub fn pixels(&self) -> &[u8] {
        let pixels = self.sample.payload();
        &pixels[..self.header().bytes().min(pixels.len())]
    }
}

impl ImageSubscriber {
    /// Subscribes to a camera's images. The publisher may start later or restart; it is found
    /// automatically.
    pub fn open(options: &IceoryxOptions, camera: &str) -> Result<Self, ImagesError> {
        Self::open_unless(options, camera, &|| false)
    }

    /// As [`Self::open`]; while other processes open or close, waits until `stop` returns true (polled a hundred times
    /// per second).
    ///
    /// # Errors
    /// As [`Self::open`], and [`ImagesError::Abandoned`] after `stop`.
    pub fn open_unless(
        options: &IceoryxOptions,
        camera: &str,
        stop: &dyn Fn() -> bool,
    ) -> Result<Self, ImagesError> {
        let (services, ports) = Services::open(options, camera, 0, stop, |images, wake_up| {
            let images = images
                .subscriber_builder()
                .set_degradation_handler(note_degradation)
                .create()
                .map_err(|cause| create_error(camera, cause))?;
            let wake_up = wake_up
                .listener_builder()
                .create()
                .map_err(|cause| failed(camera, "make its listener", &cause))?;
            Ok(Ports { images, wake_up })
        })?;
        Ok(Self {
            ports: Some(ports),
            services,
            malformed: 0,
        })
    }

    /// The newest image that this reader has not seen; waits for at most `timeout`.
    pub fn wait(&mut self, timeout: Duration) -> Result<Option<LentImage<'_>>, ImagesError> {
        let deadline = Instant::now() + timeout;
        loop {
            if let Some(sample) = self.newest()? {
                return Ok(Some(LentImage {
                    sample,
                    _subscriber: std::marker::PhantomData,
                }));
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.sleep(left)?;
        }
    }

    /// Number of images whose header did not describe them, due to a faulty publisher.
    pub fn malformed(&self) -> u64 {
        self.malformed
    }

    fn newest(&mut self) -> Result<Option<Sample<ipc::Service, [u8], ImageHeader>>, ImagesError> {
        let images = &self.ports()?.images;
        let receive = || {
            images
                .receive()
                .map_err(|cause| failed(&self.services.camera, "take an image", &cause))
        };
        let mut newest = receive()?;
        // A restarted publisher is a second connection with a buffer of its own.
        while newest.is_some() && images.has_samples().unwrap_or(false) {
            drop(newest.take());
            newest = receive()?;
        }
        if newest
            .as_ref()
            .is_some_and(|sample| !sample.user_header().describes(sample.payload().len()))
        {
            self.malformed += 1;
            newest = None;
        }
        Ok(newest)
    }

    fn sleep(&self, timeout: Duration) -> Result<(), ImagesError> {
        match self.ports()?.wake_up.timed_wait(|_| {}, timeout) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(cause) => Err(failed(&self.services.camera, "wait for an image", &cause)),
        }
    }

    fn ports(&self) -> Result<&Ports, ImagesError> {
        self.ports
            .as_ref()
            .ok_or_else(|| failed(&self.services.camera, "take an image", &"it is closed"))
    }
}

impl Drop for ImageSubscriber {
    fn drop(&mut self) {
        self.services.leave(self.ports.take());
    }
}

fn create_error(camera: &str, cause: SubscriberCreateError) -> ImagesError {
    match cause {
        SubscriberCreateError::ExceedsMaxSupportedSubscribers => ImagesError::Full {
            camera: camera.to_owned(),
        },
        cause => failed(camera, "make its subscriber", &cause),
    }
}
