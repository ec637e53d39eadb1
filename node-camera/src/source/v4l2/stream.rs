//! Buffers that go round: the driver fills them, we read them where they are, and give them back.

use std::ffi::c_int;
use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::ptr::NonNull;
use std::time::Duration;

use sextant_process::Shutdown;

use super::SourceError;
use super::abi::{self, Buffer, RequestBuffers};
use super::device::Device;

/// Buffers between driver and us: one being filled, one waiting, one being read, one to spare.
const BUFFERS: u32 = 4;

/// A device that streams into mapped buffers.
#[derive(Debug)]
pub(super) struct Stream {
    // Before the device: unmapped first.
    buffers: Vec<Mapping>,
    device: Device,
}

/// A filled buffer, ours until it is given back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) index: u32,
    pub(super) sequence: u32,
    pub(super) stamp: Stamp,
}

/// What the driver's time stamp says, ns of the monotonic clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stamp {
    /// The exposure began then.
    StartOfExposure(u64),
    /// The image was all there then.
    EndOfFrame(u64),
    /// Another clock, or none.
    None,
}

#[derive(Debug)]
struct Mapping {
    start: NonNull<u8>,
    length: usize,
}

impl Stream {
    /// Maps the buffers and starts the camera.
    pub(super) fn start(device: Device) -> Result<Self, SourceError> {
        let mut request: RequestBuffers = abi::zeroed();
        (request.count, request.kind, request.memory) = (BUFFERS, abi::CAPTURE, abi::MEMORY_MMAP);
        device
            .call(abi::REQBUFS, &mut request)
            .map_err(|cause| device.error("has no buffers for us", &cause))?;
        let mut stream = Self {
            buffers: Vec::new(),
            device,
        };
        for index in 0..request.count {
            let mapping = stream
                .map(index)
                .map_err(|cause| stream.device.error("cannot share its buffers", &cause))?;
            stream.buffers.push(mapping);
            stream.give_back(index)?;
        }
        let mut kind: c_int = abi::CAPTURE as c_int;
        stream
            .device
            .call(abi::STREAMON, &mut kind)
            .map_err(|cause| stream.device.error("does not start", &cause))?;
        Ok(stream)
    }

    /// Waits until an image is there (true), `timeout` is over or `shutdown` requested (false).
    pub(super) fn wait(&self, shutdown: &Shutdown, timeout: Duration) -> Result<bool, SourceError> {
        let waiting = |fd| libc::pollfd {
            fd,
            events: libc::POLLIN,
            revents: 0,
        };
        let mut polled = [
            waiting(self.device.as_fd().as_raw_fd()),
            waiting(shutdown.as_fd().as_raw_fd()),
        ];
        let timeout_ms = i32::try_from(timeout.as_millis()).unwrap_or(i32::MAX);
        // SAFETY: two valid pollfds, whose descriptors stay open through the borrows.
        let ready = unsafe { libc::poll(polled.as_mut_ptr(), 2, timeout_ms) };
        if ready == -1 {
            let cause = io::Error::last_os_error();
            let is_signal = cause.kind() == io::ErrorKind::Interrupted;
            return if is_signal {
                Ok(false)
            } else {
                Err(self.device.error("cannot be waited for", &cause))
            };
        }
        // An error shows at the next call with its cause.
        Ok(polled[0].revents != 0 && !shutdown.is_requested())
    }

    /// The next filled buffer; none when there is none, or the driver says that its content is broken.
    pub(super) fn take(&self) -> Result<Option<Frame<'_>>, SourceError> {
        let mut buffer = description(0);
        match self.device.call(abi::DQBUF, &mut buffer) {
            Ok(()) => {}
            Err(cause) if cause.kind() == io::ErrorKind::WouldBlock => return Ok(None),
            Err(cause) => return Err(self.device.error("gives no image", &cause)),
        }
        let mapping = self.buffers.get(buffer.index as usize);
        let bytes = mapping.map(|mapping| mapping.bytes(buffer.bytesused as usize));
        match bytes {
            Some(bytes) if buffer.flags & abi::FLAG_ERROR == 0 => {
                let stamp = stamp(&buffer);
                Ok(Some(Frame {
                    bytes,
                    index: buffer.index,
                    sequence: buffer.sequence,
                    stamp,
                }))
            }
            _ => {
                self.give_back(buffer.index)?;
                Ok(None)
            }
        }
    }

    /// Gives a buffer to the driver, to be filled.
    pub(super) fn give_back(&self, index: u32) -> Result<(), SourceError> {
        let mut buffer = description(index);
        self.device
            .call(abi::QBUF, &mut buffer)
            .map_err(|cause| self.device.error("takes no buffer back", &cause))
    }

    fn map(&self, index: u32) -> io::Result<Mapping> {
        let mut buffer = description(index);
        self.device.call(abi::QUERYBUF, &mut buffer)?;
        // SAFETY: for memory-mapped buffers the kernel fills the union's offset; any bytes are a valid integer.
        let offset = unsafe { buffer.offset.offset };
        Mapping::new(&self.device, offset, buffer.length as usize)
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        let mut kind: c_int = abi::CAPTURE as c_int;
        if let Err(cause) = self.device.call(abi::STREAMOFF, &mut kind) {
            tracing::debug!(%cause, "the camera does not stop");
        }
    }
}

impl Mapping {
    fn new(device: &Device, offset: u32, length: usize) -> io::Result<Self> {
        #[allow(
            clippy::unnecessary_fallible_conversions,
            reason = "32 bits on 32-bit boards"
        )]
        let offset = libc::off_t::try_from(offset)
            .map_err(|_| io::Error::from(io::ErrorKind::InvalidData))?;
        let descriptor = device.as_fd().as_raw_fd();
        // SAFETY: a new mapping at an address of the kernel's choice, which the Mapping owns and unmaps once.
        let start = unsafe {
            libc::mmap(
                std::ptr::null_mut(),
                length,
                libc::PROT_READ,
                libc::MAP_SHARED,
                descriptor,
                offset,
            )
        };
        if start == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        let start = NonNull::new(start.cast())
            .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidData))?;
        Ok(Self { start, length })
    }

    fn bytes(&self, used: usize) -> &[u8] {
        // SAFETY: the mapping is readable over its whole length for as long as `self`; the driver does not write to a
        // buffer that we hold.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), used.min(self.length)) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the very mapping that `new` made; nothing borrows from it any more.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.length) };
    }
}

fn description(index: u32) -> Buffer {
    let mut buffer: Buffer = abi::zeroed();
    (buffer.index, buffer.kind, buffer.memory) = (index, abi::CAPTURE, abi::MEMORY_MMAP);
    buffer
}

fn stamp(buffer: &Buffer) -> Stamp {
    if buffer.flags & abi::FLAG_TIMESTAMP_MASK != abi::FLAG_TIMESTAMP_MONOTONIC {
        return Stamp::None;
    }
    let seconds = u64::try_from(buffer.timestamp.seconds).unwrap_or(0);
    let microseconds = u64::try_from(buffer.timestamp.microseconds).unwrap_or(0);
    let ns = seconds
        .saturating_mul(1_000_000_000)
        .saturating_add(microseconds.saturating_mul(1000));
    match buffer.flags & abi::FLAG_SOURCE_MASK {
        abi::FLAG_SOURCE_START_OF_EXPOSURE => Stamp::StartOfExposure(ns),
        _ => Stamp::EndOfFrame(ns),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamped(flags: u32) -> Stamp {
        let mut buffer = description(0);
        (
            buffer.timestamp.seconds,
            buffer.timestamp.microseconds,
            buffer.flags,
        ) = (2, 5, flags);
        stamp(&buffer)
    }

    #[test]
    fn only_the_monotonic_clock_is_believed() {
        assert_eq!(stamped(0), Stamp::None);
        assert_eq!(stamped(0x4000), Stamp::None);
        assert_eq!(stamped(0x2000), Stamp::EndOfFrame(2_000_005_000));
        assert_eq!(
            stamped(0x2000 | 0x10000),
            Stamp::StartOfExposure(2_000_005_000)
        );
    }
}
