//! The units of deploy/systemd run a whole site, each with what systemd would let it see and write: images pass from
//! capture to detection, a rig that is set and an object that a wizard found are kept in files, every main loop feeds
//! its watchdog.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_process::now_ns;
use sextant_proto::{Keys, encode, limits};
use sextant_simulator::Scenario;
use sextant_site_files::{read_rig, write_rig, write_toml};
use sextant_test_needs::UNITS;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Qos};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use system_tests::{
    FIRST_OF_CUBE, PATIENCE, Unit, Workshop, node_camera, prepare_machine, send, sextant,
};

const ROUTER: &str = "tcp/127.0.0.1:7447";
/// That of the router's own unit.
const SECOND_ROUTER: &str = "tcp/127.0.0.1:7448";
const PAGE: &str = "127.0.0.1:8600";
const IN_NAME_SPACES: &str = "SEXTANT_TEST_UNITS";

/// Processes that end with the test.
struct Running(Vec<(Child, UnixDatagram)>);

impl Drop for Running {
    fn drop(&mut self) {
        for (child, _) in &mut self.0 {
            send(child.id(), libc::SIGTERM);
            let _ = child.wait();
        }
    }
}

/// Runs itself again in name spaces of its own, where it may mount and every port is free.
#[test]
fn every_unit_does_its_work_within_its_sandbox() {
    if std::env::var_os(IN_NAME_SPACES).is_some() {
        return the_site();
    }
    if UNITS.is_skipped() {
        return;
    }
    let test = std::env::current_exe().expect("a test has a file");
    let status = Command::new("unshare")
        .args([
            "--user",
            "--map-root-user",
            "--mount",
            "--net",
            "--kill-child",
            "--fork",
        ])
        .arg(test)
        .args(["every_unit_does_its_work_within_its_sandbox", "--nocapture"])
        .env(IN_NAME_SPACES, "1")
        .status()
        .expect("unshare runs: it comes with util-linux");
    assert!(status.success(), "{status}");
}

fn the_site() {
    prepare_machine(&[sextant(), node_camera()]);
    let [fusion, router, viewer, capture, detect] = [
        Unit::read("sextant-fusion", ""),
        Unit::read("sextant-router", ""),
        Unit::read("sextant-viewer", ""),
        Unit::read("sextant-capture@", "north"),
        Unit::read("sextant-detect@", "north"),
    ];
    write_site(&fusion.state(), &viewer.state());
    let mut running = Running(vec![fusion.start()]);
    let bus = Bus::open(&BusOptions::client_of(ROUTER)).expect("the router answers");
    for unit in [&router, &viewer, &capture, &detect] {
        running.0.push(unit.start());
    }
    Bus::open(&BusOptions::client_of(SECOND_ROUTER)).expect("the second router answers");
    images_pass(&bus);
    a_rig_is_kept(&fusion.state());
    an_object_is_kept(&bus, &fusion.state(), &viewer.state());
    everybody_feeds_the_watchdog(&mut running);
}

/// The configurations that `sextant config` prints, with a simulated camera, and with changes kept.
fn write_site(state: &Path, viewer: &Path) {
    let printed = |kind: &str| {
        let output = sextant()
            .args(["config", kind])
            .output()
            .expect("sextant runs");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let fusion = printed("fusion")
        .replace("keep_changes = false", "keep_changes = true")
        .replace("[\"object.toml\"]", "[]");
    let recording = "kind = \"images\"               # a recording in the EuRoC layout: \
        folder/<camera>/data.csv and folder/<camera>/data/*.png\nfolder = \"recording\"\n\
        pace = \"recorded\"             # or \"as-fast-as-possible\"\n\
        repeat = false                # begin anew at the end\n";
    let camera = printed("camera");
    assert!(camera.contains(recording) && fusion.contains("keep_changes = true"));
    let camera = camera.replace(
        recording,
        "kind = \"simulator\"\nscenario = \"scenario.toml\"\n",
    );
    let mut scenario = Scenario::demo(1, 1, 1);
    scenario.cameras[0].id = "north".to_owned();
    write_toml(&state.join("scenario.toml"), &scenario).expect("a file");
    write_rig(&state.join("rig.toml"), &Workshop::default().rig()).expect("a file");
    fs::write(state.join("fusion.toml"), fusion).expect("a file");
    let router = printed("router").replace(ROUTER, SECOND_ROUTER);
    fs::write(state.join("router.toml"), router).expect("a file");
    fs::write(state.join("camera-north.toml"), camera).expect("a file");
    fs::write(viewer.join("viewer.toml"), printed("viewer")).expect("a file");
}

/// From capture through shared memory to detection, and on to the network.
fn images_pass(bus: &Bus) {
    let keys = Keys::new("demo").expect("an id");
    let key = keys.observations(&"north".parse().expect("an id"));
    let observations = bus
        .subscribe(&key, 16, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES)
        .expect("a subscription");
    assert!(
        observations.recv_timeout(PATIENCE).is_some(),
        "no image passes"
    );
}

/// A changed rig is written where the unit may write.
fn a_rig_is_kept(state: &Path) {
    let mut cameras = Workshop::default().rig().cameras().to_vec();
    cameras.truncate(2);
    let changed = sextant_site_model::Rig::new(cameras).expect("a rig");
    let file = tempfile::NamedTempFile::with_suffix(".toml").expect("a temporary file");
    write_rig(file.path(), &changed).expect("a file");
    let output = sextant()
        .args(["config", "set", "rig"])
        .arg(file.path())
        .args(["--site", "demo", "--connect", ROUTER])
        .output()
        .expect("sextant runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let _ = fs::remove_file(file);
    until("the rig is kept", || {
        read_rig(&state.join("rig.toml")).is_ok_and(|kept| kept.cameras().len() == 2)
    });
}

/// A wizard learns the cube; its tags are kept beside viewer.toml, and by the fusion node.
fn an_object_is_kept(bus: &Bus, fusion: &Path, viewer: &Path) {
    let tags: Vec<String> = (0..6)
        .map(|at| format!("{{\"id\":{},\"size_m\":0.048}}", FIRST_OF_CUBE + at))
        .collect();
    let learn = format!(
        "{{\"do\":\"start\",\"wizard\":\"learn\",\"id\":\"cube\",\"cameras\":[\"left\",\"middle\"],\"tags\":[{}]}}",
        tags.join(",")
    );
    until("the bridge has the rig", || {
        wizard(&learn).starts_with("HTTP/1.1 202")
    });
    let keys = Keys::new("demo").expect("an id");
    let mut workshop = Workshop::default();
    let mut step = 0_u64;
    until("the cube is learned", || {
        for _ in 0..60 {
            for image in workshop.observe(step as f64 / 12.0, step, now_ns()) {
                let key = keys.observations(&image.camera);
                let publisher = bus.raw_publisher(&key, Qos::Config).expect("a publisher");
                let payload = encode(&image).expect("a message");
                publisher.put(&payload).expect("the network takes it");
            }
            step += 1;
        }
        wizard("{\"do\":\"solve\"}");
        until("the solve has ended", || {
            !state().contains("\"stage\":\"solving\"")
        });
        state().contains("\"stage\":\"solved\"")
    });
    assert!(wizard("{\"do\":\"keep\"}").starts_with("HTTP/1.1 202"));
    until("the object is kept by both", || {
        [viewer, fusion]
            .iter()
            .all(|folder| holds(folder, "cube.toml"))
    });
}

/// Whether a file of this name lies in a folder or one below it.
fn holds(folder: &Path, name: &str) -> bool {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths = entries.map(|entry| entry.expect("an entry").path());
    paths.any(|path| path.ends_with(name) || path.is_dir() && path.join(name).exists())
}

fn everybody_feeds_the_watchdog(running: &mut Running) {
    for (child, watchdog) in &mut running.0 {
        assert_eq!(child.try_wait().expect("a child"), None);
        watchdog.set_read_timeout(Some(PATIENCE)).expect("a socket");
        let mut bytes = [0; 32];
        let length = watchdog.recv(&mut bytes).expect("a word in time");
        assert_eq!(&bytes[..length], b"WATCHDOG=1");
    }
}

fn wizard(command: &str) -> String {
    request("POST /api/wizard", command)
}

fn state() -> String {
    request("GET /api/state", "")
}

/// What the bridge answers; nothing while nobody listens.
fn request(head: &str, body: &str) -> String {
    let Ok(mut stream) = TcpStream::connect(PAGE) else {
        return String::new();
    };
    let length = body.len();
    let request = format!(
        "{head} HTTP/1.1\r\nHost: {PAGE}\r\nContent-Type: application/json\r\n\
         Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
    );
    stream
        .write_all(request.as_bytes())
        .expect("the bridge reads");
    let mut answer = String::new();
    stream
        .read_to_string(&mut answer)
        .expect("the bridge answers");
    answer
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "never: {what}; {}", state());
        std::thread::sleep(Duration::from_millis(20));
    }
}
