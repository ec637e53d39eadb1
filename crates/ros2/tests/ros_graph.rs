//! Keys, liveliness tokens, GIDs and attachments equal those of zenoh-ros2-sdk and xxhash, which wrote
//! `golden/graph.txt` (`golden/oracle.py`, which `cargo xtask ros2` runs again).

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_ros2::{Attachment, Distribution, Graph, Topic, TopicKind};
use std::fmt::Write;
use std::path::Path;

const TOPICS: [(&str, TopicKind); 13] = [
    ("/tf", TopicKind::Transforms),
    ("/tf_static", TopicKind::StaticTransforms),
    ("/sextant/object/cube/pose", TopicKind::Pose),
    ("/sextant/object/cube/quality", TopicKind::Quality),
    ("/sextant/object/cube/odom", TopicKind::Odometry),
    ("/poses", TopicKind::NamedPoses),
    ("/rigid_bodies", TopicKind::RigidBodies),
    ("/sextant/camera/north/detections", TopicKind::Detections),
    ("/sextant/camera/north/camera_info", TopicKind::CameraInfo),
    ("/sextant/camera/north/image/compressed", TopicKind::Image),
    (
        "/sextant/camera/north/preview/image/compressed",
        TopicKind::Picture,
    ),
    (
        "/sextant/camera/north/preview/camera_info",
        TopicKind::PictureInfo,
    ),
    ("/diagnostics", TopicKind::Diagnostics),
];

fn golden() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    std::fs::read_to_string(folder.join("graph.txt")).expect("the golden file")
}

fn graph(namespace: &str, distribution: &str) -> Graph {
    Graph {
        domain: 42,
        distribution: distribution.parse().expect("a release"),
        session: "9aed1ea85b72095f6dbc9ee90dabd56".to_owned(),
        namespace: namespace.parse().expect("a namespace"),
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// A publisher's line, written by our own code.
fn line(distribution: &str, name: &str, kind: TopicKind) -> String {
    let topic = Topic {
        name: name.to_owned(),
        kind,
    };
    let ours = graph("sextant", distribution).publisher(7, &topic);
    let attachment = Attachment {
        sequence: 300,
        source_ns: 1_700_000_000_123_456_789,
        gid: ours.gid,
    };
    let (gid, attachment) = (hex(&ours.gid.0), hex(&attachment.to_bytes()));
    format!(
        "{distribution} {name} {} {} {gid} {attachment}",
        ours.key, ours.token
    )
}

#[test]
fn every_name_and_attachment_is_as_others_write_it() {
    let nodes = ["/sextant", "/lab/west", "/"].map(|namespace| {
        let token = graph(namespace, "jazzy").node_token();
        format!("node {namespace} {token}")
    });
    let publishers = ["jazzy", "humble"]
        .into_iter()
        .flat_map(|release| TOPICS.map(|(name, kind)| line(release, name, kind)));
    let ours: Vec<String> = nodes.into_iter().chain(publishers).collect();
    assert_eq!(ours, golden().lines().collect::<Vec<_>>());
}

#[test]
fn a_release_without_rmw_zenoh_is_refused() {
    let refused = "iron".parse::<Distribution>().expect_err("no release");
    assert!(refused.to_string().contains("kilted"), "{refused}");
}
