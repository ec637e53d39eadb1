//! What `sextant config apply-refinement` leaves behind where a fusion node does not answer.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recording;

use recording::{sextant, stderr};
use sextant_proto::{
    CameraConfig, ConfigAnswer, KeyRef, Keys, LensConfig, Message, ModelPayload, NodeId, NodeKind,
    ObjectConfig, ObjectTagConfig, Outcome, Proposal, RigConfig, fingerprint, limits,
};
use sextant_site_model::ObjectId;
use sextant_tag_families::Family;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Latest, Qos};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

fn rig(focal_px: f64) -> RigConfig {
    let camera = CameraConfig {
        id: "north".parse().unwrap(),
        resolution: [640, 480],
        lens: LensConfig::Pinhole {
            fx: focal_px,
            fy: focal_px,
            cx: 319.5,
            cy: 239.5,
        },
        lens_sigma: None,
        world_from_camera: None,
        world_from_camera_sigma: None,
        line_delay_s: None,
        exposure: None,
    };
    RigConfig {
        cameras: vec![camera],
        scale_sigma: None,
    }
}

fn cube(size_m: f64) -> ObjectConfig {
    let tag = ObjectTagConfig {
        family: Family::Tag36h11,
        id: 3,
        size_m,
        size_sigma_m: None,
        link: None,
        object_from_tag: None,
        object_from_tag_sigma: None,
    };
    ObjectConfig {
        id: ObjectId::new("cube").unwrap(),
        links: Vec::new(),
        joints: Vec::new(),
        tags: vec![tag],
        frame_sigma: None,
        scale_sigma: None,
    }
}

/// A fusion node that puts in force what it is asked to, and answers as told.
struct Node {
    bus: Bus,
    keys: Keys,
    id: NodeId,
    rig: Latest<RigConfig>,
    object: Latest<ObjectConfig>,
    answers: Latest<ConfigAnswer>,
    _proposal: Latest<Proposal>,
}

impl Node {
    /// It proposes another lens and another size of a tag.
    fn open() -> Self {
        let bus = Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap();
        let (keys, id) = (Keys::new("lab").unwrap(), NodeId::new("main").unwrap());
        let proposal = Proposal {
            rig: Some(ModelPayload::of(&rig(601.0)).unwrap()),
            objects: vec![ModelPayload::of(&cube(0.041)).unwrap()],
            n_images: 20,
            before_px: 1.0,
            after_px: 0.1,
            ..Proposal::none(id.clone(), 1)
        };
        let object = ObjectId::new("cube").unwrap();
        Self {
            rig: kept(&bus, &keys.config_rig(), &rig(600.0)),
            object: kept(&bus, &keys.config_object(&object), &cube(0.04)),
            _proposal: kept(&bus, &keys.proposal(&id), &proposal),
            answers: bus
                .latest_publisher(&keys.config_answer(&id), Qos::Config)
                .unwrap(),
            bus,
            keys,
            id,
        }
    }

    /// Runs a command while the node takes changes, of which it answers those of the rig and those that `answers` says.
    fn run(&self, words: &[&str], answers: impl Fn(&ObjectConfig) -> bool) -> Output {
        let key = self.keys.alive(NodeKind::Fusion, &self.id);
        let _alive = self.bus.alive(&key).unwrap();
        let all = self.keys.all_config();
        let changes = self
            .bus
            .subscribe(&all, 64, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES);
        let changes = changes.unwrap();
        let mut command = sextant();
        let connect = &self.bus.endpoints()[0];
        command
            .args(words)
            .args(["--site", "lab", "--connect", connect]);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = child.spawn().unwrap();
        let deadline = Instant::now() + Duration::from_secs(60);
        while child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "it does not end");
            let Some(item) = changes.recv_timeout(Duration::from_millis(20)) else {
                continue;
            };
            let is_answered = match self.keys.parse(&item.key) {
                Some(KeyRef::ConfigRig) => {
                    self.rig.keep(&item.decode().unwrap()).unwrap();
                    true
                }
                _ => {
                    let object = item.decode().unwrap();
                    self.object.keep(&object).unwrap();
                    answers(&object)
                }
            };
            if is_answered {
                let answer = ConfigAnswer {
                    node: self.id.clone(),
                    key: item.key.clone(),
                    fingerprint: fingerprint(item.bytes().unwrap()),
                    outcome: Outcome::Taken,
                };
                self.answers.put(&answer).unwrap();
            }
        }
        child.wait_with_output().unwrap()
    }

    fn in_force(&self) -> (RigConfig, ObjectConfig) {
        let latest = |key: &str| {
            let found = self
                .bus
                .latest(key, limits::MAX_PAYLOAD_BYTES, Duration::from_secs(1));
            found.unwrap().remove(0)
        };
        let object = self.keys.all_config_objects();
        let rig = latest(&self.keys.config_rig()).decode().unwrap();
        (rig, latest(&object).decode().unwrap())
    }
}

fn kept<M: Message>(bus: &Bus, key: &str, message: &M) -> Latest<M> {
    let latest = bus.latest_publisher(key, Qos::Config).unwrap();
    latest.put(message).unwrap();
    latest
}

#[test]
fn a_change_without_an_answer_is_set_back_and_that_is_said() {
    let node = Node::open();
    // The node takes the new size, but nobody hears of it.
    let output = node.run(&["config", "apply-refinement"], |object| {
        *object == cube(0.04)
    });
    let words = stderr(&output);
    assert_eq!(output.status.code(), Some(4), "{words}");
    assert!(words.contains("the site is as it was before"), "{words}");
    assert!(words.contains("main has not answered"), "{words}");
    assert_eq!(node.in_force(), (rig(600.0), cube(0.04)));
}

#[test]
fn where_no_answer_comes_at_all_what_is_in_force_is_said() {
    let node = Node::open();
    let output = node.run(&["config", "apply-refinement"], |_| false);
    let words = stderr(&output);
    assert_eq!(output.status.code(), Some(4), "{words}");
    for part in [
        "the rig is as before, object cube is as before",
        "config get rig",
        "config revert",
    ] {
        assert!(words.contains(part), "{part}: {words}");
    }
    assert_eq!(node.in_force(), (rig(600.0), cube(0.04)));
}
