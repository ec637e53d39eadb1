//! The whole bridge against a real network on loopback: what a browser and a script get to hear.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking, its helpers too"
)]

mod messages;
mod protocol;

use serde_json::Value;
use sextant_process::Shutdown;
use sextant_proto::{
    CameraConfig, ChangeOutcome, ClockQuality, ConfigAnswer, Keys, LensConfig, MountConfig, NodeId,
    NodeKind, ObjectConfig, ObjectTagConfig, Observations, PoseConfig, Preview, Refusal, RigConfig,
    Timing, encode, fingerprint,
};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_site_model::{CameraId, ObjectId};
use sextant_tag_families::Family;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Qos, RawLatest};
use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

const JSON: &str = "Content-Type: application/json\r\n";
const LEARN: &str =
    r#"{"do":"start","wizard":"learn","id":"cube","tags":[{"id":3,"size_m":0.04}]}"#;
const PATIENCE: Duration = Duration::from_secs(20);
/// Three seconds of a camera.
const IMAGES: u64 = 90;

/// A site with a router and a bridge, and an object that was announced before the bridge came.
struct Site {
    address: SocketAddr,
    bus: Bus,
    keys: Keys,
    shutdown: Shutdown,
    bridge: Option<JoinHandle<anyhow::Result<()>>>,
    _object: RawLatest,
    folder: tempfile::TempDir,
}

impl Site {
    fn open() -> Self {
        Self::open_with("", |_| {})
    }

    /// With more in viewer.toml, and in its folder.
    fn open_with(more: &str, prepare: impl FnOnce(&Path)) -> Self {
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let keys = Keys::new("demo").unwrap();
        let object = bus
            .raw_latest(&keys.config_object(&cube()), Qos::Config)
            .unwrap();
        let model = ObjectConfig {
            tags: vec![ObjectTagConfig {
                family: Family::Tag36h11,
                id: 3,
                size_m: 0.04,
                size_sigma_m: None,
                link: None,
                object_from_tag: None,
                object_from_tag_sigma: None,
            }],
            ..ObjectConfig::removal(cube())
        };
        object.put(&encode(&model).unwrap()).unwrap();
        let address = free_address();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("viewer.toml");
        let endpoint = &bus.endpoints()[0];
        let text = format!(
            "site = \"demo\"\nlisten = \"{address}\"\n{more}\n[network]\nconnect = [\"{endpoint}\"]\n"
        );
        std::fs::write(&file, text).unwrap();
        prepare(folder.path());
        let shutdown = Shutdown::manual().unwrap();
        let bridge = std::thread::spawn({
            let shutdown = shutdown.clone();
            move || node_viewer_bridge::run(&file, &shutdown)
        });
        let site = Self {
            address,
            bus,
            keys,
            shutdown,
            bridge: Some(bridge),
            _object: object,
            folder,
        };
        eventually(|| site.get("/readyz", "localhost").starts_with("HTTP/1.1 200"));
        site
    }

    fn get(&self, path: &str, host: &str) -> String {
        String::from_utf8_lossy(&self.get_bytes(path, host)).into_owned()
    }

    fn get_bytes(&self, path: &str, host: &str) -> Vec<u8> {
        let Ok(mut stream) = TcpStream::connect(self.address) else {
            return Vec::new();
        };
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        answer
    }

    /// Status and body of what is answered to a command.
    fn post(&self, headers: &str, body: &str) -> (u16, String) {
        self.post_to("/api/wizard", headers, body)
    }

    fn post_to(&self, path: &str, headers: &str, body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(self.address).unwrap();
        let request = format!(
            "POST {path} HTTP/1.1\r\nHost: localhost\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        );
        // A body that is refused for its length need not be taken in.
        let _ = stream.write_all(request.as_bytes());
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
        let status = head.split(' ').nth(1).and_then(|code| code.parse().ok());
        (status.unwrap_or(0), body.to_owned())
    }

    fn command(&self, body: &str) -> (u16, String) {
        self.post(JSON, body)
    }

    /// Announces two cameras, as a fusion node would, and waits until the bridge knows them.
    fn announce_rig(&self, socket: &mut WebSocket<TcpStream>) -> RawLatest {
        let camera = |id: &str| CameraConfig {
            id: CameraId::new(id).unwrap(),
            resolution: [640, 480],
            lens: LensConfig::Pinhole {
                fx: 600.0,
                fy: 600.0,
                cx: 319.5,
                cy: 239.5,
            },
            lens_sigma: None,
            world_from_camera: None,
            mount: None,
            world_from_camera_sigma: None,
            line_delay_s: None,
            exposure: None,
        };
        let mount = MountConfig {
            carrier: cube(),
            carrier_from_camera: PoseConfig {
                position: [0.1, 0.0, 0.0],
                orientation: [0.0, 0.0, 0.0, 1.0],
            },
        };
        let carried = CameraConfig {
            mount: Some(mount),
            ..camera("b")
        };
        let rig = RigConfig {
            cameras: vec![camera("a"), carried],
            scale_sigma: None,
        };
        let publisher = self
            .bus
            .raw_latest(&self.keys.config_rig(), Qos::Config)
            .unwrap();
        publisher.put(&encode(&rig).unwrap()).unwrap();
        let message = hear(socket, |m| m["type"] == "rig");
        assert_eq!(message["cameras"][0]["mount"], Value::Null);
        let mount = &message["cameras"][1]["mount"];
        assert_eq!(mount["carrier"], cube().as_str());
        assert_eq!(mount["carrier_from_camera"]["position"][0], 0.1);
        publisher
    }

    fn socket(&self) -> WebSocket<TcpStream> {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{}/ws", self.address);
        tungstenite::client(url, stream).unwrap().0
    }

    /// Publishes images, a preview and observations of each; the observations are heard before the next image.
    fn see_all_images(&self, reader: &mut WebSocket<TcpStream>) {
        let camera = CameraId::new("north").unwrap();
        let (seen, previews) = (self.keys.observations(&camera), self.keys.preview(&camera));
        let seen = self.bus.raw_publisher(&seen, Qos::Config).unwrap();
        let previews = self.bus.raw_publisher(&previews, Qos::Preview).unwrap();
        eventually(|| previews.has_subscribers());
        for sequence in 0..IMAGES {
            let preview = Preview {
                camera: camera.clone(),
                sequence,
                capture_ns: sequence + 1,
                resolution: [640, 480],
                jpeg: vec![0; 90_000],
            };
            previews.put(&encode(&preview).unwrap()).unwrap();
            let message = Observations {
                camera: camera.clone(),
                sequence,
                capture_ns: sequence + 1,
                exposure_ns: 0,
                clock: ClockQuality::default(),
                resolution: [640, 480],
                timing: Timing::default(),
                tags: Vec::new(),
            };
            seen.put(&encode(&message).unwrap()).unwrap();
            hear(reader, |m| {
                m["type"] == "observations" && m["sequence"] == sequence
            });
        }
    }

    fn put_pose(&self, sequence: u64) {
        let pose = messages::pose(&cube(), sequence);
        let publisher = self.bus.raw_publisher(&self.keys.pose(&cube()), Qos::Pose);
        publisher.unwrap().put(&encode(&pose).unwrap()).unwrap();
    }

    /// Ends the bridge and tells how long that took.
    fn stop(&mut self) -> Duration {
        let begun = Instant::now();
        self.shutdown.request();
        self.bridge.take().unwrap().join().unwrap().unwrap();
        begun.elapsed()
    }
}

fn cube() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

fn free_address() -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap()
}

fn eventually(mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "it never came");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// The next text message that `wanted` accepts.
fn hear(socket: &mut WebSocket<TcpStream>, wanted: impl Fn(&Value) -> bool) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let message: Value = serde_json::from_str(&text).unwrap();
            if wanted(&message) {
                return message;
            }
        }
    }
}

#[test]
fn the_last_seconds_are_saved_as_a_recording() {
    let mut site = Site::open();
    let mut socket = site.socket();
    hear(&mut socket, |m| m["type"] == "object");
    site.put_pose(41);
    hear(&mut socket, |m| m["type"] == "pose");
    let answer = site.get_bytes("/api/last.mcap", "localhost");
    let head = answer.windows(4).position(|four| four == b"\r\n\r\n");
    let file = site.folder.path().join("last.mcap");
    std::fs::write(&file, &answer[head.unwrap() + 4..]).unwrap();
    let recording = SiteRecording::read(&file).unwrap();
    assert_eq!(recording.poses, [messages::pose(&cube(), 41)]);
    assert_eq!(recording.models.len(), 1);
    site.stop();
}

#[test]
fn a_client_gets_a_greeting_then_what_is_known_then_what_happens() {
    let mut site = Site::open();
    let mut socket = site.socket();
    assert_eq!(hear(&mut socket, |_| true)["type"], "hello");
    assert_eq!(hear(&mut socket, |m| m["type"] == "object")["id"], "cube");
    site.put_pose(41);
    let pose = hear(&mut socket, |m| m["type"] == "pose");
    assert_eq!(
        (&pose["sequence"], &pose["object"]),
        (&41.into(), &"cube".into())
    );
    let state = site.get("/api/state", "localhost");
    let json: Value = serde_json::from_str(state.split_once("\r\n\r\n").unwrap().1).unwrap();
    let messages = json["messages"].as_array().unwrap();
    assert!(messages.iter().any(|message| message["sequence"] == 41));
    assert!(site.stop() < Duration::from_secs(2));
    while let Ok(message) = socket.read() {
        assert!(!matches!(message, Message::Binary(_)));
    }
}

/// The golden message of each kind, as its node would publish it, and what else the bridge tells of.
#[test]
fn every_message_is_as_the_protocol_says() {
    let protocol = protocol::protocol();
    let mut site = Site::open();
    let mut socket = site.socket();
    let publisher = |key: &str| site.bus.raw_publisher(key, Qos::Config).unwrap();
    let golden = protocol.keys.iter().filter_map(|row| {
        let (message, _) = row.message.as_ref()?;
        let key = row.key.replace("<camera>", "north");
        let key = key.replace("<object>", "cube").replace("<node>", "fusion");
        let file = format!("../proto/golden/{}.bin", snake_case(message));
        let publisher = publisher(&format!("sextant/v1/demo/{key}"));
        Some((publisher, std::fs::read(file).unwrap()))
    });
    let golden: Vec<_> = golden.collect();
    let publish_all = || {
        golden
            .iter()
            .for_each(|(publisher, payload)| publisher.put(payload).unwrap())
    };
    publish_all();
    let node = NodeId::new("north").unwrap();
    let alive = site.keys.alive(NodeKind::Camera, &node);
    let _alive = site.bus.alive(&alive).unwrap();
    eventually(|| site.command(LEARN).0 == 202);
    let mut missing: BTreeSet<&str> = protocol.messages().collect();
    // Nothing enters a zone here, and no object goes.
    missing.retain(|name| !["events", "object_gone"].contains(name));
    let deadline = Instant::now() + PATIENCE;
    while !missing.is_empty() {
        assert!(Instant::now() < deadline, "{missing:?}");
        let message = hear(&mut socket, |_| true);
        protocol::check(&protocol, &message);
        missing.remove(message["type"].as_str().unwrap());
        if message["type"] == "bridge_status" {
            publish_all();
        }
    }
    drop(golden);
    site.stop();
}

/// `ObjectPose` as `object_pose`.
fn snake_case(name: &str) -> String {
    let letters = name.chars().map(|letter| match letter {
        'A'..='Z' => format!("_{}", letter.to_ascii_lowercase()),
        _ => letter.to_string(),
    });
    letters
        .collect::<String>()
        .trim_start_matches('_')
        .to_owned()
}

/// The path and the JSON of the next POST to a webhook, which is answered by 204.
fn take_post(listener: &TcpListener) -> (String, Value) {
    let (mut stream, _) = listener.accept().unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let (mut request, mut buffer) = (Vec::new(), [0; 4096]);
    loop {
        let n = stream.read(&mut buffer).unwrap();
        assert!(n > 0, "the request ends early");
        request.extend(&buffer[..n]);
        let text = String::from_utf8(request.clone()).unwrap();
        let Some((head, body)) = text.split_once("\r\n\r\n") else {
            continue;
        };
        if let Ok(json) = serde_json::from_str(body) {
            stream
                .write_all(b"HTTP/1.1 204 No Content\r\n\r\n")
                .unwrap();
            return (head.split(' ').nth(1).unwrap().to_owned(), json);
        }
    }
}

/// The version of the site's object, as the bridge knows it now.
fn version_of_cube(site: &Site) -> Option<String> {
    let answer = site.get("/api/state", "localhost");
    let (_, body) = answer.split_once("\r\n\r\n")?;
    let state: Value = serde_json::from_str(body).ok()?;
    let messages = state["messages"].as_array()?;
    let cube = messages.iter().find(|m| m["type"] == "object")?;
    Some(cube["version"].as_str()?.to_owned())
}

fn edit_of_cube(version: &str) -> String {
    let tag = r#"{"family":"tag36h11","id":3,"size_m":0.05,"pose":null}"#;
    format!(
        r#"{{"do":"edit_object","object":"cube","version":"{version}","id":"cube","tags":[{tag}]}}"#
    )
}

#[test]
fn an_edit_is_published_and_answered_as_the_fusion_node_decides() {
    let site = Site::open();
    let node = NodeId::new("main").unwrap();
    let alive = site.keys.alive(NodeKind::Fusion, &node);
    let _alive = site.bus.alive(&alive).unwrap();
    let key = site.keys.config_object(&cube());
    let requests = site.bus.subscribe(&key, 16, DropRule::Oldest, 1 << 17);
    let requests = requests.unwrap();
    let key = site.keys.config_answer(&node);
    let answers = site.bus.raw_publisher(&key, Qos::Config).unwrap();
    let is_ready = || {
        let state = site.get("/api/state", "localhost");
        state.contains("\"kind\":\"fusion\"") && version_of_cube(&site).is_some()
    };
    eventually(is_ready);
    let version = version_of_cube(&site).unwrap();
    let answered = |version: &str, outcome: ChangeOutcome| {
        std::thread::scope(|scope| {
            let asked = scope.spawn(|| site.post_to("/api/models", JSON, &edit_of_cube(version)));
            let request = requests.recv_timeout(PATIENCE).unwrap();
            let object: ObjectConfig = request.decode().unwrap();
            assert_eq!(object.tags[0].size_m, 0.05);
            let answer = ConfigAnswer {
                node: node.clone(),
                key: "config/object/cube".to_owned(),
                fingerprint: fingerprint(request.bytes().unwrap()),
                outcome,
                followers: vec![],
                behind: vec![],
            };
            answers.put(&encode(&answer).unwrap()).unwrap();
            asked.join().unwrap()
        })
    };
    let refused = ChangeOutcome::Refused(Refusal::TooManyObjects { limit: 7 });
    let (status, body) = answered(&version, refused);
    assert!(status == 409 && body.contains("at most 7"), "{body}");
    // Until a fusion node announces otherwise, the bridge takes what was asked for as in force.
    let (status, body) = site.post_to("/api/models", JSON, &edit_of_cube(&version));
    assert!(status == 409 && body.contains("newer version"), "{body}");
    let newer = version_of_cube(&site).unwrap();
    let (status, body) = answered(&newer, ChangeOutcome::Kept);
    assert!(
        status == 200 && body.contains("keeps it in its files"),
        "{body}"
    );
}

#[test]
fn events_of_zones_reach_clients_the_network_and_the_webhook() {
    let hook = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/hook", hook.local_addr().unwrap());
    let more = format!("folder = \".\"\n[webhook]\nurl = \"{url}\"");
    let mut site = Site::open_with(&more, |_| {});
    let mut socket = site.socket();
    let set =
        r#"{"do":"set","zone":{"shape":"box","name":"dock","centre":[0,0,0],"size":[1,1,1]}}"#;
    assert_eq!(site.post_to("/api/zones", JSON, set).0, 202);
    hear(&mut socket, |m| {
        m["type"] == "zones" && m["zones"][0]["name"] == "dock"
    });
    let wrong = set.replace("[1,1,1]", "[1,1,0]");
    let (status, cause) = site.post_to("/api/zones", JSON, &wrong);
    assert!(
        status == 400 && cause.contains("\"size\""),
        "{status} {cause}"
    );

    let node = NodeId::new("viewer").unwrap();
    let events = site
        .bus
        .subscribe(&site.keys.events(&node), 16, DropRule::Oldest, 4096);
    let events = events.unwrap();
    let key = site.keys.pose(&cube());
    let poses = site.bus.raw_publisher(&key, Qos::Config).unwrap();
    for sequence in 0..20 {
        let mut pose = messages::pose(&cube(), sequence);
        pose.capture_ns = 1 + sequence * 33_000_000;
        pose.position = [if sequence < 10 { 2.0 } else { 0.1 }, 0.0, 0.0];
        poses.put(&encode(&pose).unwrap()).unwrap();
    }
    // The zones are sent before the events.
    hear(&mut socket, |m| {
        m["type"] == "zones" && m["zones"][0]["inside"][0] == "cube"
    });
    let message = hear(&mut socket, |m| {
        m["type"] == "events" && m["events"][0] != Value::Null
    });
    let event = &message["events"][0];
    assert_eq!(
        (&event["event"], &event["zone"]),
        (&"entered".into(), &"dock".into())
    );
    let item = events.recv_timeout(PATIENCE).unwrap();
    let published: Value = serde_json::from_slice(item.bytes().unwrap()).unwrap();
    assert_eq!(&published, event);
    let (path, mut posted) = take_post(&hook);
    assert_eq!((path.as_str(), &posted["site"]), ("/hook", &"demo".into()));
    posted.as_object_mut().unwrap().remove("site");
    assert_eq!(&posted, event);
    let file = std::fs::read_to_string(site.folder.path().join("zones.toml")).unwrap();
    assert!(file.contains("dock"), "{file}");
    site.stop();
}

#[test]
fn scripts_get_figures_and_what_ails_the_site() {
    let mut site = Site::open();
    site.put_pose(1);
    eventually(|| {
        let metrics = site.get("/metrics", "localhost");
        metrics.contains("\r\ncontent-type: text/plain; version=0.0.4")
            && metrics.contains("\nsextant_poses_total{object=\"cube\"} 1\n")
    });
    let health = site.get("/healthz", "localhost");
    assert!(health.starts_with("HTTP/1.1 503"), "{health}");
    assert!(health.contains("no fusion node is running"), "{health}");
    site.stop();
}

#[test]
fn foreign_hosts_and_pages_are_refused() {
    let mut site = Site::open();
    for path in ["/", "/ws", "/api/state", "/healthz", "/metrics"] {
        let answer = site.get(path, "evil.example");
        assert!(answer.starts_with("HTTP/1.1 403"), "{path}: {answer}");
    }
    let answer = site.get("/", "localhost\r\nOrigin: http://evil.example");
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
    assert!(
        site.get("/", "localhost")
            .contains("<title>Sextant</title>")
    );
    site.stop();
}

#[test]
fn a_client_that_never_reads_holds_nobody_up() {
    let mut site = Site::open();
    let stuck = site.socket();
    let mut reader = site.socket();
    let camera = CameraId::new("north").unwrap();
    let key = site.keys.preview(&camera);
    let publisher = site.bus.raw_publisher(&key, Qos::Preview).unwrap();
    eventually(|| publisher.has_subscribers());
    let mut preview = Preview {
        camera,
        sequence: 0,
        capture_ns: 0,
        resolution: [640, 480],
        jpeg: vec![0; 90_000],
    };
    // The stuck client's socket buffers fill with pictures; the reader sees every pose all the same.
    for count in 0..400 {
        preview.sequence = count;
        publisher.put(&encode(&preview).unwrap()).unwrap();
        site.put_pose(count);
        hear(&mut reader, |m| {
            m["type"] == "pose" && m["sequence"] == count
        });
    }
    let status = hear(&mut reader, |m| {
        m["type"] == "bridge_status" && m["replaced"] != 0
    });
    assert_eq!(status["clients"], 2);
    drop(stuck);
    site.stop();
}

#[test]
fn a_taken_port_ends_the_bridge_with_its_exit_code() {
    let holder = TcpListener::bind("127.0.0.1:0").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("viewer.toml");
    let address = holder.local_addr().unwrap();
    std::fs::write(&file, format!("site = \"demo\"\nlisten = \"{address}\"\n")).unwrap();
    let error = node_viewer_bridge::run(&file, &Shutdown::manual().unwrap()).unwrap_err();
    assert!(error.to_string().contains("in use"), "{error}");
    let exit = sextant_process::exit::exit_of(&error);
    assert_eq!(exit, sextant_process::Exit::Unavailable);
}

#[test]
fn commands_come_as_json_from_the_bridges_own_page() {
    let mut site = Site::open();
    let (status, _) = site.post(&format!("{JSON}Origin: http://evil.example\r\n"), LEARN);
    assert_eq!(status, 403);
    assert_eq!(site.post("", LEARN).0, 415);
    assert_eq!(site.post("Content-Type: text/plain\r\n", LEARN).0, 415);
    assert_eq!(site.command(&" ".repeat(300_000)).0, 413);
    assert_eq!(site.command("{\"do\":\"dance\"}").0, 400);
    let (status, said) = site.command(LEARN);
    let said: Value = serde_json::from_str(&said).unwrap();
    assert_eq!((status, &said["field"]), (400, &"cameras".into()), "{said}");
    site.stop();
}

#[test]
fn one_wizard_is_seen_by_every_client_and_by_those_who_come_late() {
    let mut site = Site::open();
    let mut first = site.socket();
    assert_eq!(hear(&mut first, |m| m["type"] == "wizard")["stage"], "idle");
    let _rig = site.announce_rig(&mut first);
    assert_eq!(site.command(LEARN).0, 202);
    let message = hear(&mut first, |m| m["stage"] == "collecting");
    assert_eq!(
        (&message["wizard"], &message["subject"]),
        (&"learn".into(), &"cube".into())
    );
    let late = hear(&mut site.socket(), |m| m["type"] == "wizard");
    assert_eq!(late["stage"], "collecting");
    let (status, said) = site.command(LEARN);
    assert!(
        status == 409 && said.contains("another wizard"),
        "{status} {said}"
    );
    assert_eq!(site.command("{\"do\":\"solve\"}").0, 202);
    let message = hear(&mut first, |m| m["cause"].is_string());
    assert_eq!(message["stage"], "collecting", "{message}");
    assert_eq!(site.command("{\"do\":\"keep\"}").0, 409);
    assert_eq!(site.command("{\"do\":\"discard\"}").0, 202);
    assert_eq!(
        hear(&mut first, |m| m["stage"] == "idle")["wizard"],
        Value::Null
    );
    site.stop();
}

/// 200 connections that say nothing or half a header, one that asks for everything and does not read, a WebSocket that
/// does not read: every image arrives, the page is served, and those that say nothing are shown out.
#[test]
fn idle_connections_and_slow_readers_hold_nobody_up() {
    let mut site = Site::open();
    let mut idle: Vec<TcpStream> = (0..200)
        .map(|n| {
            let mut stream = TcpStream::connect(site.address).unwrap();
            if n % 2 == 0 {
                stream.write_all(b"GET / HTTP/1.1\r\nHost: lo").unwrap();
            }
            stream
        })
        .collect();
    let mut greedy = TcpStream::connect(site.address).unwrap();
    let request = b"GET /api/state HTTP/1.1\r\nHost: localhost\r\n\r\n";
    greedy.write_all(request).unwrap();
    let stuck = site.socket();
    let mut reader = site.socket();
    site.see_all_images(&mut reader);
    assert!(site.get("/readyz", "localhost").starts_with("HTTP/1.1 200"));
    for stream in &mut idle {
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        // Whatever is said about half a header, the connection ends.
        let ended = stream.read_to_end(&mut Vec::new());
        let is_open = ended.is_err_and(|error| error.kind() == std::io::ErrorKind::WouldBlock);
        assert!(!is_open, "an idle connection stays open");
    }
    drop((greedy, stuck));
    site.stop();
}

/// While a command waits for a file, everything else goes on.
#[test]
fn a_file_that_does_not_answer_holds_nobody_up() {
    let site = Site::open_with("folder = \".\"", |folder| {
        let made = std::process::Command::new("mkfifo")
            .arg(folder.join("rig.toml"))
            .status();
        assert!(made.unwrap().success());
    });
    let fifo = site.folder.path().join("rig.toml");
    let mut reader = site.socket();
    let answer = std::thread::scope(|scope| {
        let command = scope.spawn(|| site.command(LEARN));
        // This returns as soon as the bridge has opened the file to read it.
        let mut file = std::fs::OpenOptions::new().write(true).open(&fifo).unwrap();
        site.see_all_images(&mut reader);
        assert!(site.get("/readyz", "localhost").starts_with("HTTP/1.1 200"));
        file.write_all(b"mine").unwrap();
        drop(file);
        command.join().unwrap()
    });
    assert_eq!(answer.0, 409, "{}", answer.1);
    let mut site = site;
    site.stop();
}
