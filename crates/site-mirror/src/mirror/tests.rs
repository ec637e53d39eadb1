//! Messages of a small site: ids, epochs, silence, limits, restarts and garbage.

use super::*;
use crate::limits::{SILENCE_NS, TAGS};
use proptest::prelude::*;
use sextant_proto::{
    CameraStatus, Keys, Message, MessageKind, ObjectPose, ObjectTagConfig, Observations, encode,
};
use sextant_site_report::State;
use sextant_tag_families::Family;

const START_NS: u64 = 1_000_000_000_000;
const SECOND_NS: u64 = 1_000_000_000;

fn object_id(name: &str) -> ObjectId {
    ObjectId::new(name).unwrap()
}

fn camera_id(name: &str) -> CameraId {
    CameraId::new(name).unwrap()
}

fn node_id(name: &str) -> NodeId {
    NodeId::new(name).unwrap()
}

/// The message of a golden file of the contract.
macro_rules! golden {
    ($name:literal) => {
        serde_json::from_str(include_str!(concat!("../../../../proto/golden/", $name))).unwrap()
    };
}

fn pose(object: &str, epoch: u64) -> ObjectPose {
    ObjectPose {
        object: object_id(object),
        epoch,
        ..golden!("object_pose.json")
    }
}

fn image(camera: &str) -> Observations {
    Observations {
        camera: camera_id(camera),
        ..golden!("observations.json")
    }
}

fn camera_status(camera: &str) -> CameraStatus {
    CameraStatus {
        camera: camera_id(camera),
        ..golden!("camera_status.json")
    }
}

fn status(node: &str, epoch: Option<u64>, objects: &[(&str, f32)]) -> FusionStatus {
    let health = |(id, rate_hz): &(&str, f32)| ObjectHealth {
        object: object_id(id),
        state: State::Tracking,
        rate_hz: *rate_hz,
    };
    FusionStatus {
        node: node_id(node),
        epoch,
        cameras: Vec::new(),
        objects: objects.iter().map(health).collect(),
        ..golden!("fusion_status.json")
    }
}

fn config(object: &str, tags: impl Iterator<Item = u32>) -> ObjectConfig {
    let tag = |id| ObjectTagConfig {
        family: Family::Tag36h11,
        id,
        size_m: 0.04,
        size_sigma_m: None,
        link: None,
        object_from_tag: None,
        object_from_tag_sigma: None,
    };
    ObjectConfig {
        tags: tags.map(tag).collect(),
        ..ObjectConfig::removal(object_id(object))
    }
}

fn tag(id: u32) -> TagId {
    let family = Family::Tag36h11;
    TagId { family, id }
}

/// A mirror and its time.
#[derive(Default)]
struct Heard {
    mirror: SiteMirror,
    now_ns: u64,
}

impl Heard {
    fn after(seconds: u64) -> Self {
        Self {
            now_ns: START_NS + seconds * SECOND_NS,
            ..Self::default()
        }
    }

    fn hear<M: Message>(&mut self, key: KeyRef, message: &M) -> Result<Vec<ObjectId>, Rejection> {
        let payload = encode(message).unwrap();
        let sender = Some("fusion/main");
        let update = self.mirror.handle(self.now_ns, &key, sender, Ok(&payload));
        update.map(|update| update.gone)
    }

    fn pose(&mut self, object: &str, epoch: u64) -> Result<Vec<ObjectId>, Rejection> {
        self.hear(KeyRef::Pose(object_id(object)), &pose(object, epoch))
    }

    fn status(&mut self, status: &FusionStatus) -> Vec<ObjectId> {
        self.hear(KeyRef::FusionStatus(status.node.clone()), status)
            .unwrap()
    }

    fn config(&mut self, config: &ObjectConfig) -> Result<Vec<ObjectId>, Rejection> {
        self.hear(KeyRef::ConfigObject(config.id.clone()), config)
    }
}

#[test]
fn a_message_that_names_another_id_than_its_key_is_dropped_and_counted() {
    let mut site = Heard::after(0);
    let (a, b) = (camera_id("a"), node_id("b"));
    let refused = [
        site.hear(KeyRef::Pose(object_id("ball")), &pose("cube", 1)),
        site.hear(KeyRef::Observations(a.clone()), &image("b")),
        site.hear(KeyRef::CameraStatus(a), &camera_status("b")),
        site.hear(KeyRef::FusionStatus(b), &status("main", None, &[])),
        site.hear(
            KeyRef::ConfigObject(object_id("ball")),
            &config("cube", 0..1),
        ),
    ];
    assert!(refused.iter().all(|one| *one == Err(Rejection::WrongId)));
    assert_eq!(site.mirror.rejections().invalid(), 5);
    assert_eq!(
        site.mirror.objects().count() + site.mirror.cameras().count(),
        0
    );
    assert_eq!(site.mirror.fusion_nodes().count(), 0);
}

#[test]
fn refused_payloads_are_counted_by_cause() {
    let mut mirror = SiteMirror::default();
    let key = KeyRef::Pose(object_id("cube"));
    let mut foreign = encode(&pose("cube", 1)).unwrap();
    foreign[1] = 9;
    let other_kind = encode(&camera_status("north")).unwrap();
    for payload in [b"garbage".as_slice(), &foreign, &other_kind] {
        mirror.handle(1, &key, None, Ok(payload)).unwrap_err();
    }
    let too_long = Err(DecodeError::TooLong(1 << 20));
    mirror.handle(1, &key, None, too_long).unwrap_err();
    let token = KeyRef::Alive(NodeKind::Camera, node_id("north"));
    mirror.handle(1, &token, None, Ok(&other_kind)).unwrap_err();
    let counted = serde_json::to_value(mirror.rejections()).unwrap();
    for (cause, count) in [
        ("bad_magic", 2),
        ("foreign_version", 1),
        ("wrong_kind", 1),
        ("too_long", 1),
    ] {
        assert_eq!(counted[cause], count, "{cause}: {counted}");
    }
}

#[test]
fn poses_of_a_replaced_publisher_are_dropped_and_counted_apart() {
    let mut site = Heard::after(0);
    site.pose("cube", 7).unwrap();
    assert_eq!(site.pose("cube", 6), Err(Rejection::Superseded));
    site.pose("ball", 6).unwrap();
    let rejections = site.mirror.rejections();
    assert_eq!((rejections.superseded(), rejections.invalid()), (1, 0));
    let cube = site.mirror.object(&object_id("cube")).unwrap();
    assert_eq!(cube.pose.as_ref().unwrap().message.epoch, 7);
}

#[test]
fn what_is_silent_says_so() {
    let mut site = Heard::after(0);
    let north = camera_id("north");
    let id = node_id("north");
    site.mirror
        .handle_joined(START_NS, NodeKind::Camera, &id)
        .unwrap();
    site.hear(KeyRef::CameraStatus(north.clone()), &camera_status("north"))
        .unwrap();
    site.hear(KeyRef::Observations(north.clone()), &image("north"))
        .unwrap();
    site.pose("cube", 1).unwrap();
    let is_silent_at = |now_ns: u64| {
        let camera = site.mirror.camera(&north).unwrap();
        let object = site.mirror.object(&object_id("cube")).unwrap();
        let node = site.mirror.node(NodeKind::Camera, &id).unwrap();
        [
            camera.lacks_images(0, now_ns),
            object.recent_pose(now_ns).is_none(),
            node.is_silent(now_ns),
        ]
    };
    assert_eq!(is_silent_at(START_NS + SILENCE_NS), [false; 3]);
    assert_eq!(is_silent_at(START_NS + SILENCE_NS + 1), [true; 3]);
}

#[test]
fn an_object_is_gone_when_no_fusion_node_has_it_any_more() {
    let mut site = Heard::after(0);
    site.config(&config("cube", 3..4)).unwrap();
    site.now_ns += SILENCE_NS;
    let both = [("box", 30.0), ("cube", 30.0)];
    assert_eq!(site.status(&status("a", Some(1), &both)), []);
    assert_eq!(site.status(&status("b", None, &[("cube", 0.0)])), []);
    assert_eq!(site.status(&status("a", Some(1), &[])), [object_id("box")]);
    assert_eq!(site.mirror.tag(tag(3)).unwrap().0, &object_id("cube"));
    assert_eq!(site.status(&status("b", None, &[])), [object_id("cube")]);
    assert_eq!(site.mirror.tag(tag(3)), None);
    let cube = site.mirror.object(&object_id("cube")).unwrap();
    assert_eq!((&cube.config, cube.gone_ns), (&None, Some(site.now_ns)));
    site.config(&config("cube", 3..4)).unwrap();
    let cube = site.mirror.object(&object_id("cube")).unwrap();
    assert_eq!(cube.gone_ns, None);
}

/// An object is removed and comes back at once; the other node's status is of the time between.
#[test]
fn an_object_that_was_just_announced_is_not_gone_by_a_status_from_before() {
    let mut site = Heard::after(0);
    for node in ["a", "b"] {
        site.status(&status(node, None, &[("cube", 30.0)]));
    }
    site.config(&config("cube", 3..4)).unwrap();
    site.config(&config("cube", 0..0)).unwrap();
    site.status(&status("a", Some(1), &[]));
    site.config(&config("cube", 3..4)).unwrap();
    assert_eq!(site.status(&status("b", None, &[])), []);
    assert_eq!(site.mirror.configs().count(), 1);
    site.status(&status("a", Some(1), &[("cube", 30.0)]));
    site.now_ns += 2 * SILENCE_NS;
    assert_eq!(site.status(&status("b", None, &[])), []);
    assert_eq!(site.mirror.configs().count(), 1);
    // None of them had it: it is gone some seconds later.
    site.config(&config("box", 5..6)).unwrap();
    site.status(&status("b", None, &[("box", 1.0)]));
    assert_eq!(site.status(&status("b", None, &[])), []);
    site.now_ns += SILENCE_NS;
    assert_eq!(site.status(&status("b", None, &[])), [object_id("box")]);
}

#[test]
fn a_removal_counts_when_a_fusion_node_announces_it() {
    let mut site = Heard::after(0);
    site.config(&config("cube", 3..4)).unwrap();
    let removal = config("cube", 0..0);
    let key = KeyRef::ConfigObject(object_id("cube"));
    let payload = encode(&removal).unwrap();
    for sender in [None, Some("somebody")] {
        let update = site.mirror.handle(START_NS, &key, sender, Ok(&payload));
        assert_eq!(update.unwrap().gone, []);
        assert_eq!(site.mirror.configs().count(), 1);
    }
    assert_eq!(site.config(&removal), Ok(vec![object_id("cube")]));
    assert_eq!(site.mirror.configs().count(), 0);
}

/// A node that starts again has another epoch and may have other objects; late messages of its former life do no harm.
#[test]
fn a_node_that_starts_again_takes_its_place() {
    let mut site = Heard::after(0);
    let main = node_id("main");
    site.mirror
        .handle_joined(START_NS, NodeKind::Fusion, &main)
        .unwrap();
    site.status(&status("main", Some(5), &[("ball", 9.0), ("cube", 9.0)]));
    site.pose("cube", 5).unwrap();
    site.mirror.handle_left(START_NS, NodeKind::Fusion, &main);
    let left = *site.mirror.node(NodeKind::Fusion, &main).unwrap();
    assert_eq!(left.liveliness, Liveliness::Gone);
    let now_ns = START_NS + SECOND_NS;
    site.now_ns = now_ns;
    site.mirror
        .handle_joined(now_ns, NodeKind::Fusion, &main)
        .unwrap();
    let alive: Vec<_> = site.mirror.alive(NodeKind::Fusion).collect();
    assert_eq!(alive, [(&main, now_ns)]);
    site.pose("cube", 6).unwrap();
    assert_eq!(site.pose("cube", 5), Err(Rejection::Superseded));
    let gone = site.status(&status("main", Some(6), &[("cube", 9.0)]));
    assert_eq!(gone, [object_id("ball")]);
    assert_eq!(site.mirror.statuses().count(), 1);
}

#[test]
fn the_publisher_of_an_object_speaks_for_it() {
    let mut site = Heard::after(0);
    site.status(&status("a", Some(4), &[("ball", 0.0), ("cube", 30.0)]));
    site.status(&status("b", Some(5), &[("ball", 20.0), ("cube", 0.0)]));
    site.status(&status("c", None, &[("ball", 0.0), ("cube", 0.0)]));
    let healths = site.mirror.healths();
    let rates: Vec<f32> = healths.values().map(|health| health.rate_hz).collect();
    assert_eq!(rates, [20.0, 30.0]);
}

#[test]
fn what_nothing_is_heard_of_is_forgotten_unless_a_node_lives_or_lists_it() {
    let mut site = Heard::after(0);
    let main = node_id("main");
    site.mirror
        .handle_joined(START_NS, NodeKind::Fusion, &main)
        .unwrap();
    for object in ["ball", "cube"] {
        site.config(&config(object, 3..4)).unwrap();
    }
    site.hear(KeyRef::CameraStatus(camera_id("n")), &camera_status("n"))
        .unwrap();
    site.status(&status("old", Some(1), &[("ball", 1.0)]));
    site.now_ns += FORGOTTEN_NS - 1;
    site.status(&status("main", Some(2), &[("cube", 1.0)]));
    site.now_ns += 1;
    assert_eq!(site.mirror.expire(site.now_ns), [object_id("ball")]);
    let objects: Vec<_> = site.mirror.objects().map(|(id, _)| id.as_str()).collect();
    assert_eq!(objects, ["cube"]);
    let nodes: Vec<_> = site.mirror.nodes().map(|(_, id, _)| id.as_str()).collect();
    assert_eq!((nodes, site.mirror.cameras().count()), (vec!["main"], 0));
    assert_eq!(site.mirror.tag(tag(3)).unwrap().0, &object_id("cube"));
}

#[test]
fn floods_of_ids_end_at_the_limits_and_drive_nothing_out() {
    let mut site = Heard::after(0);
    site.config(&config("real", 3..4)).unwrap();
    for n in 0..2 * OBJECTS {
        let id = format!("x{n}");
        let _ = site.pose(&id, 1);
        let _ = site.hear(KeyRef::Observations(camera_id(&id)), &image(&id));
        let _ = site.hear(KeyRef::FusionStatus(node_id(&id)), &status(&id, None, &[]));
        let id = node_id(&id);
        let _ = site.mirror.handle_joined(START_NS, NodeKind::Viewer, &id);
    }
    let mirror = &site.mirror;
    let sizes = [
        mirror.objects().count(),
        mirror.cameras().count(),
        mirror.fusion_nodes().count(),
        mirror.nodes().count(),
    ];
    assert_eq!(sizes, [OBJECTS, CAMERAS, FUSION_NODES, NODES]);
    assert!(mirror.object(&object_id("real")).is_some());
    assert!(mirror.rejections().too_many() > 0);
    // Later a new object takes the place of one that was silent, with its tags.
    site.now_ns += FORGOTTEN_NS;
    site.pose("late", 1).unwrap();
    assert_eq!(site.mirror.objects().count(), OBJECTS);
    assert_eq!(site.mirror.tag(tag(3)), None);
}

#[test]
fn a_flood_of_tags_ends_at_the_limit() {
    let mut site = Heard::after(0);
    let taken = (0..40).filter(|n| site.config(&config(&format!("x{n}"), 0..1000)).is_ok());
    assert_eq!(taken.count(), TAGS / 1000);
    // Those that are kept may change, and what they leave is free.
    site.config(&config("x0", 7..8)).unwrap();
    site.config(&config("y", 0..999)).unwrap();
    let n_real = Family::Tag36h11.data().codes.len() as u32;
    assert_eq!(site.mirror.tag(tag(n_real)), None);
    assert_eq!(site.mirror.tag(tag(7)).unwrap(), (&object_id("x0"), 0.04));
}

#[test]
fn a_model_that_makes_no_sense_is_refused() {
    let mut site = Heard::after(0);
    let twice = config("cube", [3, 3].into_iter());
    let refused = site.config(&twice).unwrap_err();
    assert!(matches!(refused, Rejection::InvalidModel(_)), "{refused:?}");
    assert_eq!(site.mirror.objects().count(), 0);
}

fn any_key() -> impl Strategy<Value = KeyRef> {
    let ids = prop::sample::select(vec!["a", "b"]);
    (0..20_usize, ids).prop_map(|(which, id)| {
        let keys = Keys::new("s").unwrap();
        let paths = [
            "camera/ID/observations",
            "camera/ID/preview",
            "camera/ID/detection",
            "camera/ID/status",
            "object/ID/pose",
            "object/ID/links",
            "object/ID/truth",
            "fusion/ID/status",
            "fusion/ID/clocks",
            "fusion/ID/inputs",
            "fusion/ID/heartbeat",
            "fusion/ID/answer",
            "fusion/ID/proposal",
            "fusion/ID/former",
            "fusion/ID/former/rig",
            "fusion/ID/former/object/ID",
            "config/rig",
            "config/object/ID",
            "config/camera/ID",
            "alive/camera/ID",
        ];
        let path = paths[which].replace("ID", id);
        keys.parse(&format!("sextant/v1/s/{path}")).unwrap()
    })
}

/// Bytes behind a valid header, or damaged messages of the site.
fn any_payload() -> impl Strategy<Value = Vec<u8>> {
    let valid = prop::sample::select(vec![
        encode(&pose("a", 3)).unwrap(),
        encode(&image("b")).unwrap(),
        encode(&camera_status("a")).unwrap(),
        encode(&status("b", Some(3), &[("a", 1.0), ("b", 2.0)])).unwrap(),
        encode(&config("a", 1..3)).unwrap(),
        encode(&config("b", 0..0)).unwrap(),
    ]);
    let damaged = (
        valid,
        any::<prop::sample::Index>(),
        any::<u8>(),
        any::<bool>(),
    );
    let damaged = damaged.prop_map(|(mut bytes, index, byte, is_damaged)| {
        if is_damaged {
            let at = index.index(bytes.len());
            bytes[at] = byte;
        }
        bytes
    });
    let kind = prop::sample::select(MessageKind::ALL.to_vec());
    let body = prop::collection::vec(any::<u8>(), 0..200);
    let framed =
        (kind, body.clone()).prop_map(|(kind, body)| [vec![0x53, 1, kind as u8, 0], body].concat());
    prop_oneof![damaged, framed, body]
}

proptest! {
    /// Any payloads and tokens at any times: no panic, nothing kept that its key does not name, and each refusal
    /// counted.
    #[test]
    fn any_bytes_do_no_harm(
        events in prop::collection::vec(
            (any_key(), any_payload(), any::<u64>(), prop::option::of("[a-z/]{0,8}")), 1..60
        )
    ) {
        let mut mirror = SiteMirror::default();
        let mut n_refused = 0;
        for (key, payload, now_ns, sender) in events {
            if let KeyRef::Alive(kind, id) = &key {
                mirror.handle_joined(now_ns, *kind, id).unwrap();
                mirror.handle_left(now_ns / 2, *kind, id);
            }
            let update = mirror.handle(now_ns, &key, sender.as_deref(), Ok(&payload));
            n_refused += u64::from(update.is_err());
            mirror.expire(now_ns);
            let _ = (mirror.healths(), mirror.intakes(), mirror.clocks());
        }
        let counts = mirror.rejections();
        prop_assert_eq!(counts.invalid() + counts.superseded() + counts.too_many(), n_refused);
        prop_assert!(mirror.configs().all(|config| !config.is_removal()));
        let n_tags: usize = mirror.configs().map(|config| config.tags.len()).sum();
        prop_assert_eq!(mirror.tags.len(), n_tags);
    }
}
