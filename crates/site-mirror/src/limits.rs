//! When something is silent, when it is forgotten, and how much is kept: for every program that watches a site.

use sextant_proto::limits::{MAX_CAMERAS, MAX_OBJECTS};

/// Nodes publish a status about this often, ns.
const STATUS_PERIOD_NS: u64 = 1_000_000_000;
/// Messages in a row that have to be missed: one is lost now and then, and a second one while a connection is made
/// again.
pub const MISSED: u64 = 3;

/// A node, camera or object without a message for longer is silent, ns: three statuses were missed. Fusion nodes report
/// a camera without images after the same time.
pub const SILENCE_NS: u64 = MISSED * STATUS_PERIOD_NS;

/// As [`SILENCE_NS`], for messages that come at this rate, Hz: the time of three of them where that is longer. An
/// unknown rate is 0.
#[must_use]
pub fn silence_ns(rate_hz: f64) -> u64 {
    if rate_hz > 0.0 {
        // Saturates for rates next to 0.
        SILENCE_NS.max((MISSED as f64 * 1e9 / rate_hz) as u64)
    } else {
        SILENCE_NS
    }
}

/// What nothing was heard of for so long is forgotten, ns; until then it also keeps its place against new ids.
/// Prometheus takes a series for ended after the same time. Nodes stay as long as their token is alive, cameras and
/// objects as long as a fusion node lists them.
pub const FORGOTTEN_NS: u64 = 300_000_000_000;

/// Most cameras: those of the largest rig.
pub const CAMERAS: usize = MAX_CAMERAS;
/// Most objects: those of the largest fusion node.
pub const OBJECTS: usize = MAX_OBJECTS;
/// Most tags of all objects.
pub const TAGS: usize = 16_384;
/// Most fusion nodes that a mirror keeps.
pub const FUSION_NODES: usize = 64;
/// Most nodes of all kinds.
pub const NODES: usize = 512;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_camera_is_silent_after_three_of_its_images() {
        assert_eq!(silence_ns(30.0), SILENCE_NS);
        assert_eq!(silence_ns(0.1), 30_000_000_000);
        assert_eq!(silence_ns(0.0), SILENCE_NS);
        assert_eq!(silence_ns(f64::NAN), SILENCE_NS);
        assert_eq!(silence_ns(f64::MIN_POSITIVE), u64::MAX);
    }
}
