//! The kernel's side: `linux/videodev2.h` as far as a capture needs it, for 32-bit and 64-bit hosts.
//!
//! Times are two C longs: on 64-bit hosts that is the only layout, on 32-bit hosts the one of kernels before 5.6, which
//! newer ones still take (the size within the call's number tells them apart).

use std::ffi::{c_int, c_long, c_ulong};

pub(super) const CAPTURE: u32 = 1;
pub(super) const MEMORY_MMAP: u32 = 1;
pub(super) const FIELD_ANY: u32 = 0;

pub(super) const CAP_VIDEO_CAPTURE: u32 = 0x0000_0001;
pub(super) const CAP_VIDEO_CAPTURE_MPLANE: u32 = 0x0000_1000;
pub(super) const CAP_STREAMING: u32 = 0x0400_0000;
pub(super) const CAP_DEVICE_CAPS: u32 = 0x8000_0000;

pub(super) const FLAG_ERROR: u32 = 0x0000_0040;
pub(super) const FLAG_TIMESTAMP_MASK: u32 = 0x0000_e000;
pub(super) const FLAG_TIMESTAMP_MONOTONIC: u32 = 0x0000_2000;
pub(super) const FLAG_SOURCE_MASK: u32 = 0x0007_0000;
pub(super) const FLAG_SOURCE_START_OF_EXPOSURE: u32 = 0x0001_0000;

pub(super) const CID_EXPOSURE_AUTO: u32 = 0x009a_0901;
pub(super) const CID_EXPOSURE_ABSOLUTE: u32 = 0x009a_0902;
pub(super) const EXPOSURE_MANUAL: i32 = 1;

pub(super) const FOURCC_GREY: u32 = u32::from_le_bytes(*b"GREY");
pub(super) const FOURCC_YUYV: u32 = u32::from_le_bytes(*b"YUYV");

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

/// Some members of the kernel's union hold pointers, so it is aligned like one.
#[repr(C)]
pub(super) union FormatUnion {
    pub(super) pix: PixFormat,
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
    pub(super) numerator: u32,
    pub(super) denominator: u32,
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

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct Time {
    pub(super) seconds: c_long,
    pub(super) microseconds: c_long,
}

#[repr(C)]
pub(super) struct Buffer {
    pub(super) index: u32,
    pub(super) kind: u32,
    pub(super) bytesused: u32,
    pub(super) flags: u32,
    pub(super) field: u32,
    pub(super) timestamp: Time,
    pub(super) timecode: [u32; 4],
    pub(super) sequence: u32,
    pub(super) memory: u32,
    /// Of the union only the offset of a mapped buffer; the rest of the union's bytes on 64-bit hosts follow it.
    pub(super) offset: MappedOffset,
    pub(super) length: u32,
    pub(super) reserved2: u32,
    pub(super) request_fd: u32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub(super) union MappedOffset {
    pub(super) offset: u32,
    pub(super) whole: c_ulong,
}

#[repr(C)]
pub(super) struct Control {
    pub(super) id: u32,
    pub(super) value: i32,
}

/// A wrong size is a wrong call number; said when compiling, so that a check for a board's target says it as well.
const _: () = {
    let is_64_bit = size_of::<c_ulong>() == 8;
    assert!(size_of::<Buffer>() == if is_64_bit { 88 } else { 68 });
    assert!(size_of::<Format>() == if is_64_bit { 208 } else { 204 });
    assert!(size_of::<Capability>() == 104 && size_of::<StreamParm>() == 204);
    assert!(size_of::<RequestBuffers>() == 20 && size_of::<Control>() == 8);
};

const WRITE: c_ulong = 1;
const READ: c_ulong = 2;

/// `_IOC(direction, 'V', number, size)` of the generic ABI, which x86, ARM and RISC-V share.
const fn request<T>(direction: c_ulong, number: c_ulong) -> c_ulong {
    (direction << 30) | ((size_of::<T>() as c_ulong) << 16) | ((b'V' as c_ulong) << 8) | number
}

pub(super) const QUERYCAP: c_ulong = request::<Capability>(READ, 0);
pub(super) const S_FMT: c_ulong = request::<Format>(READ | WRITE, 5);
pub(super) const REQBUFS: c_ulong = request::<RequestBuffers>(READ | WRITE, 8);
pub(super) const QUERYBUF: c_ulong = request::<Buffer>(READ | WRITE, 9);
pub(super) const QBUF: c_ulong = request::<Buffer>(READ | WRITE, 15);
pub(super) const DQBUF: c_ulong = request::<Buffer>(READ | WRITE, 17);
pub(super) const STREAMON: c_ulong = request::<c_int>(WRITE, 18);
pub(super) const STREAMOFF: c_ulong = request::<c_int>(WRITE, 19);
pub(super) const S_PARM: c_ulong = request::<StreamParm>(READ | WRITE, 22);
pub(super) const G_CTRL: c_ulong = request::<Control>(READ | WRITE, 27);
pub(super) const S_CTRL: c_ulong = request::<Control>(READ | WRITE, 28);

/// A structure of zeros, as the kernel wants what it does not know yet.
pub(super) fn zeroed<T: Plain>() -> T {
    // SAFETY: `Plain` is implemented only for structures of integers, which zero bytes are valid for.
    unsafe { std::mem::zeroed() }
}

/// Structures of integers only, that the kernel reads and writes.
///
/// # Safety
/// Any bytes must be a valid value.
pub(super) unsafe trait Plain {}

// SAFETY: integers, and arrays and unions of them.
unsafe impl Plain for Capability {}
// SAFETY: as above.
unsafe impl Plain for Format {}
// SAFETY: as above.
unsafe impl Plain for StreamParm {}
// SAFETY: as above.
unsafe impl Plain for RequestBuffers {}
// SAFETY: as above.
unsafe impl Plain for Buffer {}
// SAFETY: as above.
unsafe impl Plain for Control {}
// SAFETY: an integer.
unsafe impl Plain for c_int {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn sizes_are_the_kernels() {
        assert_eq!(size_of::<Capability>(), 104);
        assert_eq!(size_of::<PixFormat>(), 48);
        assert_eq!(size_of::<StreamParm>(), 204);
        assert_eq!(size_of::<RequestBuffers>(), 20);
        assert_eq!(size_of::<Control>(), 8);
        let (format, buffer) = if cfg!(target_pointer_width = "64") {
            (208, 88)
        } else {
            (204, 68)
        };
        assert_eq!(size_of::<Format>(), format);
        assert_eq!(size_of::<Buffer>(), buffer);
    }

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn fields_lie_where_the_kernel_has_them() {
        assert_eq!(offset_of!(Format, fmt), 8);
        assert_eq!(offset_of!(Buffer, timestamp), 24);
        assert_eq!(offset_of!(Buffer, sequence), 56);
        assert_eq!(offset_of!(Buffer, offset), 64);
        assert_eq!(offset_of!(Buffer, length), 72);
    }

    #[test]
    #[cfg(target_pointer_width = "32")]
    fn fields_lie_where_the_kernel_has_them() {
        assert_eq!(offset_of!(Format, fmt), 4);
        assert_eq!(offset_of!(Buffer, timestamp), 20);
        assert_eq!(offset_of!(Buffer, sequence), 44);
        assert_eq!(offset_of!(Buffer, offset), 52);
        assert_eq!(offset_of!(Buffer, length), 56);
    }

    #[test]
    #[cfg(target_pointer_width = "64")]
    fn call_numbers_are_those_of_videodev2() {
        assert_eq!(QUERYCAP, 0x8068_5600);
        assert_eq!(S_FMT, 0xc0d0_5605);
        assert_eq!(REQBUFS, 0xc014_5608);
        assert_eq!(QUERYBUF, 0xc058_5609);
        assert_eq!(QBUF, 0xc058_560f);
        assert_eq!(DQBUF, 0xc058_5611);
        assert_eq!(STREAMON, 0x4004_5612);
        assert_eq!(STREAMOFF, 0x4004_5613);
        assert_eq!(S_PARM, 0xc0cc_5616);
        assert_eq!(G_CTRL, 0xc008_561b);
        assert_eq!(S_CTRL, 0xc008_561c);
    }

    #[test]
    #[cfg(target_pointer_width = "32")]
    fn call_numbers_are_those_of_kernel_4_19() {
        assert_eq!(S_FMT, 0xc0cc_5605);
        assert_eq!(QUERYBUF, 0xc044_5609);
        assert_eq!(DQBUF, 0xc044_5611);
    }
}
