//! `sextant ros2` between a running site and a router as ROS has one: the graph shows the node, numbers arrive as the
//! site publishes them, late subscribers get what does not move, and a router that comes later or comes back is found.
//!
//! The listener is plain zenoh with a CDR reader of its own. `cargo xtask ros2` does more of this by other people's
//! code.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_process::now_ns;
use sextant_proto::{ObjectPose, Observations};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene, free_port, send, sextant};
use zenoh::Wait;
use zenoh::query::ReplyKeyExpr;
use zenoh::sample::Sample;

const TF: &str = "tf2_msgs::msg::dds_::TFMessage_/\
    RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087";
const POSE: &str = "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_/\
    RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e";
/// Sequence, time and GID with its length.
const ATTACHMENT_BYTES: usize = 33;

/// A program that ends with its test.
struct Program(Child);

impl Program {
    /// Ends it as Ctrl-C does; returns its lines.
    fn interrupt(mut self) -> Vec<Value> {
        send(self.0.id(), libc::SIGINT);
        let out = BufReader::new(self.0.stdout.take().expect("a pipe"));
        let lines = out.lines().map(|line| line.expect("a line"));
        let lines: Vec<Value> = lines
            .map(|line| serde_json::from_str(&line).expect("JSON"))
            .collect();
        assert!(self.0.wait().expect("it ends").success());
        lines
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn bridge(site: &FusedSite, router: &str) -> Program {
    let mut command = sextant();
    command
        .args(["ros2", "--json", "--site", "lab", "--connect"])
        .args([&site.connect, "--router", router])
        .env_remove("ROS_DOMAIN_ID")
        .env_remove("ROS_DISTRO")
        .stdout(Stdio::piped());
    Program(command.spawn().expect("sextant starts"))
}

fn session(mode: &str, endpoint: &str) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    let endpoints = match mode {
        "router" => "listen/endpoints",
        _ => "connect/endpoints",
    };
    for (key, value) in [
        ("mode", format!("{mode:?}")),
        (endpoints, format!("[{endpoint:?}]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config
            .insert_json5(key, &value)
            .expect("an option of zenoh");
    }
    zenoh::open(config).wait().expect("a session")
}

/// Samples of a key as they come.
#[derive(Clone, Default)]
struct Heard(Arc<Mutex<Vec<Sample>>>);

impl Heard {
    fn on(session: &zenoh::Session, key: &str) -> Self {
        let heard = Self::default();
        let intake = heard.clone();
        session
            .declare_subscriber(key.to_owned())
            .callback(move |sample| intake.push(sample))
            .background()
            .wait()
            .expect("a subscription");
        heard
    }

    fn push(&self, sample: Sample) {
        let mut samples = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        samples.push(sample);
    }

    fn take(&self) -> Vec<Sample> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Everything that late subscribers would ask for, by its key.
fn history(session: &zenoh::Session, key: &str) -> Vec<Sample> {
    let replies = session
        .get(format!("{key}/@adv/**"))
        .accept_replies(ReplyKeyExpr::Any)
        .wait()
        .expect("a query");
    replies
        .iter()
        .filter_map(|reply| reply.into_result().ok())
        .collect()
}

fn tokens(session: &zenoh::Session) -> Vec<String> {
    let replies = session.liveliness().get("@ros2_lv/0/**").wait();
    let replies = replies.expect("a query");
    let samples = replies.iter().filter_map(|reply| reply.into_result().ok());
    samples
        .map(|sample| sample.key_expr().as_str().to_owned())
        .collect()
}

/// CDR as written down in the standard, read from the front.
struct Reader {
    bytes: Vec<u8>,
    at: usize,
}

impl Reader {
    fn new(sample: &Sample) -> Self {
        let bytes = sample.payload().to_bytes();
        assert_eq!(bytes[..4], [0, 1, 0, 0], "little-endian CDR");
        Self {
            bytes: bytes[4..].to_vec(),
            at: 0,
        }
    }

    fn word(&mut self) -> u32 {
        self.at = self.at.div_ceil(4) * 4;
        self.at += 4;
        let word = &self.bytes[self.at - 4..self.at];
        u32::from_le_bytes(word.try_into().expect("four bytes"))
    }

    fn double(&mut self) -> f64 {
        self.at = self.at.div_ceil(8) * 8;
        self.at += 8;
        let double = &self.bytes[self.at - 8..self.at];
        f64::from_le_bytes(double.try_into().expect("eight bytes"))
    }

    fn doubles<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.double())
    }

    fn text(&mut self) -> String {
        let length = self.word() as usize;
        self.at += length;
        let text = &self.bytes[self.at - length..self.at - 1];
        assert_eq!(self.bytes[self.at - 1], 0);
        String::from_utf8(text.to_vec()).expect("UTF-8")
    }

    /// Time and frame.
    fn header(&mut self) -> (u64, String) {
        let stamp = u64::from(self.word()) * 1_000_000_000 + u64::from(self.word());
        (stamp, self.text())
    }

    fn end(self) {
        assert_eq!(self.at, self.bytes.len(), "nothing behind");
    }
}

struct Transform {
    stamp_ns: u64,
    parent: String,
    child: String,
    numbers: [f64; 7],
}

fn transforms(sample: &Sample) -> Vec<Transform> {
    let mut reader = Reader::new(sample);
    let count = reader.word();
    let all = (0..count).map(|_| {
        let (stamp_ns, parent) = reader.header();
        Transform {
            stamp_ns,
            parent,
            child: reader.text(),
            numbers: reader.doubles(),
        }
    });
    let all = all.collect();
    reader.end();
    all
}

/// Observations until `found` finds something, an image of each camera at a time.
fn until<T>(
    site: &mut FusedSite,
    scene: &mut Scene,
    what: &str,
    mut found: impl FnMut() -> Option<T>,
) -> T {
    let (start, start_ns) = (Instant::now(), now_ns());
    while start.elapsed() < PATIENCE {
        for camera in 0..scene.rig.cameras().len() {
            let now = now_ns();
            let seconds = (now - start_ns) as f64 * 1e-9;
            let image: Observations = scene.observe(camera, seconds, now);
            site.publish(&image);
        }
        if let Some(found) = found() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(30));
    }
    panic!("never happened: {what}");
}

fn assert_attached(samples: &[Sample]) {
    for sample in samples {
        let attachment = sample.attachment().expect("an attachment").to_bytes();
        assert_eq!(attachment.len(), ATTACHMENT_BYTES);
        assert_eq!(attachment[16], 16);
    }
}

#[test]
fn a_site_is_seen_from_ros() {
    let mut scene = Scene::new(3, &["cube"]);
    let mut site = FusedSite::start(&scene.rig, &scene.objects, "");
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    // The router comes after the bridge.
    let program = bridge(&site, &endpoint);
    let router = session("router", &endpoint);
    let ros = session("client", &endpoint);
    let moving = Heard::on(&ros, &format!("0/tf/{TF}"));
    let posed = Heard::on(&ros, &format!("0/sextant/object/cube/pose/{POSE}"));
    let own = site.listen(&site.keys.all_poses());
    let mut published = BTreeMap::new();
    let mut arrived = Vec::new();
    let (pose, sample) = until(&mut site, &mut scene, "a pose in both", || {
        while let Some(item) = own.try_recv() {
            let pose: ObjectPose = item.decode().expect("a pose");
            published.insert(pose.capture_ns, pose);
        }
        arrived.extend(posed.take());
        arrived.iter().rev().find_map(|sample| {
            let (stamp_ns, _) = Reader::new(sample).header();
            Some((published.get(&stamp_ns)?.clone(), sample.clone()))
        })
    });
    assert_attached(std::slice::from_ref(&sample));
    let mut reader = Reader::new(&sample);
    assert_eq!(reader.header(), (pose.capture_ns, "world".to_owned()));
    assert_eq!(reader.doubles(), pose.position);
    let orientation: [f64; 4] = reader.doubles();
    for (theirs, ours) in orientation.iter().zip(pose.orientation) {
        assert!((theirs - ours).abs() < 1e-12);
    }
    assert_eq!(reader.doubles(), pose.covariance);
    reader.end();

    let samples = until(&mut site, &mut scene, "transforms", || {
        Some(moving.take()).filter(|samples| samples.len() > 2)
    });
    assert_attached(&samples);
    for sample in &samples {
        let [one] = &transforms(sample)[..] else {
            panic!("one object, one transform");
        };
        assert_eq!((one.parent.as_str(), one.child.as_str()), ("world", "cube"));
    }
    let stamps = samples.iter().map(|sample| transforms(sample)[0].stamp_ns);
    assert!(stamps.is_sorted_by(|a, b| a < b), "tf2 refuses the others");

    let late = session("client", &endpoint);
    let fixed = history(&late, &format!("0/tf_static/{TF}"));
    assert_attached(&fixed);
    let [fixed] = &fixed[..] else {
        panic!("one publisher, one message: {fixed:?}");
    };
    for camera in scene.rig.cameras() {
        let frame = format!("{}_optical", camera.id);
        let all = transforms(fixed);
        let one = all.iter().find(|one| one.child == frame);
        let one = one.expect("a transform of each camera");
        let pose = camera.world_from_camera.expect("a pose");
        let position: [f64; 3] = pose.translation.vector.into();
        assert_eq!(
            (one.parent.as_str(), &one.numbers[..3]),
            ("world", &position[..])
        );
    }
    let seen = tokens(&late);
    assert_eq!(
        seen.iter().filter(|token| token.contains("/NN/")).count(),
        1
    );
    for topic in [
        "%tf/",
        "%tf_static/",
        "%sextant%object%cube%pose/",
        "%diagnostics/",
    ] {
        assert!(
            seen.iter().any(|token| token.contains(topic)),
            "{topic}: {seen:?}"
        );
    }

    let lines = program.interrupt();
    let last = lines.last().expect("a summary");
    assert_eq!(
        (&last["event"], &last["failed"]),
        (&"end".into(), &0.into())
    );
    assert!(last["published"].as_u64() > Some(5), "{last}");
    let deadline = Instant::now() + PATIENCE;
    while !tokens(&late).is_empty() {
        assert!(Instant::now() < deadline, "the node stays in the graph");
    }
    for session in [late, ros, router] {
        session.close().wait().expect("it closes");
    }
}

#[test]
fn a_router_that_comes_back_is_found() {
    let mut scene = Scene::new(3, &["cube"]);
    let mut site = FusedSite::start(&scene.rig, &scene.objects, "");
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let router = session("router", &endpoint);
    let program = bridge(&site, &endpoint);
    let moving = Heard::on(&router, &format!("0/tf/{TF}"));
    until(&mut site, &mut scene, "transforms", || moving.take().pop());
    router.close().wait().expect("it closes");
    let router = session("router", &endpoint);
    let moving = Heard::on(&router, &format!("0/tf/{TF}"));
    until(&mut site, &mut scene, "transforms again", || {
        moving.take().pop()
    });
    let fixed = history(&router, &format!("0/tf_static/{TF}"));
    assert_eq!(fixed.len(), 1);
    assert!(tokens(&router).iter().any(|token| token.contains("/NN/")));
    program.interrupt();
    router.close().wait().expect("it closes");
}
