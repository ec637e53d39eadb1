//! Ten times as many forged cameras and nodes as the bridge keeps: its memory stays where it was at the bound. The
//! bound of each kind by itself is tested beside the code.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking, its helpers too"
)]

mod messages;

use serde_json::Value;
use sextant_process::{Shutdown, memory};
use sextant_proto::{ClockQuality, Keys, NodeId, NodeKind, Observations, Preview, Timing, encode};
use sextant_site_model::{CameraId, ObjectId};
use sextant_zenoh_bus::{Bus, BusOptions, Qos};
use std::net::{TcpListener, TcpStream};
use std::ops::Range;
use std::time::Duration;
use tungstenite::{Message, WebSocket};

const PATIENCE: Duration = Duration::from_secs(60);
/// Cameras and nodes that the bridge keeps: observations, presences, and previews of half of them.
const BOUND: usize = 256;
/// More than zenoh and the allocator take and give back, less than what a flood would leave: 1,150 previews are 114 MB.
const SLACK_BYTES: u64 = 24 << 20;

struct Flood {
    bus: Bus,
    keys: Keys,
    sequence: u64,
}

impl Flood {
    fn put(&self, key: &str, payload: &[u8]) {
        // As configuration: nothing may be lost on the way.
        let publisher = self.bus.raw_publisher(key, Qos::Config).unwrap();
        publisher.put(payload).unwrap();
    }

    fn send(&self, ids: Range<usize>) {
        for n in ids {
            let name = format!("x{n}");
            let (camera, keys) = (CameraId::new(&name).unwrap(), &self.keys);
            let seen = encode(&observations(&camera)).unwrap();
            self.put(&keys.observations(&camera), &seen);
            if n % 2 == 0 {
                let preview = encode(&preview(&camera)).unwrap();
                self.put(&keys.preview(&camera), &preview);
            }
            let node = NodeId::new(&name).unwrap();
            drop(
                self.bus
                    .alive(&keys.alive(NodeKind::Camera, &node))
                    .unwrap(),
            );
        }
    }

    /// Waits until the bridge has taken in everything until now, and says how large this process is.
    fn settle(&mut self, reader: &mut WebSocket<TcpStream>) -> u64 {
        self.sequence += 1;
        let object = ObjectId::new("x0").unwrap();
        let pose = encode(&messages::pose(&object, 1000 + self.sequence)).unwrap();
        self.put(&self.keys.pose(&object), &pose);
        let is_marker = |message: &Value| {
            message["type"] == "pose" && message["sequence"] == 1000 + self.sequence
        };
        loop {
            if let Message::Text(text) = reader.read().unwrap()
                && is_marker(&serde_json::from_str(&text).unwrap())
            {
                return memory::pss_bytes(std::process::id()).unwrap();
            }
        }
    }
}

fn observations(camera: &CameraId) -> Observations {
    Observations {
        camera: camera.clone(),
        sequence: 1,
        capture_ns: 1,
        exposure_ns: 0,
        clock: ClockQuality::default(),
        resolution: [640, 480],
        timing: Timing::default(),
        tags: Vec::new(),
    }
}

fn preview(camera: &CameraId) -> Preview {
    Preview {
        camera: camera.clone(),
        sequence: 1,
        capture_ns: 1,
        resolution: [640, 480],
        jpeg: vec![0; 99_000],
    }
}

fn connect(address: &str) -> WebSocket<TcpStream> {
    let stream = loop {
        match TcpStream::connect(address) {
            Ok(stream) => break stream,
            Err(_) => std::thread::yield_now(),
        }
    };
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    tungstenite::client(format!("ws://{address}/ws"), stream)
        .unwrap()
        .0
}

#[test]
fn memory_stays_flat_when_ten_times_the_bounds_are_forged() {
    memory::keep_heap_small();
    let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = free.local_addr().unwrap().to_string();
    drop(free);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("viewer.toml");
    let endpoint = &bus.endpoints()[0];
    let text =
        format!("site = \"demo\"\nlisten = \"{address}\"\n[network]\nconnect = [\"{endpoint}\"]\n");
    std::fs::write(&file, text).unwrap();
    let shutdown = Shutdown::manual().unwrap();
    let ending = shutdown.clone();
    let bridge = std::thread::spawn(move || node_viewer_bridge::run(&file, &ending));

    // One client reads, another one never does.
    let (mut reader, stuck) = (connect(&address), connect(&address));
    let keys = Keys::new("demo").unwrap();
    let watched = bus
        .raw_publisher(&keys.preview(&CameraId::new("x0").unwrap()), Qos::Preview)
        .unwrap();
    while !watched.has_subscribers() {
        std::thread::yield_now();
    }
    let mut flood = Flood {
        bus,
        keys,
        sequence: 0,
    };
    flood.send(0..BOUND);
    let at_the_bound = flood.settle(&mut reader);
    flood.send(BOUND..10 * BOUND);
    let after = flood.settle(&mut reader);
    assert!(
        after < at_the_bound + SLACK_BYTES,
        "{at_the_bound} bytes at the bound, {after} after ten times as much"
    );
    drop(stuck);
    shutdown.request();
    bridge.join().unwrap().unwrap();
}
