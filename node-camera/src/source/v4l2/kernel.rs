//! The requests as calls of the kernel, on a device's file.

use std::cell::Cell;
use std::ffi::{c_int, c_long, c_ulong};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::ptr::NonNull;
use std::time::Duration;

use sextant_process::Shutdown;

use super::abi::{self, BufferCall, Integer, Plain};
use super::device::{
    Api, Buffer, Control, ControlKind, Device, Format, Fraction, Identity, Intervals, Sizes, Wake,
};

const CAP_DEVICE_CAPS: u32 = 0x8000_0000;
const NEXT_CONTROL: u32 = 0x8000_0000;
const FIELD_ANY: u32 = 0;
const EVENT_SOURCE_CHANGE: u32 = 5;

/// The open file, and its mapped buffers.
#[derive(Debug)]
pub(super) struct KernelDevice {
    // Before the file: unmapped first.
    buffers: Vec<Mapping>,
    file: File,
    /// Whether this kernel takes the 64-bit layout of buffers only.
    is_wide: Cell<bool>,
}

impl KernelDevice {
    /// Opens a device for capturing.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(path)?;
        Ok(Self {
            buffers: Vec::new(),
            file,
            is_wide: Cell::new(false),
        })
    }

    /// A call of the driver, again when a signal interrupts it.
    fn call<T: Plain>(&self, request: c_ulong, argument: &mut T) -> io::Result<()> {
        loop {
            // SAFETY: `argument` is a valid, writable structure of the size and meaning that `request` encodes, and
            // pointers in it point to what the caller keeps alive; the descriptor is open for as long as `self`.
            let result: c_int = unsafe {
                libc::ioctl(
                    self.file.as_raw_fd(),
                    request as _,
                    std::ptr::from_mut(argument),
                )
            };
            if result != -1 {
                return Ok(());
            }
            let cause = io::Error::last_os_error();
            if cause.kind() != io::ErrorKind::Interrupted {
                return Err(cause);
            }
        }
    }

    /// A call that takes a buffer. A 32-bit kernel that was built without the old layout knows only the new one.
    fn buffer_call(&self, call: BufferCall, api: Api, index: u32) -> io::Result<FilledBuffer> {
        if !self.is_wide.get() {
            match self.buffer_call_as::<c_long>(call, api, index) {
                Err(cause)
                    if cause.raw_os_error() == Some(libc::ENOTTY)
                        && size_of::<c_long>() < size_of::<i64>() =>
                {
                    self.is_wide.set(true);
                }
                result => return result,
            }
        }
        self.buffer_call_as::<i64>(call, api, index)
    }

    fn buffer_call_as<T: Integer>(
        &self,
        call: BufferCall,
        api: Api,
        index: u32,
    ) -> io::Result<FilledBuffer> {
        let mut planes: [abi::Plane; abi::MAX_PLANES] = std::array::from_fn(|_| abi::zeroed());
        let mut buffer: abi::Buffer<T> = abi::zeroed();
        (buffer.index, buffer.kind, buffer.memory) = (index, kind(api), abi::MEMORY_MMAP);
        if api == Api::MultiPlanar {
            buffer.place.planes = planes.as_mut_ptr();
            buffer.length = abi::MAX_PLANES as u32;
        }
        self.call(call.request::<T>(), &mut buffer)?;
        let first = &planes[0];
        // SAFETY: for memory-mapped buffers the kernel fills the unions' offsets; any bytes are valid integers.
        let [single_offset, plane_offset] = unsafe { [buffer.place.offset, first.place.offset] };
        let (offset, length, begin, used) = match api {
            Api::SinglePlanar => (single_offset, buffer.length, 0, buffer.bytesused),
            Api::MultiPlanar => (
                plane_offset,
                first.length,
                first.data_offset,
                first.bytesused,
            ),
        };
        Ok(FilledBuffer {
            offset,
            length: length as usize,
            buffer: Buffer {
                index: buffer.index,
                flags: buffer.flags,
                timestamp: buffer.timestamp.map(Into::into),
                sequence: buffer.sequence,
                image: [begin as usize, used as usize],
            },
        })
    }

    fn map(&mut self, api: Api, index: u32) -> io::Result<()> {
        let queried = self.buffer_call(BufferCall::Query, api, index)?;
        let mapping = Mapping::new(&self.file, queried.offset, queried.length)?;
        self.buffers.push(mapping);
        Ok(())
    }
}

/// What a call says of a buffer.
struct FilledBuffer {
    buffer: Buffer,
    /// Where to map its first plane, and how much.
    offset: u32,
    length: usize,
}

impl Device for KernelDevice {
    fn identity(&self) -> io::Result<Identity> {
        let mut about: abi::Capability = abi::zeroed();
        self.call(abi::QUERYCAP, &mut about)?;
        let has_own = about.capabilities & CAP_DEVICE_CAPS != 0;
        Ok(Identity {
            driver: text(&about.driver),
            card: text(&about.card),
            bus: text(&about.bus_info),
            abilities: if has_own {
                about.device_caps
            } else {
                about.capabilities
            },
        })
    }

    fn nth_format(&self, api: Api, n: u32) -> io::Result<[u8; 4]> {
        let mut description: abi::FormatDescription = abi::zeroed();
        (description.index, description.kind) = (n, kind(api));
        self.call(abi::ENUM_FMT, &mut description)?;
        Ok(description.pixelformat.to_le_bytes())
    }

    fn nth_size(&self, fourcc: [u8; 4], n: u32) -> io::Result<Sizes> {
        let mut size: abi::FrameSize = abi::zeroed();
        (size.index, size.pixelformat) = (n, u32::from_le_bytes(fourcc));
        self.call(abi::ENUM_FRAMESIZES, &mut size)?;
        let [a, b, c, d, e, f] = size.numbers;
        Ok(match size.kind {
            abi::ENUMERATED_ONE => Sizes::One([a, b]),
            _ => Sizes::Steps {
                width: [a, b, c],
                height: [d, e, f],
            },
        })
    }

    fn nth_interval(
        &self,
        fourcc: [u8; 4],
        [width, height]: [u32; 2],
        n: u32,
    ) -> io::Result<Intervals> {
        let mut interval: abi::FrameInterval = abi::zeroed();
        (interval.index, interval.pixelformat) = (n, u32::from_le_bytes(fourcc));
        (interval.width, interval.height) = (width, height);
        self.call(abi::ENUM_FRAMEINTERVALS, &mut interval)?;
        let [least, greatest, _] = interval.fractions.map(Fraction);
        Ok(match interval.kind {
            abi::ENUMERATED_ONE => Intervals::One(least),
            _ => Intervals::From { least, greatest },
        })
    }

    fn set_format(
        &self,
        api: Api,
        fourcc: [u8; 4],
        [width, height]: [u32; 2],
    ) -> io::Result<Format> {
        let mut format: abi::Format = abi::zeroed();
        format.kind = kind(api);
        // Size, code and field are the first four numbers of either layout.
        let requested = abi::PixFormat {
            width,
            height,
            pixelformat: u32::from_le_bytes(fourcc),
            field: FIELD_ANY,
            bytesperline: 0,
            sizeimage: 0,
            rest: [0; 6],
        };
        format.fmt.pix = requested;
        self.call(abi::S_FMT, &mut format)?;
        // SAFETY: the kernel answers in the layout of the kind that was asked for; any bytes are valid integers.
        let (pix, planes) = unsafe { (format.fmt.pix, format.fmt.planes) };
        let stride = match api {
            Api::SinglePlanar => pix.bytesperline,
            Api::MultiPlanar => planes.planes[0].bytesperline,
        };
        Ok(Format {
            fourcc: pix.pixelformat.to_le_bytes(),
            size: [pix.width, pix.height],
            stride,
        })
    }

    fn set_interval(&self, api: Api, interval: Fraction) -> io::Result<Fraction> {
        let mut parameters: abi::StreamParm = abi::zeroed();
        (parameters.kind, parameters.interval) = (kind(api), interval.0);
        self.call(abi::S_PARM, &mut parameters)?;
        Ok(Fraction(parameters.interval))
    }

    fn control_after(&self, after: u32) -> io::Result<Control> {
        let mut query: abi::QueryControl = abi::zeroed();
        query.id = after | NEXT_CONTROL;
        self.call(abi::QUERYCTRL, &mut query)?;
        Ok(Control {
            id: query.id,
            kind: match query.kind {
                1 | 9 => ControlKind::Integer,
                2 => ControlKind::Boolean,
                3 => ControlKind::Menu,
                _ => ControlKind::Other,
            },
            title: text(&query.name),
            range: [query.minimum, query.maximum],
            step: query.step,
            default: query.default,
            flags: query.flags,
        })
    }

    fn menu_entry(&self, id: u32, index: u32) -> io::Result<String> {
        let mut query: abi::QueryMenu = abi::zeroed();
        (query.id, query.index) = (id, index);
        self.call(abi::QUERYMENU, &mut query)?;
        Ok(text(&query.name))
    }

    fn control(&self, id: u32) -> io::Result<i32> {
        let mut control = abi::Control { id, value: 0 };
        self.call(abi::G_CTRL, &mut control)?;
        Ok(control.value)
    }

    fn set_control(&self, id: u32, value: i32) -> io::Result<()> {
        self.call(abi::S_CTRL, &mut abi::Control { id, value })
    }

    fn watch_source(&self) -> io::Result<()> {
        let mut subscription: abi::EventSubscription = abi::zeroed();
        subscription.kind = EVENT_SOURCE_CHANGE;
        self.call(abi::SUBSCRIBE_EVENT, &mut subscription)
    }

    fn map_buffers(&mut self, api: Api, count: u32) -> io::Result<u32> {
        let mut request: abi::RequestBuffers = abi::zeroed();
        (request.count, request.kind, request.memory) = (count, kind(api), abi::MEMORY_MMAP);
        self.call(abi::REQBUFS, &mut request)?;
        (0..request.count).try_for_each(|index| self.map(api, index))?;
        Ok(request.count)
    }

    fn queue(&self, api: Api, index: u32) -> io::Result<()> {
        self.buffer_call(BufferCall::Queue, api, index).map(drop)
    }

    fn dequeue(&self, api: Api) -> io::Result<Buffer> {
        Ok(self.buffer_call(BufferCall::Dequeue, api, 0)?.buffer)
    }

    fn look_at(&self, buffer: &Buffer, look: &mut dyn FnMut(&[u8])) {
        let [begin, end] = buffer.image;
        let mapping = self.buffers.get(buffer.index as usize);
        let bytes = mapping.map_or(&[][..], Mapping::bytes);
        let end = end.min(bytes.len());
        look(&bytes[begin.min(end)..end]);
    }

    fn start(&self, api: Api) -> io::Result<()> {
        self.call(abi::STREAMON, &mut (kind(api) as c_int))
    }

    fn stop(&self, api: Api) -> io::Result<()> {
        self.call(abi::STREAMOFF, &mut (kind(api) as c_int))
    }

    fn wait(&self, shutdown: &Shutdown, timeout: Duration) -> io::Result<Wake> {
        let entry = |fd: c_int, events| libc::pollfd {
            fd,
            events,
            revents: 0,
        };
        let mut polled = [
            entry(self.file.as_raw_fd(), libc::POLLIN | libc::POLLPRI),
            entry(shutdown.as_fd().as_raw_fd(), libc::POLLIN),
        ];
        let timeout_ms = i32::try_from(timeout.as_millis()).unwrap_or(i32::MAX);
        // SAFETY: two valid entries, whose descriptors stay open for the whole call.
        if unsafe { libc::poll(polled.as_mut_ptr(), 2, timeout_ms) } == -1 {
            let cause = io::Error::last_os_error();
            return if cause.kind() == io::ErrorKind::Interrupted {
                Ok(Wake::Nothing)
            } else {
                Err(cause)
            };
        }
        Ok(match polled[0].revents {
            _ if shutdown.is_requested() => Wake::Nothing,
            0 => Wake::Nothing,
            events if events & libc::POLLPRI != 0 => Wake::Changed,
            // Also for POLLERR and POLLHUP: the next request says what it is.
            _ => Wake::Ready,
        })
    }
}

/// A buffer's memory.
#[derive(Debug)]
struct Mapping {
    start: NonNull<u8>,
    length: usize,
}

impl Mapping {
    fn new(file: &File, offset: u32, length: usize) -> io::Result<Self> {
        #[allow(
            clippy::unnecessary_fallible_conversions,
            reason = "32 bits on 32-bit boards"
        )]
        let offset = libc::off_t::try_from(offset)
            .map_err(|_| io::Error::from(io::ErrorKind::InvalidData))?;
        // SAFETY: a new mapping at an address of the kernel's choice, which the Mapping owns and unmaps once.
        let start = unsafe {
            libc::mmap(
                std::ptr::null_mut(),
                length,
                libc::PROT_READ,
                libc::MAP_SHARED,
                file.as_raw_fd(),
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

    fn bytes(&self) -> &[u8] {
        // SAFETY: the mapping is readable over its whole length for as long as `self`; the driver does not write to a
        // buffer that we hold.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.length) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the very mapping that `new` made; nothing borrows from it any more.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.length) };
    }
}

fn kind(api: Api) -> u32 {
    match api {
        Api::SinglePlanar => abi::CAPTURE,
        Api::MultiPlanar => abi::CAPTURE_MPLANE,
    }
}

fn text(bytes: &[u8]) -> String {
    let end = bytes
        .iter()
        .position(|byte| *byte == 0)
        .unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
