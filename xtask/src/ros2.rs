//! What `sextant ros2` publishes and what recordings and bags hold, against other people's implementations of the same
//! formats: rosbags, zenoh-ros2-sdk, the zenoh team's Python binding, Foxglove's classes, and ROS 2's own packages and
//! Rerun where there are wheels for this machine's Python.

use crate::python;
use crate::tools::{root, run};
use sextant_test_needs::note_skip;
use std::fs;

const ORACLES: [&str; 7] = [
    "eclipse-zenoh==1.10.2",
    "foxglove-schemas-protobuf==0.4.0",
    "mcap==1.6.0",
    "mcap-protobuf-support==0.6.0",
    "rosbags==0.11.9",
    "xxhash==4.1.0",
    "zenoh-ros2-sdk==0.1.8",
];
/// ROS 2 Kilted; Fast CDR comes with its middleware.
const ROS: [&str; 5] = [
    "ros-rclpy==9.1.2",
    "ros-rmw-fastrtps-cpp==9.3.3",
    "ros-geometry-msgs==5.5.1",
    "ros-sensor-msgs==5.5.1",
    "ros-diagnostic-msgs==5.5.1",
];
const RERUN: [&str; 1] = ["rerun-sdk==0.41.0"];
const FOLDER: &str = "crates/ros2/golden";

pub fn ros2() -> Result<(), String> {
    let python = installed()?;
    let script = |name: &str| format!("{FOLDER}/{name}");
    run(&python, &[&script("oracle.py"), "check", FOLDER])?;
    let build = ["build", "--release", "--workspace", "--quiet"];
    run("cargo", &[&build[..], &["--bin", "sextant"]].concat())?;
    run(&python, &[&script("live.py"), "target/release/sextant"])?;
    run(&python, &[&script("files.py"), "target/release/sextant"])
}

/// A Python with the packages, below `target`; made where it is missing.
fn installed() -> Result<String, String> {
    let folder = root().join("target/tools/ros2-2");
    let python = python::environment(&folder)?;
    let finished = folder.join("finished");
    if let Ok(lack) = fs::read_to_string(&finished) {
        note_lack(&lack);
        return Ok(python);
    }
    println!("xtask: installing {}", ORACLES.join(" "));
    let pip = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ];
    run(&python, &[&pip[..], &ORACLES].concat())?;
    let lacks = |packages: &[&str]| run(&python, &[&pip[..], packages].concat()).is_err();
    let optional = [
        ("ROS 2's own packages", &ROS[..]),
        ("rerun-sdk", &RERUN[..]),
    ];
    let lack = optional.iter().filter(|(_, packages)| lacks(packages));
    let lack: String = lack.map(|(name, _)| format!("{name}\n")).collect();
    note_lack(&lack);
    let noted = fs::write(&finished, lack);
    noted.map_err(|cause| format!("{}: {cause}", finished.display()))?;
    Ok(python)
}

fn note_lack(lack: &str) {
    for packages in lack.lines() {
        note_skip(packages, "there are none for this Python");
    }
}
