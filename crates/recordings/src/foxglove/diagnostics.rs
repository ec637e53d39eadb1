//! The state of nodes, for the diagnostics panels of viewers: ROS's levels, a sentence, and figures.

use super::{ViewerMessage, json_message, schema::Schema, time};
use serde_json::{Value, json};
use sextant_proto::{CameraStatus, FusionStatus};

/// Topic of all nodes.
pub(super) const TOPIC: &str = "/diagnostics";

const OK: u8 = 0;
const WARN: u8 = 1;
const ERROR: u8 = 2;

struct Diagnosis<'a> {
    level: u8,
    name: String,
    message: String,
    host: &'a str,
    values: Vec<(String, String)>,
}

/// A warning where no image has arrived in the last seconds.
pub(super) fn of_camera(status: &CameraStatus, arrival_ns: u64) -> ViewerMessage {
    let is_silent = status.rate_hz <= 0.0;
    let message = match status.notices.last() {
        Some(notice) => notice.to_string(),
        None if is_silent => "no images".to_owned(),
        None => format!("{:.1} images/s", status.rate_hz),
    };
    let diagnosis = Diagnosis {
        level: if is_silent { WARN } else { OK },
        name: format!("camera {}", status.camera),
        message,
        host: &status.host,
        values: vec![
            ("images/s".to_owned(), format!("{:.1}", status.rate_hz)),
            ("images dropped".to_owned(), status.dropped.to_string()),
            (
                "detection, ms".to_owned(),
                format!("{:.2}", status.detect_ms[0]),
            ),
        ],
    };
    diagnosis.message(arrival_ns)
}

/// An error where the site has a fault, a warning where the node has a notice; all of them as values.
pub(super) fn of_fusion(status: &FusionStatus, arrival_ns: u64) -> ViewerMessage {
    let faults = status.faults.iter().map(ToString::to_string);
    let notices = status.notices.iter().map(ToString::to_string);
    let findings: Vec<String> = faults.chain(notices).collect();
    let objects = status.objects.iter().map(|object| {
        let state = format!("{:?}, {:.1} poses/s", object.state, object.rate_hz);
        (format!("object {}", object.object), state.to_lowercase())
    });
    let further = findings
        .iter()
        .map(|one| ("finding".to_owned(), one.clone()));
    let diagnosis = Diagnosis {
        level: match (status.faults.is_empty(), findings.is_empty()) {
            (false, _) => ERROR,
            (true, false) => WARN,
            (true, true) => OK,
        },
        name: format!("fusion {}", status.node),
        message: findings
            .first()
            .cloned()
            .unwrap_or_else(|| "well".to_owned()),
        host: "",
        values: objects.chain(further).collect(),
    };
    diagnosis.message(arrival_ns)
}

impl Diagnosis<'_> {
    fn message(&self, arrival_ns: u64) -> ViewerMessage {
        let values = self.values.iter();
        let values: Vec<Value> = values
            .map(|(key, value)| json!({ "key": key, "value": value }))
            .collect();
        let status = json!({
            "level": self.level,
            "name": self.name,
            "message": self.message,
            "hardware_id": self.host,
            "values": values,
        });
        let array = json!({
            "header": { "stamp": time(arrival_ns), "frame_id": "" },
            "status": [status],
        });
        json_message(TOPIC.to_owned(), Schema::DiagnosticArray, &array)
    }
}
