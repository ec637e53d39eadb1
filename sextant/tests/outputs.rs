//! Poses on their way to other tools: a router of the test's, poses that it publishes, and the real program.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recording;

use recording::{refused, sextant, stdout};
use serde_json::Value;
use sextant_estimator::{ObjectId, State};
use sextant_proto::{Keys, ObjectPose, encode};
use sextant_zenoh_bus::{Bus, BusOptions, Qos, RawPublisher};
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

struct Site {
    _bus: Bus,
    connect: String,
    publisher: RawPublisher,
    sequence: u64,
}

impl Site {
    fn open() -> Self {
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let key = Keys::new("lab").unwrap().pose(&cube());
        let publisher = bus.raw_publisher(&key, Qos::Pose).unwrap();
        Self {
            connect: bus.endpoints()[0].clone(),
            _bus: bus,
            publisher,
            sequence: 0,
        }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = sextant();
        command
            .args(arguments)
            .args(["--site", "lab", "--connect", &self.connect]);
        command
    }

    fn publish(&mut self) {
        self.sequence += 1;
        let pose = pose(self.sequence);
        self.publisher.put(&encode(&pose).unwrap()).unwrap();
    }

    /// Publishes poses until the program ends.
    fn run(&mut self, arguments: &[&str]) -> Output {
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
    fn datagrams(
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
        let child = Ended(Some(child.spawn().unwrap()));
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
struct Ended(Option<Child>);

impl Ended {
    /// Sends it Ctrl-C; the line that it ends with.
    fn interrupt(mut self) -> Value {
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

fn cube() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

fn pose(sequence: u64) -> ObjectPose {
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

#[test]
fn poses_come_as_text_in_three_formats() {
    let mut site = Site::open();
    let mut echo =
        |format| stdout(&site.run(&["echo", "cube", "--count", "3", "--format", format]));
    let json = echo("json");
    let lines: Vec<Value> = json
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 3, "{json}");
    assert_eq!(lines[0]["object"], "cube");
    assert_eq!(lines[0]["position"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(lines[0]["covariance"].as_array().unwrap().len(), 36);
    let csv = echo("csv");
    assert!(csv.starts_with("t_ns,object,state,x,y,z,"), "{csv}");
    assert_eq!(csv.lines().count(), 4, "{csv}");
    let tum = echo("tum");
    let fields: Vec<&str> = tum.lines().next().unwrap().split(' ').collect();
    assert_eq!(fields.len(), 8, "{tum}");
    let (_, decimals) = fields[0].split_once('.').unwrap();
    assert_eq!(decimals.len(), 9, "{tum}");
}

#[test]
fn poses_go_to_a_file_and_a_full_disk_is_told() {
    let mut site = Site::open();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("poses.csv");
    let echo = ["echo", "--format", "csv", "--count", "2", "--out"];
    let said = stdout(&site.run(&[&echo[..], &[file.to_str().unwrap()]].concat()));
    assert_eq!(said, "");
    assert_eq!(std::fs::read_to_string(&file).unwrap().lines().count(), 3);
    let full = site.run(&[&echo[..], &["/dev/full"]].concat());
    refused(
        &full,
        1,
        "/dev/full: cannot write on; the 0 lines before are complete",
    );
    let nowhere = site.run(&[&echo[..], &["/proc/none/poses.csv"]].concat());
    refused(&nowhere, 3, "--out /proc/none/poses.csv cannot be written");
}

#[test]
fn a_reader_that_has_enough_ends_the_echo_quietly() {
    let mut site = Site::open();
    let mut command = site.command(&["echo", "--format", "json"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let first = std::thread::spawn(move || {
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        line
    });
    let deadline = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "it does not end");
        site.publish();
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(first.join().unwrap().starts_with("{\"t_ns\""));
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
}

#[test]
fn osc_messages_reach_their_receiver() {
    let mut site = Site::open();
    let (datagram, summary) = site.datagrams(&["osc", "--axes", "unity"], |_| true);
    assert!(datagram.starts_with(b"/sextant/cube/pose\0\0,fffffff\0\0\0\0"));
    // Unity's x is to the right, where Sextant's y is to the left.
    let x = &datagram[32..36];
    assert_eq!(x, (-2.0_f32).to_be_bytes());
    assert!(summary["sent"].as_u64() >= Some(1), "{summary}");
    let arguments = ["osc", "--layout", "vrchat", "--object", "cube"];
    site.datagrams(&arguments, |d| {
        d.starts_with(b"/tracking/trackers/1/rotation\0")
    });
    let arguments = ["osc", "--layout", "vmt", "--object", "cube"];
    site.datagrams(&arguments, |d| {
        d.starts_with(b"/VMT/Room/Unity\0,iiffffffff\0")
    });
}

#[test]
fn mavlink_odometry_reaches_its_autopilot_beside_heartbeats() {
    let mut site = Site::open();
    let id = |frame: &[u8]| u32::from_le_bytes([frame[7], frame[8], frame[9], 0]);
    let arguments = ["mavlink", "--object", "cube", "--sysid", "9"];
    let (frame, summary) = site.datagrams(&arguments, |frame| id(frame) == 331);
    assert_eq!((frame[0], frame[5], frame[6]), (0xfd, 9, 197));
    // y of the frame forward, right, down.
    assert_eq!(frame[10 + 12..][..4], (-2.0_f32).to_le_bytes());
    assert!(summary["sent"].as_u64() >= Some(1), "{summary}");
    site.datagrams(&arguments, |frame| id(frame) == 0);
}

#[test]
fn what_would_surprise_is_refused_before_anything_is_sent() {
    let run = |arguments: &[&str]| sextant().args(arguments).output().unwrap();
    for (arguments, cause) in [
        (&["osc", "--to", "239.0.0.1:9000"][..], "multicast"),
        (
            &["osc", "--to", "127.0.0.1:1", "--layout", "vrchat"],
            "--object",
        ),
        (
            &["osc", "--to", "127.0.0.1:1", "--address", "/pose"],
            "--object",
        ),
        (
            &["osc", "--to", "127.0.0.1:1", "--address", "pose"],
            "begins with",
        ),
        (
            &["mavlink", "--to", "udp:255.255.255.255:1", "--object", "a"],
            "broadcast",
        ),
        (
            &[
                "mavlink",
                "--to",
                "127.0.0.1:1",
                "--object",
                "a",
                "--rate",
                "0",
            ],
            "0.1 to 1000",
        ),
        (&["echo", "--format", "tum"], "one object only"),
        (
            &["echo", "--format", "csv", "a b"],
            "--format is for objects",
        ),
        (&["echo", "a", "b"], "several objects are for --format"),
    ] {
        refused(&run(arguments), 2, cause);
    }
}
