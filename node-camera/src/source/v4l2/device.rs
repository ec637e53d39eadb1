//! What a capture asks of a video device: the requests of Video4Linux in terms of their meaning. [`super::kernel`]
//! makes them of the kernel; tests make them of a fake.

use std::io;
use std::time::Duration;

use sextant_process::Shutdown;

/// An open video device. Each method is one request of `linux/videodev2.h`; errors are the kernel's.
pub(super) trait Device {
    /// What the device is (`VIDIOC_QUERYCAP`).
    fn identity(&self) -> io::Result<Identity>;

    /// The code of the n-th pixel format (`VIDIOC_ENUM_FMT`); `EINVAL` behind the last.
    fn nth_format(&self, api: Api, n: u32) -> io::Result<[u8; 4]>;

    /// The n-th size or range of sizes of a format (`VIDIOC_ENUM_FRAMESIZES`); `EINVAL` behind the last.
    fn nth_size(&self, fourcc: [u8; 4], n: u32) -> io::Result<Sizes>;

    /// The n-th interval between images, or range of such, of a format and size (`VIDIOC_ENUM_FRAMEINTERVALS`).
    fn nth_interval(&self, fourcc: [u8; 4], size: [u32; 2], n: u32) -> io::Result<Intervals>;

    /// Asks for a format; the driver answers with the nearest it has (`VIDIOC_S_FMT`).
    fn set_format(&self, api: Api, fourcc: [u8; 4], size: [u32; 2]) -> io::Result<Format>;

    /// Asks for an interval between images; the driver answers with the one it takes (`VIDIOC_S_PARM`).
    fn set_interval(&self, api: Api, interval: Fraction) -> io::Result<Fraction>;

    /// The first control with a greater number than `after` (`VIDIOC_QUERYCTRL`); `EINVAL` behind the last.
    fn control_after(&self, after: u32) -> io::Result<Control>;

    /// The words of a menu's entry (`VIDIOC_QUERYMENU`); `EINVAL` for one that is not there.
    fn menu_entry(&self, id: u32, index: u32) -> io::Result<String>;

    /// A control's value (`VIDIOC_G_CTRL`).
    fn control(&self, id: u32) -> io::Result<i32>;

    /// Sets a control (`VIDIOC_S_CTRL`).
    fn set_control(&self, id: u32, value: i32) -> io::Result<()>;

    /// Asks to be woken with [`Wake::Changed`] when the source changes (`VIDIOC_SUBSCRIBE_EVENT`).
    fn watch_source(&self) -> io::Result<()>;

    /// Asks for buffers and maps them; returns how many there are (`VIDIOC_REQBUFS`, `VIDIOC_QUERYBUF`, `mmap`).
    fn map_buffers(&mut self, api: Api, count: u32) -> io::Result<u32>;

    /// Hands a buffer to the driver, to be filled (`VIDIOC_QBUF`).
    fn queue(&self, api: Api, index: u32) -> io::Result<()>;

    /// Takes a filled buffer (`VIDIOC_DQBUF`); `EAGAIN` where there is none.
    fn dequeue(&self, api: Api) -> io::Result<Buffer>;

    /// Shows the bytes of a buffer that is ours, of its first plane, to `look`; none for a buffer that is not there.
    fn look_at(&self, buffer: &Buffer, look: &mut dyn FnMut(&[u8]));

    /// Starts to fill buffers (`VIDIOC_STREAMON`).
    fn start(&self, api: Api) -> io::Result<()>;

    /// Stops it (`VIDIOC_STREAMOFF`).
    fn stop(&self, api: Api) -> io::Result<()>;

    /// Waits for a filled buffer, a change, an error, or the wish to stop (`poll`).
    fn wait(&self, shutdown: &Shutdown, timeout: Duration) -> io::Result<Wake>;
}

/// The two interfaces of Video4Linux for capturing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Api {
    /// An image is one range of bytes.
    SinglePlanar,
    /// An image is several, of which the first holds the luma.
    MultiPlanar,
}

/// What a device says that it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Identity {
    pub(super) driver: String,
    /// The camera's own name.
    pub(super) card: String,
    /// The plug.
    pub(super) bus: String,
    /// Abilities of this very device node.
    pub(super) abilities: u32,
}

/// One size, or widths and heights in steps: least, greatest, step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sizes {
    One([u32; 2]),
    Steps { width: [u32; 3], height: [u32; 3] },
}

/// A fraction of a second: numerator and denominator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fraction(pub(super) [u32; 2]);

/// One interval between images, or the least and the greatest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Intervals {
    One(Fraction),
    From { least: Fraction, greatest: Fraction },
}

/// A format as set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Format {
    pub(super) fourcc: [u8; 4],
    pub(super) size: [u32; 2],
    /// Bytes from one row of the first plane to the next; 0 where the driver does not say.
    pub(super) stride: u32,
}

/// A control's kind, as far as it is of use here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ControlKind {
    Integer,
    Boolean,
    Menu,
    /// A button, a text, a class's heading, or the like.
    Other,
}

/// A control and its range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Control {
    pub(super) id: u32,
    pub(super) kind: ControlKind,
    pub(super) title: String,
    pub(super) range: [i32; 2],
    pub(super) step: i32,
    pub(super) default: i32,
    pub(super) flags: u32,
}

/// A filled buffer, ours until it is queued again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Buffer {
    pub(super) index: u32,
    pub(super) flags: u32,
    /// Seconds and microseconds of the clock that the flags name.
    pub(super) timestamp: [i64; 2],
    pub(super) sequence: u32,
    /// Where its image begins and ends within the mapped bytes.
    pub(super) image: [usize; 2],
}

/// Why a wait ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wake {
    /// A filled buffer may be there; or an error, which the next request reports.
    Ready,
    /// Nothing came in time, or the process is to stop.
    Nothing,
    /// The source has other images now.
    Changed,
}

impl Fraction {
    /// Images a second; none for a fraction of nothing.
    pub(super) fn rate_hz(self) -> Option<f64> {
        let [numerator, denominator] = self.0.map(f64::from);
        (numerator > 0.0 && denominator > 0.0).then(|| denominator / numerator)
    }
}
