//! Discovery by Home Assistant (2024.11 and newer): a device for each object, with its position, its state and its
//! events.

use super::MqttOptions;
use serde_json::{Value, json};
use sextant_site_model::ObjectId;

/// Topic and payload that describe an object.
pub(super) fn device(prefix: &str, options: &MqttOptions, object: &ObjectId) -> (String, String) {
    let id = format!("sextant-{}-{object}", options.site);
    let topic = |what: &str| format!("{}/object/{object}/{what}", options.prefix);
    let axis = |name: &str, place: usize| -> Value {
        json!({
            "platform": "sensor",
            "unique_id": format!("{id}_{name}"),
            "name": name,
            "device_class": "distance",
            "state_class": "measurement",
            "unit_of_measurement": "m",
            "value_template": format!("{{{{ value_json.position[{place}] | round(3) }}}}"),
        })
    };
    let payload = json!({
        "device": {
            "identifiers": [id],
            "name": object.as_str(),
            "manufacturer": "Sextant",
            "model": format!("object of the site {}", options.site),
        },
        "origin": { "name": "Sextant", "sw_version": env!("CARGO_PKG_VERSION") },
        "availability_topic": format!("{}/status", options.prefix),
        "state_topic": topic("pose"),
        "components": {
            "x": axis("x", 0),
            "y": axis("y", 1),
            "z": axis("z", 2),
            "state": {
                "platform": "sensor",
                "unique_id": format!("{id}_state"),
                "name": "state",
                "device_class": "enum",
                "options": ["initialising", "tracking", "coasting", "lost"],
                "value_template": "{{ value_json.state }}",
            },
            "event": {
                "platform": "event",
                "unique_id": format!("{id}_event"),
                "name": "event",
                "state_topic": topic("event"),
                "event_types": ["entered", "left", "fell"],
                "value_template":
                    "{{ {'event_type': value_json.event, 'zone': value_json.zone | default(''), \
                     'cause': value_json.cause | default('')} | tojson }}",
            },
        },
    });
    (format!("{prefix}/device/{id}/config"), payload.to_string())
}
