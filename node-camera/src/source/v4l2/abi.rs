//! The kernel's side: `linux/videodev2.h` as far as a capture needs it, for 32-bit and 64-bit hosts.
//!
//! A buffer's time stamp is two C longs on 64-bit hosts. On 32-bit hosts there are two layouts: two 32-bit numbers, of
//! all kernels before 5.6 and of newer ones with `CONFIG_COMPAT_32BIT_TIME`; and two 64-bit numbers, of kernels from
//! 5.6 on. The size within a call's number tells them apart, whatever the C library of this program takes a `time_t`
//! for.

use std::ffi::{c_int, c_long, c_ulong};

pub(super) const CAPTURE: u32 = 1;
pub(super) const CAPTURE_MPLANE: u32 = 9;
pub(super) const MEMORY_MMAP: u32 = 1;
pub(super) const MAX_PLANES: usize = 8;

#[repr(C)]
pub(super) struct Capability {
    pub(super) driver: [u8; 16],
    pub(super) card: [u8; 32],
    pub(super) bus_info: [u8; 32],
    pub(super) version: u32,
    pub(super) capabilities: u32,
    pub(super) device_caps: u32,
    pub(super) reserved: [u32; 3],
}

#[repr(C)]
pub(super) struct FormatDescription {
    pub(super) index: u32,
    pub(super) kind: u32,
    pub(super) flags: u32,
    pub(super) description: [u8; 32],
    pub(super) pixelformat: u32,
    pub(super) mbus_code: u32,
    pub(super) reserved: [u32; 3],
}

/// `numbers` is one size, or the least, the greatest and the step of widths and then of heights.
#[repr(C)]
pub(super) struct FrameSize {
    pub(super) index: u32,
    pub(super) pixelformat: u32,
    pub(super) kind: u32,
    pub(super) numbers: [u32; 6],
    pub(super) reserved: [u32; 2],
}

/// `fractions` of seconds are one interval, or the least, the greatest and the step.
#[repr(C)]
pub(super) struct FrameInterval {
    pub(super) index: u32,
    pub(super) pixelformat: u32,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) kind: u32,
    pub(super) fractions: [[u32; 2]; 3],
    pub(super) reserved: [u32; 2],
}

pub(super) const ENUMERATED_ONE: u32 = 1;

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct PixFormat {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixelformat: u32,
    pub(super) field: u32,
    pub(super) bytesperline: u32,
    pub(super) sizeimage: u32,
    pub(super) rest: [u32; 6],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct PlanesFormat {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixelformat: u32,
    pub(super) field: u32,
    pub(super) colorspace: u32,
    pub(super) planes: [PlaneFormat; MAX_PLANES],
    pub(super) num_planes: u8,
    pub(super) rest: [u8; 11],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct PlaneFormat {
    pub(super) sizeimage: u32,
    pub(super) bytesperline: u32,
    pub(super) reserved: [u16; 6],
}

/// Some members of the kernel's union hold pointers, so it is aligned like one.
#[repr(C)]
pub(super) union FormatUnion {
    pub(super) pix: PixFormat,
    pub(super) planes: PlanesFormat,
    pub(super) bytes: [u8; 200],
    pub(super) align: c_ulong,
}

#[repr(C)]
pub(super) struct Format {
    pub(super) kind: u32,
    pub(super) fmt: FormatUnion,
}

#[repr(C)]
pub(super) struct StreamParm {
    pub(super) kind: u32,
    pub(super) capability: u32,
    pub(super) capturemode: u32,
    pub(super) interval: [u32; 2],
    pub(super) rest: [u8; 184],
}

#[repr(C)]
pub(super) struct RequestBuffers {
    pub(super) count: u32,
    pub(super) kind: u32,
    pub(super) memory: u32,
    pub(super) capabilities: u32,
    pub(super) reserved: u32,
}

/// A buffer with its time stamp in numbers of type `T`: seconds and microseconds.
#[repr(C)]
pub(super) struct Buffer<T> {
    pub(super) index: u32,
    pub(super) kind: u32,
    pub(super) bytesused: u32,
    pub(super) flags: u32,
    pub(super) field: u32,
    pub(super) timestamp: [T; 2],
    pub(super) timecode: [u32; 4],
    pub(super) sequence: u32,
    pub(super) memory: u32,
    pub(super) place: Place,
    pub(super) length: u32,
    pub(super) reserved2: u32,
    pub(super) request_fd: u32,
}

/// Two C longs: the only layout of 64-bit hosts, the old one of 32-bit hosts.
pub(super) type LongBuffer = Buffer<c_long>;
/// Two 64-bit numbers: the new layout of 32-bit hosts.
pub(super) type WideBuffer = Buffer<i64>;

/// Where a buffer's bytes are: an offset to map, or an array of planes.
#[repr(C)]
#[derive(Clone, Copy)]
pub(super) union Place {
    pub(super) offset: u32,
    pub(super) planes: *mut Plane,
    pub(super) whole: c_ulong,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) bytesused: u32,
    pub(super) length: u32,
    /// An offset to map, of the size of a pointer.
    pub(super) place: PlanePlace,
    pub(super) data_offset: u32,
    pub(super) reserved: [u32; 11],
}

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) union PlanePlace {
    pub(super) offset: u32,
    pub(super) whole: c_ulong,
}

#[repr(C)]
pub(super) struct QueryControl {
    pub(super) id: u32,
    pub(super) kind: u32,
    pub(super) name: [u8; 32],
    pub(super) minimum: i32,
    pub(super) maximum: i32,
    pub(super) step: i32,
    pub(super) default: i32,
    pub(super) flags: u32,
    pub(super) reserved: [u32; 2],
}

#[repr(C)]
pub(super) struct QueryMenu {
    pub(super) id: u32,
    pub(super) index: u32,
    /// A name, or a number of 64 bits in its first bytes.
    pub(super) name: [u8; 32],
    pub(super) reserved: u32,
}

#[repr(C)]
pub(super) struct Control {
    pub(super) id: u32,
    pub(super) value: i32,
}

#[repr(C)]
pub(super) struct EventSubscription {
    pub(super) kind: u32,
    pub(super) id: u32,
    pub(super) flags: u32,
    pub(super) reserved: [u32; 5],
}

/// A wrong size is a wrong call number; said when compiling, so that a check for a board's target says it as well.
const _: () = {
    let is_64_bit = size_of::<c_ulong>() == 8;
    let wide_is_aligned = align_of::<i64>() == 8;
    assert!(size_of::<LongBuffer>() == if is_64_bit { 88 } else { 68 });
    assert!(
        size_of::<WideBuffer>()
            == match (is_64_bit, wide_is_aligned) {
                (true, _) => 88,
                (false, true) => 80,
                (false, false) => 76,
            }
    );
    assert!(size_of::<Plane>() == if is_64_bit { 64 } else { 60 });
    assert!(size_of::<Format>() == if is_64_bit { 208 } else { 204 });
    assert!(size_of::<PixFormat>() == 48 && size_of::<PlanesFormat>() == 192);
    assert!(size_of::<Capability>() == 104 && size_of::<StreamParm>() == 204);
    assert!(size_of::<RequestBuffers>() == 20 && size_of::<Control>() == 8);
    assert!(size_of::<FormatDescription>() == 64 && size_of::<EventSubscription>() == 32);
    assert!(size_of::<FrameSize>() == 44 && size_of::<FrameInterval>() == 52);
    assert!(size_of::<QueryControl>() == 68 && size_of::<QueryMenu>() == 44);
};

const WRITE: c_ulong = 1;
const READ: c_ulong = 2;

/// `_IOC(direction, 'V', number, size)` of the generic ABI, which x86, ARM and RISC-V share.
const fn request<T>(direction: c_ulong, number: c_ulong) -> c_ulong {
    (direction << 30) | ((size_of::<T>() as c_ulong) << 16) | ((b'V' as c_ulong) << 8) | number
}

pub(super) const QUERYCAP: c_ulong = request::<Capability>(READ, 0);
pub(super) const ENUM_FMT: c_ulong = request::<FormatDescription>(READ | WRITE, 2);
pub(super) const S_FMT: c_ulong = request::<Format>(READ | WRITE, 5);
pub(super) const REQBUFS: c_ulong = request::<RequestBuffers>(READ | WRITE, 8);
pub(super) const STREAMON: c_ulong = request::<c_int>(WRITE, 18);
pub(super) const STREAMOFF: c_ulong = request::<c_int>(WRITE, 19);
pub(super) const S_PARM: c_ulong = request::<StreamParm>(READ | WRITE, 22);
pub(super) const G_CTRL: c_ulong = request::<Control>(READ | WRITE, 27);
pub(super) const S_CTRL: c_ulong = request::<Control>(READ | WRITE, 28);
pub(super) const QUERYCTRL: c_ulong = request::<QueryControl>(READ | WRITE, 36);
pub(super) const QUERYMENU: c_ulong = request::<QueryMenu>(READ | WRITE, 37);
pub(super) const ENUM_FRAMESIZES: c_ulong = request::<FrameSize>(READ | WRITE, 74);
pub(super) const ENUM_FRAMEINTERVALS: c_ulong = request::<FrameInterval>(READ | WRITE, 75);
pub(super) const SUBSCRIBE_EVENT: c_ulong = request::<EventSubscription>(WRITE, 90);

/// The calls that take a buffer; their numbers depend on its layout.
#[derive(Debug, Clone, Copy)]
pub(super) enum BufferCall {
    Query,
    Queue,
    Dequeue,
}

impl BufferCall {
    pub(super) const fn request<T>(self) -> c_ulong {
        let number = match self {
            Self::Query => 9,
            Self::Queue => 15,
            Self::Dequeue => 17,
        };
        request::<Buffer<T>>(READ | WRITE, number)
    }
}

/// A structure of zeros, as the kernel wants what it does not know yet.
pub(super) fn zeroed<T: Plain>() -> T {
    // SAFETY: `Plain` is implemented only for structures that zero bytes are valid for.
    unsafe { std::mem::zeroed() }
}

/// Structures that the kernel reads and writes.
///
/// # Safety
/// Any bytes must be a valid value.
pub(super) unsafe trait Plain {}

// SAFETY: integers, and arrays and unions of them.
unsafe impl Plain for Capability {}
// SAFETY: as above.
unsafe impl Plain for FormatDescription {}
// SAFETY: as above.
unsafe impl Plain for FrameSize {}
// SAFETY: as above.
unsafe impl Plain for FrameInterval {}
// SAFETY: as above.
unsafe impl Plain for Format {}
// SAFETY: as above.
unsafe impl Plain for StreamParm {}
// SAFETY: as above.
unsafe impl Plain for RequestBuffers {}
// SAFETY: as above; a raw pointer may have any bits, only following it is unsafe.
unsafe impl<T: Integer> Plain for Buffer<T> {}
// SAFETY: integers, and arrays and unions of them.
unsafe impl Plain for Plane {}
// SAFETY: as above.
unsafe impl Plain for QueryControl {}
// SAFETY: as above.
unsafe impl Plain for QueryMenu {}
// SAFETY: as above.
unsafe impl Plain for Control {}
// SAFETY: as above.
unsafe impl Plain for EventSubscription {}
// SAFETY: an integer.
unsafe impl Plain for c_int {}

/// The numbers of a time stamp.
pub(super) trait Integer: Copy + Into<i64> {}
impl Integer for i32 {}
impl Integer for i64 {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn fields_lie_where_the_kernel_has_them() {
        assert_eq!(offset_of!(Format, fmt), 8);
        assert_eq!(offset_of!(LongBuffer, timestamp), 24);
        assert_eq!(offset_of!(LongBuffer, sequence), 56);
        assert_eq!(offset_of!(LongBuffer, place), 64);
        assert_eq!(offset_of!(LongBuffer, length), 72);
        assert_eq!(offset_of!(Plane, data_offset), 16);
    }

    #[test]
    #[cfg(target_pointer_width = "32")]
    fn fields_lie_where_the_kernel_has_them() {
        assert_eq!(offset_of!(Format, fmt), 4);
        assert_eq!(offset_of!(LongBuffer, timestamp), 20);
        assert_eq!(offset_of!(LongBuffer, sequence), 44);
        assert_eq!(offset_of!(LongBuffer, place), 52);
        assert_eq!(offset_of!(LongBuffer, length), 56);
        assert_eq!(offset_of!(Plane, data_offset), 12);
    }

    #[test]
    fn numbers_of_calls_are_those_of_videodev2() {
        assert_eq!(QUERYCAP, 0x8068_5600);
        assert_eq!(ENUM_FMT, 0xc040_5602);
        assert_eq!(REQBUFS, 0xc014_5608);
        assert_eq!(STREAMON, 0x4004_5612);
        assert_eq!(STREAMOFF, 0x4004_5613);
        assert_eq!(S_PARM, 0xc0cc_5616);
        assert_eq!(G_CTRL, 0xc008_561b);
        assert_eq!(S_CTRL, 0xc008_561c);
        assert_eq!(QUERYCTRL, 0xc044_5624);
        assert_eq!(QUERYMENU, 0xc02c_5625);
        assert_eq!(ENUM_FRAMESIZES, 0xc02c_564a);
        assert_eq!(ENUM_FRAMEINTERVALS, 0xc034_564b);
        assert_eq!(SUBSCRIBE_EVENT, 0x4020_565a);
    }

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn numbers_of_buffers_calls_are_those_of_64_bit_hosts() {
        assert_eq!(S_FMT, 0xc0d0_5605);
        assert_eq!(BufferCall::Query.request::<c_long>(), 0xc058_5609);
        assert_eq!(BufferCall::Queue.request::<c_long>(), 0xc058_560f);
        assert_eq!(BufferCall::Dequeue.request::<c_long>(), 0xc058_5611);
    }

    #[test]
    #[cfg(target_arch = "arm")]
    fn numbers_of_buffers_calls_are_those_of_kernel_4_19_and_of_newer_ones() {
        assert_eq!(S_FMT, 0xc0cc_5605);
        assert_eq!(BufferCall::Query.request::<c_long>(), 0xc044_5609);
        assert_eq!(BufferCall::Dequeue.request::<c_long>(), 0xc044_5611);
        assert_eq!(BufferCall::Query.request::<i64>(), 0xc050_5609);
        assert_eq!(BufferCall::Dequeue.request::<i64>(), 0xc050_5611);
    }
}
