//! Capture times by this host's clock, with what is known of its error: whether it is disciplined, whether it can be
//! right at all, and whether the time is of the exposure or only of the image's arrival.

use sextant_iceoryx_images::ClockSource;
use sextant_process::clock::is_plausible;
use sextant_process::{ClockQuality, now_ns};

use super::Capture;

/// How often the clock's quality is read, in images.
const QUALITY_PERIOD: u64 = 30;

/// Standard deviation of the time from exposure to arrival where nobody knows it: drivers, compression and networks
/// take from some milliseconds to half a second.
const UNKNOWN_LATENCY_NS: u64 = 200_000_000;
/// The same about a latency that the file gives.
const LATENCY_JITTER_NS: u64 = 10_000_000;

/// What is known of an image before its clock is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Taken {
    pub(super) sequence: u64,
    /// Middle of the exposure by this host's clock, ns since the Unix epoch.
    pub(super) capture_ns: u64,
    pub(super) exposure_ns: u32,
    pub(super) stamped: Stamped,
}

/// Where a capture time comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stamped {
    /// A driver noted it when the image was taken.
    ByDriver,
    /// It is when the image arrived.
    OnArrival,
    /// It is when the image arrived, less the latency that the file gives.
    OnArrivalLessLatency,
}

/// The host's clock, asked how good it is every now and then.
#[derive(Debug, Default)]
pub(super) struct HostClock {
    images: u64,
    quality: Option<ClockQuality>,
}

impl HostClock {
    /// The image with its clock.
    pub(super) fn capture(&mut self, taken: Taken) -> Capture {
        if self.images.is_multiple_of(QUALITY_PERIOD) {
            self.quality = None;
        }
        self.images += 1;
        let quality = *self.quality.get_or_insert_with(ClockQuality::read);
        let (clock, clock_error_ns) = stated(quality, is_plausible(now_ns()), taken.stamped);
        Capture {
            sequence: taken.sequence,
            capture_ns: taken.capture_ns,
            exposure_ns: taken.exposure_ns,
            clock,
            clock_error_ns,
            clock_offset_ns: 0,
        }
    }
}

fn stated(quality: ClockQuality, is_plausible: bool, stamped: Stamped) -> (ClockSource, u64) {
    let latency_ns = match stamped {
        Stamped::ByDriver => 0,
        Stamped::OnArrival => UNKNOWN_LATENCY_NS,
        Stamped::OnArrivalLessLatency => LATENCY_JITTER_NS,
    };
    let source = match stamped {
        // A clock that was never set is not worth a word about what keeps it.
        _ if !is_plausible => ClockSource::Unknown,
        Stamped::OnArrival | Stamped::OnArrivalLessLatency => ClockSource::Arrival,
        Stamped::ByDriver if quality.synchronised => ClockSource::Ntp,
        Stamped::ByDriver => ClockSource::FreeRunning,
    };
    (source, quality.error_ns.saturating_add(latency_ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: ClockQuality = ClockQuality {
        synchronised: true,
        error_ns: 50_000,
    };
    const LOOSE: ClockQuality = ClockQuality {
        synchronised: false,
        error_ns: 16_000_000_000,
    };

    #[test]
    fn a_drivers_stamp_is_as_good_as_the_hosts_clock() {
        assert_eq!(
            stated(GOOD, true, Stamped::ByDriver),
            (ClockSource::Ntp, 50_000)
        );
        let (source, _) = stated(LOOSE, true, Stamped::ByDriver);
        assert_eq!(source, ClockSource::FreeRunning);
    }

    #[test]
    fn a_time_of_arrival_says_so_and_errs_by_its_latency() {
        let (source, error_ns) = stated(GOOD, true, Stamped::OnArrival);
        assert_eq!((source, error_ns), (ClockSource::Arrival, 200_050_000));
        let (_, error_ns) = stated(GOOD, true, Stamped::OnArrivalLessLatency);
        assert_eq!(error_ns, 10_050_000);
    }

    #[test]
    fn a_clock_before_this_software_is_trusted_by_nobody() {
        for stamped in [Stamped::ByDriver, Stamped::OnArrival] {
            assert_eq!(stated(LOOSE, false, stamped).0, ClockSource::Unknown);
        }
    }
}
