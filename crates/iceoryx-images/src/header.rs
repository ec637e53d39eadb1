//! Header of each image. Layout `repr(C)`, without hidden padding, equal for all processes of one host; 32-bit and
//! 64-bit processes cannot share images (a restriction of iceoryx2).

use iceoryx2::prelude::ZeroCopySend;

/// The only pixel format so far: one byte a pixel, 0 black.
pub const FORMAT_GREY8: u8 = 0;

/// Header of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ZeroCopySend)]
#[repr(C)]
#[type_name("SextantImageHeader2")]
pub struct ImageHeader {
    /// Start of the publishing process, wire time in ns; distinguishes its runs.
    pub stream: u64,
    /// Number of the image in its stream, from 0; a gap is an image that was not published or not received.
    pub sequence: u64,
    /// Middle of the exposure, ns since the Unix epoch, by the camera's clock.
    pub capture_ns: u64,
    /// When the image was complete in this host's memory, ns since the Unix epoch, by this host's clock.
    pub received_ns: u64,
    /// Estimated error of `capture_ns`, ns, one standard deviation.
    pub clock_error_ns: u64,
    /// The camera's clock minus this host's, ns: 0 unless the clock is simulated or recorded.
    pub clock_offset_ns: i64,
    /// Images delivered by the source so far, including this one.
    pub captured: u64,
    /// Images lost before publication, as far as the source knows.
    pub dropped: u64,
    /// Images computed by the CPU in place of an accelerator since the source was opened.
    pub fallbacks: u64,
    /// Length of the exposure, ns; 0 if unknown.
    pub exposure_ns: u32,
    /// Bytes from one row to the next.
    pub stride: u32,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
    /// [`FORMAT_GREY8`].
    pub format: u8,
    /// [`ClockSource`] as a number.
    pub clock_source: u8,
    /// Keeps the size a multiple of 8 without hidden bytes; 0.
    pub reserved: [u8; 2],
}

/// Reference of the clock of `capture_ns`; the numbers are those of the wire contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ClockSource {
    /// Unknown.
    Unknown = 0,
    /// This host's clock, which nothing disciplines.
    FreeRunning = 1,
    /// This host's clock, disciplined by NTP or similar.
    Ntp = 2,
    /// This host's clock, disciplined by PTP.
    Ptp = 3,
    /// Timestamps of a recording.
    Recorded = 4,
    /// The clock of a simulation.
    Simulated = 5,
    /// This host's clock at the arrival of the image: later than its exposure by an unknown delay.
    Arrival = 6,
}

impl ImageHeader {
    /// The clock source of a number; numbers of a later version are unknown.
    pub fn clock(&self) -> ClockSource {
        match self.clock_source {
            1 => ClockSource::FreeRunning,
            2 => ClockSource::Ntp,
            3 => ClockSource::Ptp,
            4 => ClockSource::Recorded,
            5 => ClockSource::Simulated,
            6 => ClockSource::Arrival,
            _ => ClockSource::Unknown,
        }
    }

    /// Size of the image in bytes: `stride x height`, saturating.
    pub fn bytes(&self) -> usize {
        (self.stride as usize).saturating_mul(usize::from(self.height))
    }

    /// Whether the header describes an image of at most `available` bytes.
    pub fn describes(&self, available: usize) -> bool {
        self.format == FORMAT_GREY8
            && self.width > 0
            && self.height > 0
            && self.stride >= u32::from(self.width)
            && self.bytes() <= available
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> ImageHeader {
        ImageHeader {
            width: 4,
            height: 3,
            stride: 5,
            ..ImageHeader::default()
        }
    }

    #[test]
    fn the_layout_has_no_hidden_bytes() {
        assert_eq!(size_of::<ImageHeader>(), 9 * 8 + 2 * 4 + 2 * 2 + 2 + 2);
        assert_eq!(align_of::<ImageHeader>(), align_of::<u64>());
    }

    #[test]
    fn a_header_describes_an_image_that_fits() {
        assert!(header().describes(15));
        assert!(!header().describes(14));
        assert!(
            !ImageHeader {
                stride: 3,
                ..header()
            }
            .describes(100)
        );
        assert!(
            !ImageHeader {
                width: 0,
                ..header()
            }
            .describes(100)
        );
        assert!(
            !ImageHeader {
                format: 9,
                ..header()
            }
            .describes(100)
        );
    }

    #[test]
    fn the_largest_numbers_do_not_overflow() {
        let header = ImageHeader {
            stride: u32::MAX,
            height: u16::MAX,
            width: 1,
            ..header()
        };
        assert!(!header.describes(1 << 30));
    }
}
