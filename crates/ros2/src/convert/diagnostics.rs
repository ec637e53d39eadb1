//! The state of nodes.

use sextant_proto::{CameraStatus, FusionStatus};

use crate::messages::{Byte, DiagnosticStatus, KeyValue};

/// Everything is well.
pub(crate) const OK: Byte = Byte(0);
/// Something needs attention.
pub(crate) const WARN: Byte = Byte(1);
/// Something is wrong.
pub(crate) const ERROR: Byte = Byte(2);
/// Nothing was heard for a while.
pub(crate) const STALE: Byte = Byte(3);

/// State of a camera node: a warning if no image arrived in the last seconds.
#[must_use]
pub fn camera_status(status: &CameraStatus) -> DiagnosticStatus {
    let is_silent = status.rate_hz <= 0.0;
    let message = match status.notices.last() {
        Some(notice) => notice.to_string(),
        None if is_silent => "no images".to_owned(),
        None => format!("{:.1} images/s", status.rate_hz),
    };
    DiagnosticStatus {
        level: if is_silent { WARN } else { OK },
        name: format!("sextant: camera {}", status.camera),
        message,
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
    let faults = status.faults.iter().map(ToString::to_string);
    let notices = status.notices.iter().map(ToString::to_string);
    let findings: Vec<String> = faults.chain(notices).collect();
    let level = match (status.faults.is_empty(), findings.is_empty()) {
        (false, _) => ERROR,
        (true, false) => WARN,
        (true, true) => OK,
    };
    let message = findings.first().cloned();
    let further = findings.iter().skip(1);
    let objects = status.objects.iter().map(|object| {
        value(
            &format!("object {}", object.object),
            format!("{:?}, {:.1} poses/s", object.state, object.rate_hz).to_lowercase(),
        )
    });
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
        level,
        name: format!("sextant: fusion {}", status.node),
        message: message.unwrap_or_else(|| format!("{} objects", status.objects.len())),
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
