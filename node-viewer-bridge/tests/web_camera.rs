//! A browser as a camera of the site, played by the test: its name, its messages on the network, and what is refused.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking, its helpers too"
)]

use serde_json::{Value, json};
use sextant_process::{Shutdown, now_ns};
use sextant_proto::{
    ClockQuality, ClockSource, Keys, NodeId, NodeKind, Observations, Timing, encode,
};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::protocol::CloseFrame;
use tungstenite::{Message, WebSocket};

const PATIENCE: Duration = Duration::from_secs(20);
/// How much the browser's clock is ahead.
const AHEAD_NS: u64 = 3_600_000_000_000;

struct Site {
    address: SocketAddr,
    bus: Bus,
    keys: Keys,
    shutdown: Shutdown,
    bridge: Option<JoinHandle<anyhow::Result<()>>>,
    _folder: tempfile::TempDir,
}

impl Site {
    fn open() -> Self {
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("viewer.toml");
        let endpoint = &bus.endpoints()[0];
        let text = format!(
            "site = \"demo\"\nlisten = \"{address}\"\n[network]\nconnect = [\"{endpoint}\"]\n"
        );
        std::fs::write(&file, text).unwrap();
        let shutdown = Shutdown::manual().unwrap();
        let bridge = std::thread::spawn({
            let shutdown = shutdown.clone();
            move || node_viewer_bridge::run(&file, &shutdown)
        });
        Self {
            address,
            bus,
            keys: Keys::new("demo").unwrap(),
            shutdown,
            bridge: Some(bridge),
            _folder: folder,
        }
    }

    fn browser(&self, name: &str, key: &str) -> Browser {
        let deadline = Instant::now() + PATIENCE;
        let stream = loop {
            match TcpStream::connect(self.address) {
                Ok(stream) => break stream,
                Err(cause) => assert!(Instant::now() < deadline, "{cause}"),
            }
            std::thread::yield_now();
        };
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{}/ws/camera?name={name}&key={key}", self.address);
        Browser(tungstenite::client(url, stream).unwrap().0)
    }

    fn is_alive(&self, name: &str) -> bool {
        let id = NodeId::new(name).unwrap();
        let key = self.keys.alive(NodeKind::Camera, &id);
        !self.bus.alive_keys(&key).unwrap().is_empty()
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        self.shutdown.request();
        if let Some(bridge) = self.bridge.take() {
            bridge.join().unwrap().unwrap();
        }
    }
}

struct Browser(WebSocket<TcpStream>);

impl Browser {
    /// The next text of a kind; answers round trips meanwhile.
    fn message(&mut self, kind: &str) -> Value {
        loop {
            let message = self.0.read().unwrap();
            let Message::Text(text) = message else {
                panic!("{message:?}");
            };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["type"] == "ping" {
                let now_us = (now_ns() + AHEAD_NS) / 1000;
                let pong = json!({ "type": "pong", "n": message["n"], "received_us": now_us, "sent_us": now_us });
                self.0.send(pong.to_string().into()).unwrap();
            }
            if message["type"] == kind {
                return message;
            }
        }
    }

    /// Why the bridge ends the connection.
    fn end(&mut self) -> CloseFrame {
        loop {
            if let Message::Close(Some(frame)) = self.0.read().unwrap() {
                return frame;
            }
        }
    }

    fn send(&mut self, camera: &str, capture_ns: u64) {
        let message = Observations {
            camera: CameraId::new(camera).unwrap(),
            sequence: 1,
            capture_ns,
            exposure_ns: 0,
            clock: ClockQuality {
                source: ClockSource::FreeRunning,
                error_ns: 0,
            },
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        };
        let bytes = encode(&message).unwrap();
        self.0.send(bytes.into()).unwrap();
    }
}

fn eventually(condition: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "it does not come about");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_browser_is_published_as_a_camera_while_it_is_connected() {
    let site = Site::open();
    let camera = CameraId::new("pocket").unwrap();
    let key = site.keys.observations(&camera);
    let heard = site
        .bus
        .subscribe(&key, 64, DropRule::Oldest, 100_000)
        .unwrap();
    let mut browser = site.browser("pocket", "a");
    assert_eq!(browser.message("joined")["camera"], "pocket");
    eventually(|| site.is_alive("pocket"));
    while browser.message("report")["clock_error_ms"].is_null() {}
    let taken_ns = now_ns();
    browser.send("north", taken_ns + AHEAD_NS);
    browser.send("pocket", taken_ns);
    browser.send("pocket", taken_ns + AHEAD_NS);
    let message: Observations = heard.recv_timeout(PATIENCE).unwrap().decode().unwrap();
    assert!(
        message.capture_ns.abs_diff(taken_ns) < 50_000_000,
        "{message:?}"
    );
    assert!(message.clock.error_ns > 0);
    let report = loop {
        let report = browser.message("report");
        if report["refused"] == 2 {
            break report;
        }
    };
    assert_eq!(report["published"], 1);
    assert_eq!(report["cause"], "an image of an impossible time");
    assert_eq!(report["in_rig"], false);
    drop(browser);
    eventually(|| !site.is_alive("pocket"));
}

#[test]
fn a_name_belongs_to_one_camera_of_the_site() {
    let site = Site::open();
    let held = site
        .keys
        .holder(NodeKind::Camera, &NodeId::new("north").unwrap());
    let node = site.bus.hold_name(&held, "board", &|| false).unwrap();
    let reason = site.browser("north", "a").end();
    assert!(reason.reason.contains("choose another name"), "{reason:?}");
    drop(node);
    let mut first = site.browser("pocket", "a");
    first.message("joined");
    assert!(site.browser("pocket", "b").end().reason.contains("pocket"));
    let mut again = site.browser("pocket", "a");
    again.message("joined");
    assert!(first.end().reason.contains("connected again"));
    eventually(|| site.is_alive("pocket"));
}
