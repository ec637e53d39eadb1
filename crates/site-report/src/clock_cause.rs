//! Offsets of clocks that have a known cause: the difference of two time scales, an hour of another time zone, a board
//! without a battery.

const MINUTE_S: f64 = 60.0;
const YEAR_S: f64 = 365.25 * 86_400.0;
/// TAI - UTC since 2017.
const TAI_S: f64 = 37.0;
/// GPS time - UTC since 2017.
const GPS_S: f64 = 18.0;
/// From NTP's epoch, 1900, to that of Unix.
const NTP_S: f64 = 2_208_988_800.0;

/// Which mistake makes a clock differ from another one by so many seconds, in words; none where the size names none.
/// Positive: this clock is ahead.
///
/// Time scales differ by whole seconds, which are recognised within 0.2 s; a clock that runs ahead by TAI - UTC is of
/// PTP whose grandmaster does not announce that offset, or whose follower ignores it (IEEE 1588-2019, 7.2.4).
#[must_use]
pub fn clock_cause(offset_s: f64) -> Option<&'static str> {
    let is = |seconds: f64| (offset_s - seconds).abs() < 0.2;
    let size_s = offset_s.abs();
    let zones = size_s / (15.0 * MINUTE_S);
    let is_zone = zones > 1.5 && zones < 57.0 && (zones - zones.round()).abs() * 15.0 < 1.0;
    if is(TAI_S) {
        Some("TAI in place of UTC, PTP without its UTC offset")
    } else if is(-TAI_S) {
        Some("37 s were taken off twice: UTC in place of TAI")
    } else if is(GPS_S) {
        Some("GPS time in place of UTC")
    } else if is(TAI_S - GPS_S) || is(GPS_S - TAI_S) {
        Some("GPS time in place of TAI")
    } else if (size_s - 1.0).abs() < 0.02 {
        Some("a leap second, perhaps")
    } else if is_zone {
        Some("the time of a time zone in place of UTC")
    } else if (size_s - NTP_S).abs() < YEAR_S / 12.0 {
        Some("seconds since 1900 in place of 1970")
    } else if offset_s < -40.0 * YEAR_S {
        Some("it counts from 1970: no battery, and never set")
    } else {
        None
    }
}

/// The cause in brackets, to be put behind the size; nothing where none is known.
pub(crate) fn in_brackets(offset_s: f64) -> String {
    clock_cause(offset_s).map_or(String::new(), |cause| format!(" ({cause})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sizes_have_their_cause_and_others_none() {
        for (offset_s, cause) in [
            (37.03, "TAI"),
            (-36.9, "TAI"),
            (17.95, "GPS"),
            (-19.1, "GPS"),
            (0.99, "leap"),
            (3_600.4, "zone"),
            (-19_801.0, "zone"),
            (20_700.0, "zone"),
            (1_800.5, "zone"),
            (-1.79e9, "1970"),
            (2.208_9e9, "1900"),
        ] {
            let words = clock_cause(offset_s).unwrap_or_default();
            assert!(words.contains(cause), "{offset_s}: {words}");
        }
        for offset_s in [
            0.0,
            0.3,
            5.0,
            36.0,
            -40.0,
            900.0,
            1_500.0,
            4_000.0,
            9e7,
            f64::NAN,
        ] {
            assert_eq!(clock_cause(offset_s), None, "{offset_s}");
        }
    }
}
