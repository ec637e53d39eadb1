//! Buffers that go round: the driver fills them, we read them where they are, and give them back.

use std::io;
use std::time::Duration;

use sextant_process::Shutdown;

use super::device::{Api, Buffer, Device, Wake};

/// Buffers between driver and us: one being filled, one waiting, one being read, one to spare.
const BUFFERS: u32 = 4;

/// A device that streams into mapped buffers.
#[derive(Debug)]
pub(super) struct Stream<D: Device> {
    device: D,
    api: Api,
}

/// A request of a stream that failed: what it was, and why.
#[derive(Debug)]
pub(super) struct StreamError {
    pub(super) what: &'static str,
    pub(super) cause: io::Error,
}

impl<D: Device> Stream<D> {
    /// Maps the buffers and starts the camera.
    pub(super) fn start(device: D, api: Api) -> Result<Self, StreamError> {
        let mut stream = Self { device, api };
        let mapped = stream.device.map_buffers(api, BUFFERS);
        let count = mapped.map_err(failed("has no buffers for us"))?;
        (0..count).try_for_each(|index| stream.give_back(index))?;
        // Few devices have such events; those without stop sending when their source changes.
        if let Err(cause) = stream.device.watch_source() {
            tracing::debug!(%cause, "the driver does not say when its source changes");
        }
        let started = stream.device.start(api);
        started.map_err(failed("does not start"))?;
        Ok(stream)
    }

    pub(super) fn device(&self) -> &D {
        &self.device
    }

    /// Waits for a filled buffer.
    pub(super) fn wait(&self, shutdown: &Shutdown, timeout: Duration) -> Result<Wake, StreamError> {
        let wake = self.device.wait(shutdown, timeout);
        wake.map_err(failed("cannot be waited for"))
    }

    /// The next filled buffer; none when there is none.
    pub(super) fn take(&self) -> Result<Option<Buffer>, StreamError> {
        match self.device.dequeue(self.api) {
            Ok(buffer) => Ok(Some(buffer)),
            Err(cause) if cause.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(cause) => Err(failed("gives no image")(cause)),
        }
    }

    /// Gives a buffer to the driver, to be filled.
    pub(super) fn give_back(&self, index: u32) -> Result<(), StreamError> {
        let queued = self.device.queue(self.api, index);
        queued.map_err(failed("takes no buffer back"))
    }
}

impl<D: Device> Drop for Stream<D> {
    fn drop(&mut self) {
        if let Err(cause) = self.device.stop(self.api) {
            tracing::debug!(%cause, "the camera does not stop");
        }
    }
}

fn failed(what: &'static str) -> impl Fn(io::Error) -> StreamError {
    move |cause| StreamError { what, cause }
}
