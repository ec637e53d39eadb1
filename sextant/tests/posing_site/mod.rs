//! A site that publishes poses, for tests of the programs that hand poses on.
#![allow(dead_code, reason = "each test uses a part of it")]

use crate::recording::{sextant, stdout};
use serde_json::Value;
use sextant_proto::{Keys, ObjectConfig, ObjectPose, ObjectTagConfig, encode};
use sextant_site_model::ObjectId;
use sextant_site_report::State;
use sextant_tag_families::Family;
use sextant_zenoh_bus::{Bus, BusOptions, Qos, RawLatest, RawPublisher};
use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, UdpSocket};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The longest wait for anything.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A router of the test's on which a cube moves.
pub struct Site {
    bus: Bus,
    connect: String,
    publisher: RawPublisher,
    sequence: u64,
    announced: Vec<RawLatest>,
}

impl Site {
    pub fn open() -> Self {
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let key = Keys::new("lab").unwrap().pose(&cube());
        let publisher = bus.raw_publisher(&key, Qos::Pose).unwrap();
        Self {
            connect: bus.endpoints()[0].clone(),
            bus,
            announced: Vec::new(),
            publisher,
            sequence: 0,
        }
    }

    /// Answers for these objects as a fusion node does.
    pub fn announce(&mut self, objects: &[&str]) {
        let keys = Keys::new("lab").unwrap();
        for object in objects {
            let id = ObjectId::new(object).unwrap();
            let key = keys.config_object(&id);
            let object = ObjectConfig {
                id,
                links: Vec::new(),
                joints: Vec::new(),
                tags: vec![tag()],
                frame_sigma: None,
                scale_sigma: None,
                world_from_object: None,
            };
            let kept = self.bus.raw_latest(&key, Qos::Config).unwrap();
            kept.put(&encode(&object).unwrap()).unwrap();
            self.announced.push(kept);
        }
    }

    /// The program with the arguments that find the site.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = sextant();
        command
            .args(arguments)
            .args(["--site", "lab", "--connect", &self.connect]);
        command
    }

    /// Publishes the next pose.
    pub fn publish(&mut self) {
        self.sequence += 1;
        let pose = pose(self.sequence);
        self.publisher.put(&encode(&pose).unwrap()).unwrap();
    }

    /// Publishes poses until the program ends.
    pub fn run(&mut self, arguments: &[&str]) -> Output {
        let mut command = self.command(arguments);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = child.spawn().unwrap();
        let deadline = Instant::now() + PATIENCE;
        while child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "it does not end");
            self.publish();
            std::thread::sleep(Duration::from_millis(10));
        }
        child.wait_with_output().unwrap()
    }

    /// Runs a program that sends to the returned datagrams' receiver until `wanted` of them fit.
    pub fn datagrams(
        &mut self,
        arguments: &[&str],
        wanted: impl Fn(&[u8]) -> bool,
    ) -> (Vec<u8>, Value) {
        let receiver = UdpSocket::bind("127.0.0.1:0").unwrap();
        let wait = Some(Duration::from_millis(10));
        receiver.set_read_timeout(wait).unwrap();
        let to = receiver.local_addr().unwrap().to_string();
        let mut command = self.command(arguments);
        let command = command.args(["--json", "--to", &to]);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = Ended::new(child.spawn().unwrap());
        let (deadline, mut buffer) = (Instant::now() + PATIENCE, [0; 512]);
        loop {
            assert!(Instant::now() < deadline, "nothing of that kind comes");
            self.publish();
            if let Ok(length) = receiver.recv(&mut buffer)
                && wanted(&buffer[..length])
            {
                let summary = child.interrupt();
                return (buffer[..length].to_vec(), summary);
            }
        }
    }
}

/// A program that is ended in any case.
pub struct Ended(Option<Child>);

impl Ended {
    pub fn new(child: Child) -> Self {
        Self(Some(child))
    }

    /// Sends it Ctrl-C; the line that it ends with.
    pub fn interrupt(mut self) -> Value {
        let child = self.0.take().unwrap();
        let kill = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(kill.unwrap().success());
        let output = child.wait_with_output().unwrap();
        serde_json::from_str(&stdout(&output)).unwrap()
    }
}

impl Drop for Ended {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A program that serves poses at an address that it names in its first line.
pub struct Server {
    pub program: Ended,
    words: BufReader<ChildStderr>,
    pub address: SocketAddr,
}

impl Server {
    /// The program with these arguments, on a free port; `before` and `after` enclose its address.
    pub fn start(site: &Site, arguments: &[&str], before: &str, after: char) -> Self {
        let mut command = site.command(arguments);
        command.args(["--json", "--listen", "127.0.0.1:0"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let words = BufReader::new(child.stderr.take().unwrap());
        let mut server = Self {
            program: Ended::new(child),
            words,
            address: SocketAddr::from(([0; 4], 0)),
        };
        let line = server.line();
        let address = line
            .split(before)
            .nth(1)
            .and_then(|rest| rest.split(after).next());
        server.address = address.unwrap_or_else(|| panic!("{line}")).parse().unwrap();
        server
    }

    /// The next line that it writes for people.
    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.words.read_line(&mut line).unwrap();
        line
    }
}

pub fn tag() -> ObjectTagConfig {
    ObjectTagConfig {
        family: Family::Tag36h11,
        id: 3,
        size_m: 0.04,
        size_sigma_m: None,
        link: None,
        object_from_tag: None,
        object_from_tag_sigma: None,
    }
}

pub fn cube() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

pub fn pose(sequence: u64) -> ObjectPose {
    ObjectPose {
        object: cube(),
        epoch: 1,
        sequence,
        capture_ns: 1_800_000_000_000_000_000 + sequence * 10_000_000,
        published_ns: 1_800_000_000_000_000_000,
        state: State::Tracking,
        position: [1.0, 2.0, 3.0],
        orientation: [0.0, 0.0, 0.0, 1.0],
        covariance: std::array::from_fn(|place| if place % 7 == 0 { 1e-6 } else { 0.0 }),
        twist: [0.0; 6],
        cameras: 2,
        tags: 3,
        rms_px: 0.125,
    }
}
