//! A link that stays open while nothing is answered any more is noticed, so that the node opens a new session.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_site_files::{write_object, write_rig};
use sextant_zenoh_bus::{Bus, BusOptions, ControlProbe, Mode};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::{Duration, Instant};
use system_tests::{FaultProxy, Faults, PATIENCE, Scene, free_port, send, sextant};

/// So long that a dead link is not closed during the test.
const LEASE_MS: u32 = 60_000;
const KEY: &str = "sextant/v1/lab/alive/*/*";

fn seconds(number: u64) -> Duration {
    Duration::from_secs(number)
}

#[test]
fn a_router_that_answers_no_more_is_noticed() {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let open = |mode, options: BusOptions| {
        let options = BusOptions {
            mode,
            lease_ms: LEASE_MS,
            ..options
        };
        Bus::open(&options).expect("a session")
    };
    let _router = open(Mode::Router, BusOptions::router_on(&endpoint));
    let proxy = FaultProxy::start(&endpoint);
    let client = open(Mode::Client, BusOptions::client_of(&proxy.endpoint));
    let start = Instant::now();
    let mut probe = ControlProbe::new(KEY, start);
    assert!(probe.check(&client, start).is_ok());
    // The question of second 10 is answered: at second 20 it is 10 s old.
    assert!(probe.check(&client, start + seconds(10)).is_ok());
    let deadline = Instant::now() + PATIENCE;
    while probe.check(&client, start + seconds(20)).is_err() {
        assert!(Instant::now() < deadline, "never answered");
        std::thread::sleep(Duration::from_millis(10));
    }
    proxy.set(Faults {
        is_frozen: true,
        ..Faults::default()
    });
    assert!(client.is_connected(), "the link seems to be well");
    assert!(probe.check(&client, start + seconds(40)).is_err());
    // Its question stays without an answer.
    std::thread::sleep(seconds(3));
    assert!(probe.check(&client, start + seconds(41)).is_err());
    assert!(client.is_connected());
}

/// A node and what it logs. Dropping it ends it.
struct Node {
    process: Child,
    log: PathBuf,
}

impl Node {
    fn start(folder: &Path, kind: &str, configuration: &str) -> Self {
        let (file, log) = (folder.join(format!("{kind}.toml")), folder.join(kind));
        fs::write(&file, configuration).expect("a file");
        let mut command = sextant();
        command.args([kind, "--config"]).arg(&file);
        command.stderr(File::create(&log).expect("a file"));
        let process = command.spawn().expect("sextant starts");
        Self { process, log }
    }

    fn has_logged(&self, words: &str) -> bool {
        let log = fs::read_to_string(&self.log).expect("its log");
        log.contains(words)
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        if matches!(self.process.try_wait(), Ok(None)) {
            send(self.process.id(), libc::SIGTERM);
        }
        let _ = self.process.wait();
    }
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "not in time: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Whether the page's bridge says that it is connected to the site.
fn is_ready(port: u16) -> bool {
    let Ok(mut stream) = TcpStream::connect(("127.0.0.1", port)) else {
        return false;
    };
    let request =
        format!("GET /readyz HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n");
    let mut answer = String::new();
    stream.write_all(request.as_bytes()).is_ok()
        && stream.read_to_string(&mut answer).is_ok()
        && answer.starts_with("HTTP/1.1 200")
}

/// A fusion node ends, so that it is started again; a viewer bridge, which has clients, opens a new session.
#[test]
fn nodes_whose_router_answers_no_more_get_a_new_session() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let router = BusOptions {
        mode: Mode::Router,
        lease_ms: LEASE_MS,
        ..BusOptions::router_on(&endpoint)
    };
    let _router = Bus::open(&router).expect("a session");
    let proxy = FaultProxy::start(&endpoint);
    let network = format!(
        "[network]\nmode = \"client\"\nconnect = [\"{}\"]\nlease_ms = {LEASE_MS}\n",
        proxy.endpoint
    );
    let port = free_port();
    let viewer = format!("site = \"lab\"\nlisten = \"127.0.0.1:{port}\"\n{network}");
    let mut viewer = Node::start(folder.path(), "viewer", &viewer);
    let scene = Scene::new(1, &["box"]);
    write_rig(&folder.path().join("rig.toml"), &scene.rig).expect("a file");
    write_object(&folder.path().join("box.toml"), &scene.objects[0]).expect("a file");
    let fusion = format!("site = \"lab\"\nrig = \"rig.toml\"\nobjects = [\"box.toml\"]\n{network}");
    let mut fusion = Node::start(folder.path(), "fusion", &fusion);
    until("the bridge is connected", || is_ready(port));
    until("the fusion node runs", || fusion.has_logged("fusing"));
    proxy.set(Faults {
        is_frozen: true,
        ..Faults::default()
    });
    until("the fusion node ends", || {
        fusion.process.try_wait().expect("it was started").is_some()
    });
    let status = fusion.process.wait().expect("it has ended");
    assert_eq!(status.code(), Some(4), "that it is unavailable");
    assert!(fusion.has_logged("a new session is needed"));
    until("the bridge leaves its session", || {
        viewer.has_logged("opening one") && !is_ready(port)
    });
    proxy.set(Faults::default());
    until("the bridge has a session again", || is_ready(port));
    assert!(matches!(viewer.process.try_wait(), Ok(None)), "it goes on");
}
