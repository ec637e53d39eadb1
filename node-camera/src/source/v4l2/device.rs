//! The calls on an open video device, safe to make.

use std::ffi::{c_int, c_ulong};
use std::fmt;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use sextant_process::Exit;

use super::abi::{self, Capability, Control, Format, FormatUnion, PixFormat, Plain, StreamParm};
use super::{SourceError, device_error};

/// An open device that can capture.
#[derive(Debug)]
pub(super) struct Device {
    path: PathBuf,
    file: File,
    card: String,
}

/// How the pixels lie in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) fourcc: u32,
    pub(super) stride: usize,
}

impl Device {
    /// Opens a device and makes sure that it is a camera that streams.
    pub(super) fn open(path: &Path) -> Result<Self, SourceError> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(path)
            .map_err(|cause| device_error(path, "cannot be opened", &cause))?;
        let mut device = Self {
            path: path.to_owned(),
            file,
            card: String::new(),
        };
        let mut about: Capability = abi::zeroed();
        device
            .call(abi::QUERYCAP, &mut about)
            .map_err(|cause| device.error("cannot be asked what it is", &cause))?;
        device.card = text(&about.card);
        device.check_abilities(&about)?;
        Ok(device)
    }

    fn check_abilities(&self, about: &Capability) -> Result<(), SourceError> {
        let has_own = about.capabilities & abi::CAP_DEVICE_CAPS != 0;
        let abilities = if has_own {
            about.device_caps
        } else {
            about.capabilities
        };
        if abilities & abi::CAP_VIDEO_CAPTURE == 0 {
            let is_planar = abilities & abi::CAP_VIDEO_CAPTURE_MPLANE != 0;
            let lack = if is_planar {
                "it has multi-planar images only"
            } else {
                "it does not capture video"
            };
            return Err(self.unusable(lack));
        }
        if abilities & abi::CAP_STREAMING == 0 {
            return Err(self.unusable("it does not stream into mapped memory"));
        }
        Ok(())
    }

    /// The camera's own name.
    pub(super) fn card(&self) -> &str {
        &self.card
    }

    /// Asks for a format; the driver answers with the nearest it has.
    pub(super) fn set_format(
        &self,
        width: u32,
        height: u32,
        fourcc: u32,
    ) -> Result<Layout, SourceError> {
        let mut format: Format = abi::zeroed();
        format.kind = abi::CAPTURE;
        let wish = PixFormat {
            width,
            height,
            pixelformat: fourcc,
            field: abi::FIELD_ANY,
            bytesperline: 0,
            sizeimage: 0,
            rest: [0; 6],
        };
        format.fmt = FormatUnion { bytes: [0; 200] };
        format.fmt.pix = wish;
        self.call(abi::S_FMT, &mut format)
            .map_err(|cause| self.error("does not take an image format", &cause))?;
        // SAFETY: the kernel answers for this kind with a pix format; any bytes are valid integers.
        let pix = unsafe { format.fmt.pix };
        Ok(Layout::of(&pix))
    }

    /// Asks for a rate; a driver without a choice keeps its own.
    pub(super) fn set_rate(&self, rate_hz: f64) {
        let mut parameters: StreamParm = abi::zeroed();
        parameters.kind = abi::CAPTURE;
        parameters.numerator = 1000;
        parameters.denominator = (rate_hz * 1000.0).round() as u32;
        match self.call(abi::S_PARM, &mut parameters) {
            Ok(()) if parameters.numerator > 0 => {
                let rate_hz = f64::from(parameters.denominator) / f64::from(parameters.numerator);
                tracing::info!(device = %self.path.display(), rate_hz, "images a second");
            }
            Ok(()) => {}
            Err(cause) => {
                tracing::warn!(device = %self.path.display(), %cause, "the camera keeps its own rate")
            }
        }
    }

    /// Sets a fixed exposure and returns the one that the camera has now, in microseconds; 0 if it does not say.
    pub(super) fn set_exposure_us(&self, exposure_us: u32) -> u32 {
        let ticks = i32::try_from(exposure_us.div_ceil(100)).unwrap_or(i32::MAX);
        let wishes = [
            (abi::CID_EXPOSURE_AUTO, abi::EXPOSURE_MANUAL),
            (abi::CID_EXPOSURE_ABSOLUTE, ticks),
        ];
        for (id, value) in wishes {
            if let Err(cause) = self.call(abi::S_CTRL, &mut Control { id, value }) {
                tracing::warn!(device = %self.path.display(), %cause, "the camera keeps its own exposure");
            }
        }
        let mut exposure = Control {
            id: abi::CID_EXPOSURE_ABSOLUTE,
            value: 0,
        };
        match self.call(abi::G_CTRL, &mut exposure) {
            Ok(()) => u32::try_from(exposure.value)
                .unwrap_or(0)
                .saturating_mul(100),
            Err(_) => 0,
        }
    }

    /// A call of the driver, again when a signal interrupts it.
    pub(super) fn call<T: Plain>(&self, request: c_ulong, argument: &mut T) -> io::Result<()> {
        loop {
            // SAFETY: `argument` is a valid, writable structure of the size and meaning that `request` encodes; the
            // descriptor is open for as long as `self`.
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

    /// A failed call as an error that names the device.
    pub(super) fn error(&self, what: &str, cause: &io::Error) -> SourceError {
        device_error(&self.path, what, cause)
    }

    /// A device that lacks something.
    pub(super) fn unusable(&self, lack: &str) -> SourceError {
        let message = format!(
            "{} ({}) cannot be used: {lack}",
            self.path.display(),
            self.card
        );
        SourceError::new(Exit::Unavailable, message)
    }
}

impl AsFd for Device {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

impl Layout {
    fn of(pix: &PixFormat) -> Self {
        let bytes_a_pixel = if pix.pixelformat == abi::FOURCC_YUYV {
            2
        } else {
            1
        };
        let (width, height) = (pix.width as usize, pix.height as usize);
        let stride = (pix.bytesperline as usize).max(width.saturating_mul(bytes_a_pixel));
        Self {
            width,
            height,
            fourcc: pix.pixelformat,
            stride,
        }
    }

    /// Copies the grey values of a buffer into `pixels`; false when the buffer ends early.
    pub(super) fn copy_luma(&self, buffer: &[u8], pixels: &mut [u8]) -> bool {
        let bytes_a_pixel = if self.fourcc == abi::FOURCC_YUYV {
            2
        } else {
            1
        };
        let used = self.width * bytes_a_pixel;
        if buffer.len() < self.stride * (self.height - 1) + used
            || pixels.len() < self.width * self.height
        {
            return false;
        }
        for (row, out) in buffer
            .chunks(self.stride)
            .zip(pixels.chunks_exact_mut(self.width))
        {
            if bytes_a_pixel == 1 {
                out.copy_from_slice(&row[..self.width]);
            } else {
                out.iter_mut()
                    .zip(row.chunks_exact(2))
                    .for_each(|(grey, luma_chroma)| *grey = luma_chroma[0]);
            }
        }
        true
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = text(&self.fourcc.to_le_bytes());
        write!(f, "{}x{} {name}", self.width, self.height)
    }
}

fn text(bytes: &[u8]) -> String {
    let end = bytes
        .iter()
        .position(|byte| *byte == 0)
        .unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(fourcc: u32, stride: usize) -> Layout {
        Layout {
            width: 2,
            height: 2,
            fourcc,
            stride,
        }
    }

    #[test]
    fn grey_rows_lose_their_padding() {
        let mut pixels = [0; 4];
        assert!(layout(abi::FOURCC_GREY, 3).copy_luma(&[1, 2, 99, 3, 4], &mut pixels));
        assert_eq!(pixels, [1, 2, 3, 4]);
    }

    #[test]
    fn of_yuyv_only_the_luma_is_taken() {
        let mut pixels = [0; 4];
        assert!(
            layout(abi::FOURCC_YUYV, 5).copy_luma(&[1, 99, 2, 99, 99, 3, 99, 4, 99], &mut pixels)
        );
        assert_eq!(pixels, [1, 2, 3, 4]);
    }

    #[test]
    fn a_short_buffer_is_no_image() {
        assert!(!layout(abi::FOURCC_GREY, 3).copy_luma(&[1, 2, 99, 3], &mut [0; 4]));
    }

    #[test]
    fn a_stride_of_zero_is_the_rows_own_length() {
        let pix = PixFormat {
            width: 4,
            height: 2,
            pixelformat: abi::FOURCC_YUYV,
            field: 0,
            bytesperline: 0,
            sizeimage: 0,
            rest: [0; 6],
        };
        assert_eq!(Layout::of(&pix).stride, 8);
        assert_eq!(Layout::of(&pix).to_string(), "4x2 YUYV");
    }
}
