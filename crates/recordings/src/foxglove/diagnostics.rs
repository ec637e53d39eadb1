//! The state of nodes, for the diagnostics panels of viewers: ROS's levels, a sentence, and figures.

use super::{ViewerMessage, json_message, schema::Schema, time};
use serde_json::{Value, json};
use sextant_proto::{CameraStatus, FusionStatus, NodeHealth};

/// Topic of all nodes.
pub(super) const TOPIC: &str = "/diagnostics";

struct NodeState<'a> {
    health: NodeHealth,
    name: String,
    host: &'a str,
    values: Vec<(String, String)>,
}

pub(super) fn of_camera(status: &CameraStatus, arrival_ns: u64) -> ViewerMessage {
    let state = NodeState {
        health: status.health(),
        name: format!("camera {}", status.camera),
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
    state.message(arrival_ns)
}

/// Everything that the node reports is among the values.
pub(super) fn of_fusion(status: &FusionStatus, arrival_ns: u64) -> ViewerMessage {
    let health = status.health();
    let objects = status.objects.iter();
    let objects = objects.map(|health| (format!("object {}", health.object), health.summary()));
    let findings = health.findings.iter();
    let findings = findings.map(|finding| ("finding".to_owned(), finding.clone()));
    let state = NodeState {
        name: format!("fusion {}", status.node),
        host: "",
        values: objects.chain(findings).collect(),
        health,
    };
    state.message(arrival_ns)
}

impl NodeState<'_> {
    fn message(&self, arrival_ns: u64) -> ViewerMessage {
        let values = self.values.iter();
        let values: Vec<Value> = values
            .map(|(key, value)| json!({ "key": key, "value": value }))
            .collect();
        let status = json!({
            "level": self.health.level as u8,
            "name": self.name,
            "message": self.health.message,
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
