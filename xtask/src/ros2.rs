//! What `sextant ros2` publishes, against other people's implementations of the same formats: rosbags, zenoh-ros2-sdk, the zenoh team's
//! Python binding, and ROS 2's own packages where there are wheels for this machine's Python.

use crate::python;
use crate::tools::{root, run};
use sextant_test_needs::note_skip;
use std::fs;

const ORACLES: [&str; 4] = [
    "eclipse-zenoh==1.10.2",
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
const FOLDER: &str = "crates/ros2/golden";

pub fn ros2() -> Result<(), String> {
    let python = installed()?;
    let script = |name: &str| format!("{FOLDER}/{name}");
    run(&python, &[&script("oracle.py"), "check", FOLDER])?;
    let build = ["build", "--release", "--workspace", "--quiet"];
    run("cargo", &[&build[..], &["--bin", "sextant"]].concat())?;
    run(&python, &[&script("live.py"), "target/release/sextant"])
}

/// A Python with the packages, below `target`; made where it is missing.
fn installed() -> Result<String, String> {
    let folder = root().join("target/tools/ros2-1");
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
    let has_ros = run(&python, &[&pip[..], &ROS].concat()).is_ok();
    let lack = if has_ros {
        ""
    } else {
        "there are none for this Python"
    };
    note_lack(lack);
    let noted = fs::write(&finished, lack);
    noted.map_err(|cause| format!("{}: {cause}", finished.display()))?;
    Ok(python)
}

fn note_lack(lack: &str) {
    if !lack.is_empty() {
        note_skip("ROS 2's own packages", lack);
    }
}
