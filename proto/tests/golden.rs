//! The bytes of the contract, kept: `golden/<message>.bin` is what crosses the network, `.json` what it means.
//!
//! A change here is a change of the contract: the message needs a new kind. `SEXTANT_WRITE_GOLDEN=1` writes the files
//! anew.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod samples;

use serde::Serialize;
use serde_json::Value;
use sextant_proto::{AnyMessage, Message, decode, encode};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs;
use std::path::PathBuf;

fn golden(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("golden")
        .join(name)
}

fn agrees<M: Message + PartialEq + Debug>(name: &str, message: &M) {
    let bytes = encode(message).unwrap();
    let json = serde_json::to_string_pretty(message).unwrap() + "\n";
    let (bytes_file, json_file) = (
        golden(&format!("{name}.bin")),
        golden(&format!("{name}.json")),
    );
    if std::env::var_os("SEXTANT_WRITE_GOLDEN").is_some() {
        fs::write(&bytes_file, &bytes).unwrap();
        fs::write(&json_file, &json).unwrap();
    }
    let kept = fs::read(&bytes_file).unwrap();
    assert_eq!(bytes, kept, "{name}: the bytes of the contract changed");
    assert_eq!(json, fs::read_to_string(&json_file).unwrap(), "{name}");
    assert_eq!(&decode::<M>(&kept).unwrap(), message);
    assert_eq!(&serde_json::from_str::<M>(&json).unwrap(), message);
    said_alike(&kept, message);
}

/// The message of any kind is the message itself.
fn said_alike(bytes: &[u8], message: &impl Serialize) {
    let any = AnyMessage::decode(bytes).unwrap();
    assert_eq!(
        serde_json::to_string(&any).unwrap(),
        serde_json::to_string(message).unwrap()
    );
}

#[test]
fn every_message_is_the_bytes_in_its_file() {
    agrees("observations", &samples::observations());
    agrees("preview", &samples::preview());
    agrees("detection_report", &samples::detection_report());
    agrees("camera_status", &samples::camera_status());
    agrees("camera_settings", &samples::camera_settings());
    agrees("object_pose", &samples::object_pose());
    agrees("object_truth", &samples::object_truth());
    agrees("fusion_status", &samples::fusion_status());
    agrees("rig_config", &samples::rig_config());
    agrees("object_config", &samples::object_config());
    agrees("object_config_rigid", &samples::rigid_object_config());
    agrees("object_links", &samples::object_links());
    agrees("clock_report", &samples::clock_report());
    agrees("config_answer", &samples::config_answer());
    agrees("proposal", &samples::proposal());
    agrees("fusion_inputs", &samples::fusion_inputs());
    agrees("heartbeat", &samples::heartbeat());
}

/// The name of a variant.
fn variant(of: &impl Serialize) -> String {
    match serde_json::to_value(of).unwrap() {
        Value::String(name) => name,
        fields => fields.as_object().unwrap().keys().next().unwrap().clone(),
    }
}

/// The page's tests read this file, so that it calls a fault what nodes do.
#[test]
fn severities_are_those_in_their_file() {
    let (fusion, camera) = (samples::fusion_status(), samples::camera_status());
    let of_fusion = fusion.notices.iter().map(|n| (variant(n), n.severity()));
    let of_camera = camera.notices.iter().map(|n| (variant(n), n.severity()));
    let severities = serde_json::json!({
        "notices": of_fusion.collect::<BTreeMap<_, _>>(),
        "camera_notices": of_camera.collect::<BTreeMap<_, _>>(),
    });
    let json = serde_json::to_string_pretty(&severities).unwrap() + "\n";
    let file = golden("severities.json");
    if std::env::var_os("SEXTANT_WRITE_GOLDEN").is_some() {
        fs::write(&file, &json).unwrap();
    }
    assert_eq!(json, fs::read_to_string(&file).unwrap());
}
