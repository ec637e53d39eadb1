//! `sextant convert --ros2`: the folder that `ros2 bag` expects, and what is refused. What other tools read of it:
//! `cargo xtask ros2`.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, refused, sextant, stderr, stdout};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Output;

fn convert<S: AsRef<OsStr>>(from: &Path, to: &Path, more: &[S]) -> Output {
    let mut command = sextant();
    command.args(["--json", "convert"]).arg(from).arg(to);
    command.args(more).output().unwrap()
}

/// An MCAP file of a recording with pictures.
fn mcap(recording: &Recording) -> std::path::PathBuf {
    let file = recording.path("site.mcap");
    let [rig, object] = ["rig.toml", "object.toml"].map(|name| recording.path(name));
    let models = ["--rig".as_ref(), rig.as_os_str(), "--object".as_ref()];
    let models = [&models[..], &[object.as_os_str()]].concat();
    let output = convert(recording.root(), &file, &models);
    assert!(output.status.success(), "{}", stderr(&output));
    file
}

#[test]
fn a_recording_becomes_a_bag_with_models_and_images() {
    let recording = Recording::new(3);
    let (file, bag) = (mcap(&recording), recording.path("bag"));
    let output = convert(&file, &bag, &["--ros2"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let line: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let camera = recording.camera(0).replace('-', "_");
    let images = format!("/sextant/camera/{camera}/image/compressed");
    assert_eq!(line["topics"][&images], 3, "{line}");
    // With the rig, and with the object.
    assert_eq!(line["topics"]["/tf_static"], 2, "{line}");
    let left_out: Vec<u64> = line["left_out"]
        .as_object()
        .unwrap()
        .values()
        .map(|n| n.as_u64().unwrap())
        .collect();
    assert_eq!(left_out, [0; 4], "{line}");
    let metadata = fs::read_to_string(bag.join("metadata.yaml")).unwrap();
    for expected in [
        "  version: 5\n  storage_identifier: mcap\n",
        "  relative_file_paths:\n    - \"bag_0.mcap\"\n",
        &format!("        name: {images}\n        type: sensor_msgs/msg/CompressedImage\n"),
        &format!("  message_count: {}\n", line["messages"]),
    ] {
        assert!(metadata.contains(expected), "{metadata}\n{expected}");
    }
    let of_topic = |name: &str| {
        let (_, after) = metadata
            .split_once(&format!("        name: {name}\n"))
            .unwrap();
        after.lines().nth(2).unwrap().trim().to_owned()
    };
    for (name, depth, reliability, durability) in [("/tf_static", 1, 1, 1), (&images, 5, 2, 2)] {
        let profile = format!(
            "- history: 1\\n  depth: {depth}\\n  reliability: {reliability}\\n  durability: {durability}\\n"
        );
        assert!(
            of_topic(name).contains(&profile),
            "{name}: {}",
            of_topic(name)
        );
    }
    let file = fs::read(bag.join("bag_0.mcap")).unwrap();
    assert!(file.starts_with(b"\x89MCAP0\r\n"));
    refused(
        &convert(&recording.path("site.mcap"), &bag, &["--ros2"]),
        3,
        "give a new one",
    );
}

#[test]
fn what_makes_no_bag_is_refused_and_leaves_nothing() {
    let recording = Recording::new(1);
    let (file, bag) = (mcap(&recording), recording.path("bag"));
    let cut = recording.path("cut.mcap");
    fs::write(&cut, &fs::read(&file).unwrap()[..20]).unwrap();
    let none: [&str; 1] = ["--ros2"];
    let text = recording.path("rig.toml");
    for (from, to, more, code, expected) in [
        (
            recording.root(),
            &bag,
            &none[..],
            2,
            "write an MCAP file first",
        ),
        (
            &file,
            &recording.path("b.mcap"),
            &none,
            2,
            "a bag of ROS 2 is a folder",
        ),
        (&text, &bag, &none, 3, "this is not an MCAP file"),
        (&cut, &bag, &none, 3, "copy or save it again"),
        (
            &file,
            &bag,
            &["--ros2", "--to", "ros"],
            2,
            "cannot be used with",
        ),
        (
            &file,
            &bag,
            &["--ros2", "--rig", "rig.toml"],
            2,
            "cannot be used with",
        ),
    ] {
        refused(&convert(from, to, more), code, expected);
        assert!(!to.exists(), "{}", to.display());
    }
    let alone = sextant().arg("convert").arg(&file).arg("--ros2").output();
    refused(&alone.unwrap(), 2, "required");
}
