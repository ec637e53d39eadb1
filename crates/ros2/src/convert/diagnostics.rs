//! The state of nodes.

use sextant_proto::{CameraStatus, FusionStatus, HealthLevel};

use crate::messages::{Byte, DiagnosticStatus, KeyValue};

/// Everything is well.
pub(crate) const OK: Byte = level(HealthLevel::Ok);
/// Nothing was heard for a while.
pub(crate) const STALE: Byte = Byte(3);

const fn level(level: HealthLevel) -> Byte {
    Byte(level as u8)
}

/// State of a camera node: a warning if no image arrived in the last seconds.
#[must_use]
pub fn camera_status(status: &CameraStatus) -> DiagnosticStatus {
    let health = status.health();
    DiagnosticStatus {
        level: level(health.level),
        name: format!("sextant: camera {}", status.camera),
        message: health.message,
        hardware_id: status.host.clone(),
        values: vec![
            value("images per second", format!("{:.1}", status.rate_hz)),
            value("images captured", status.captured),
            value("images detected", status.detected),
            value("images dropped", status.dropped),
            value(
                "detection median, ms",
                format!("{:.2}", status.detect_ms[0]),
            ),
            value("detection 99 %, ms", format!("{:.2}", status.detect_ms[1])),
            value("clock error, ns", status.clock.error_ns),
            value("uptime, s", status.uptime_s),
            value("version", &status.version),
        ],
    }
}

/// A fusion node: an error where the site has a fault, a warning where the node has a notice.
#[must_use]
pub fn fusion_status(status: &FusionStatus) -> DiagnosticStatus {
    let health = status.health();
    let further = health.findings.iter().skip(1);
    let objects = status.objects.iter();
    let objects =
        objects.map(|health| value(&format!("object {}", health.object), health.summary()));
    let cameras = status.cameras.iter().map(|camera| {
        value(
            &format!("camera {}", camera.camera),
            format!(
                "{:.1} images/s, {} rejected, {} late, {} gated",
                camera.rate_hz,
                camera.rejected.total(),
                camera.late,
                camera.gated
            ),
        )
    });
    DiagnosticStatus {
        level: level(health.level),
        name: format!("sextant: fusion {}", status.node),
        message: health.message,
        hardware_id: status.node.to_string(),
        values: objects
            .chain(cameras)
            .chain(further.map(|finding| value("finding", finding)))
            .chain([
                value("uptime, s", status.uptime_s),
                value("version", &status.version),
            ])
            .collect(),
    }
}

pub(crate) fn value(key: &str, value: impl ToString) -> KeyValue {
    KeyValue {
        key: key.to_owned(),
        value: value.to_string(),
    }
}
