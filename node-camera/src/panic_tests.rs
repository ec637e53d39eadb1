//! Every thread of this node panics, each in a process of its own: the process ends and says so.

use crate::{CameraArguments, CameraNodeConfig, Part, SourceConfig, run};
use sextant_iceoryx_images::{IceoryxOptions, remove_dead};
use sextant_process::children::ChildProcess;
use sextant_process::{Exit, Shutdown, panics};
use sextant_proto::SiteId;
use sextant_simulator::Scenario;
use sextant_site_files::write_toml;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::BusOptions;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Names the configuration in a process that shall be the node.
const CONFIG: &str = "SEXTANT_TEST_NODE";
const PATIENCE: Duration = Duration::from_secs(60);
const PART: &str = "SEXTANT_TEST_PART";

/// Not a test but the node, when this binary is run again for one.
#[test]
fn the_node_itself() {
    let Some(config) = std::env::var_os(CONFIG) else {
        return;
    };
    panics::end_the_process();
    let is_capture = std::env::var_os(PART).is_some_and(|part| part == "capture");
    let arguments = CameraArguments {
        config: config.into(),
        part: Some(if is_capture {
            Part::Capture
        } else {
            Part::Detect
        }),
    };
    run(&arguments, &[], &Shutdown::install().unwrap()).unwrap();
}

/// Removes what a process that panicked left in shared memory.
struct SharedMemory(IceoryxOptions);

impl Drop for SharedMemory {
    fn drop(&mut self) {
        let _ = remove_dead(&self.0);
    }
}

/// A simulated camera; the detecting part is its own router.
fn config(folder: &Path) -> CameraNodeConfig {
    let scenario = Scenario::demo(1, 2, 1);
    write_toml(&folder.join("scenario.toml"), &scenario).unwrap();
    let shared_memory = IceoryxOptions {
        root: folder.join("i"),
        prefix: format!("sxp{}", std::process::id()),
    };
    CameraNodeConfig::new(
        SiteId::new("test").unwrap(),
        CameraId::new(&scenario.cameras[0].id).unwrap(),
        SourceConfig::simulator("scenario.toml"),
        BusOptions::router_on("tcp/127.0.0.1:0"),
        shared_memory,
    )
}

#[test]
fn a_panic_of_any_thread_ends_its_part() {
    for (part, place) in [
        (Part::Capture, "capture"),
        (Part::Detect, "detect"),
        (Part::Detect, "preview"),
    ] {
        let folder = tempfile::tempdir_in("/tmp").unwrap();
        let file = folder.path().join("camera.toml");
        let config = config(folder.path());
        write_toml(&file, &config).unwrap();
        let _shared_memory = SharedMemory(config.shared_memory.clone());
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["panic_tests::the_node_itself", "--exact", "--nocapture"])
            .env(CONFIG, file)
            .env(PART, part.name())
            .env("SEXTANT_TEST_PANIC", place)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut node = ChildProcess::spawn(place, &mut command).unwrap();
        let status = node.wait_until(Instant::now() + PATIENCE).unwrap();
        let mut words = String::new();
        let mut stderr = node.child_mut().stderr.take().unwrap();
        stderr.read_to_string(&mut words).unwrap();
        let code = status.expect("the part went on").code();
        assert_eq!(code, Some(Exit::Panic as i32), "{place}: {words}");
        assert!(
            words.contains(&format!("process ends: the fail point {place}")),
            "{words}"
        );
    }
}
