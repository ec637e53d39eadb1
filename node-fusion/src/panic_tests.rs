//! Every thread of this node panics, each in a process of its own: the process ends and says so.

use crate::run;
use sextant_process::children::ChildProcess;
use sextant_process::{Exit, Shutdown, logging, panics};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Names the configuration in a process that shall be the node.
const CONFIG: &str = "SEXTANT_TEST_NODE";
const PATIENCE: Duration = Duration::from_secs(60);

/// Not a test but the node, when this binary is run again for one.
#[test]
fn the_node_itself() {
    if let Some(config) = std::env::var_os(CONFIG) {
        panics::end_the_process();
        logging::init("");
        run(Path::new(&config), &Shutdown::install().unwrap()).unwrap();
    }
}

/// A fusion node, its own router, that panics in this place.
fn start(folder: &Path, place: &str) -> ChildProcess {
    let config = folder.join("fusion.toml");
    let text = "site = \"lab\"\nrig = \"rig.toml\"\n[network]\nmode = \"router\"\nlisten = [\"tcp/127.0.0.1:0\"]\n";
    let rig = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\n\
               lens = \
               { model = \"brown-conrady\", fx = 600, fy = 600, cx = 320, cy = 240, distortion = [0, 0, 0, 0, 0] }\n";
    std::fs::write(&config, text).unwrap();
    std::fs::write(folder.join("rig.toml"), rig).unwrap();
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["panic_tests::the_node_itself", "--exact", "--nocapture"])
        .env(CONFIG, config)
        .env("SEXTANT_TEST_PANIC", place)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    ChildProcess::spawn(place, &mut command).unwrap()
}

#[test]
fn a_panic_of_the_loop_ends_the_process() {
    ends_with_a_panic_in("fusion");
}

#[test]
fn a_panic_of_the_adjuster_ends_the_process() {
    ends_with_a_panic_in("adjuster");
}

fn ends_with_a_panic_in(place: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut node = start(folder.path(), place);
    let status = node.wait_until(Instant::now() + PATIENCE).unwrap();
    let mut words = String::new();
    let mut stderr = node.child_mut().stderr.take().unwrap();
    stderr.read_to_string(&mut words).unwrap();
    let code = status.expect("the node went on").code();
    assert_eq!(code, Some(Exit::Panic as i32), "{words}");
    assert!(
        words.contains(&format!("process ends: the fail point {place}")),
        "{words}"
    );
}
