//! Figures of a small site: as text, as verdict, against the dashboard, at their bounds.

use super::*;
use crate::forwarder::tests::status;
use sextant_proto::{
    CameraClock, CameraConfig, CameraIntake, CameraStatus, ClockReport, FusionStatus, KeyRef,
    LensConfig, Message, NodeId, NodeKind, ObjectConfig, ObjectPose, ObjectTagConfig, PoseConfig,
    Rejections, RigConfig, TagObservation, Timing, encode,
};
use sextant_site_mirror::limits::{CAMERAS, OBJECTS, SILENCE_NS};
use sextant_site_report::Fault;
use sextant_tag_families::Family;

/// The message of a golden file of the contract.
macro_rules! golden {
    ($name:literal) => {
        serde_json::from_str(include_str!(concat!("../../../proto/golden/", $name))).unwrap()
    };
}

const CAPTURE_NS: u64 = 1_800_000_000_000_000_000;
const MS: u64 = 1_000_000;

fn camera(id: &str) -> CameraId {
    CameraId::new(id).unwrap()
}

fn cube() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

fn fusion() -> NodeId {
    NodeId::new("main").unwrap()
}

fn image(id: &str, tags: &[u32]) -> Observations {
    let tag = |id: &u32| TagObservation {
        family: Family::Tag36h11,
        id: *id,
        hamming: 0,
        margin: 50.0,
        corners: [[0.0; 2]; 4],
        corner_covariance: [[0.1, 0.0, 0.1]; 4],
        corner_cross_covariance: [[0.0; 4]; 6],
        poses: Vec::new(),
    };
    Observations {
        camera: camera(id),
        capture_ns: CAPTURE_NS,
        timing: Timing {
            received_ns: CAPTURE_NS + 10 * MS,
            detected_ns: CAPTURE_NS + 14 * MS,
            published_ns: CAPTURE_NS + 14 * MS,
        },
        tags: tags.iter().map(tag).collect(),
        ..golden!("observations.json")
    }
}

fn pose() -> ObjectPose {
    let mut covariance = [0.0; 36];
    covariance[7] = 4e-6;
    ObjectPose {
        object: cube(),
        capture_ns: CAPTURE_NS,
        published_ns: CAPTURE_NS + 30 * MS,
        covariance,
        ..golden!("object_pose.json")
    }
}

fn rig(ids: &[&str]) -> RigConfig {
    let camera = |id: &&str| CameraConfig {
        id: camera(id),
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
    RigConfig {
        cameras: ids.iter().map(camera).collect(),
        scale_sigma: None,
    }
}

fn object() -> ObjectConfig {
    ObjectConfig {
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
    }
}

fn fusion_status() -> FusionStatus {
    let intake = CameraIntake {
        camera: camera("north"),
        received: 9,
        rejected: Rejections {
            damaged: 2,
            ..Rejections::default()
        },
        unknown_tags: 4,
        late: 1,
        gated: 5,
        last_capture_ns: CAPTURE_NS,
        rate_hz: 30.0,
    };
    FusionStatus {
        cameras: vec![intake],
        faults: vec![Fault::CameraMoved {
            camera: camera("north"),
        }],
        ..status("main", &["cube"])
    }
}

fn camera_status() -> CameraStatus {
    CameraStatus {
        camera: camera("north"),
        host: "a \"board\"".to_owned(),
        captured: 100,
        detect_ms: [4.0, 8.0],
        ..golden!("camera_status.json")
    }
}

/// A site on which everything works, and its figures.
struct Site {
    mirror: SiteMirror,
    metrics: Metrics,
}

const SECOND_NS: u64 = 1_000_000_000;

impl Site {
    fn new() -> Self {
        let mut site = Self {
            mirror: SiteMirror::default(),
            metrics: Metrics::default(),
        };
        let north = NodeId::new("north").unwrap();
        let mirror = &mut site.mirror;
        mirror
            .handle_joined(0, NodeKind::Fusion, &fusion())
            .unwrap();
        mirror.handle_joined(0, NodeKind::Camera, &north).unwrap();
        site.hear(0, KeyRef::ConfigRig, &rig(&["north"]));
        site.hear(0, KeyRef::ConfigObject(cube()), &object());
        site.works(0);
        site
    }

    /// Hears a message at this time of the monotonic clock.
    fn hear<M: Message>(&mut self, at_ns: u64, key: KeyRef, message: &M) {
        let payload = encode(message).unwrap();
        let update = self.mirror.handle(at_ns, &key, None, Ok(&payload));
        let wall_ns = CAPTURE_NS + 40 * MS;
        let now = Moment { at_ns, wall_ns };
        if let Ok(update) = update {
            self.metrics.count(&update.message, &self.mirror, now);
        }
    }

    fn sees(&mut self, at_ns: u64, tags: &[u32]) {
        let key = KeyRef::Observations(camera("north"));
        self.hear(at_ns, key, &image("north", tags));
    }

    fn fuses(&mut self, at_ns: u64) {
        self.hear(at_ns, KeyRef::FusionStatus(fusion()), &fusion_status());
    }

    /// News of everything at this time.
    fn works(&mut self, at_ns: u64) {
        let key = KeyRef::CameraStatus(camera("north"));
        self.hear(at_ns, key, &camera_status());
        self.sees(at_ns, &[3, 8]);
        self.fuses(at_ns);
        self.hear(at_ns, KeyRef::Pose(cube()), &pose());
        let clock = CameraClock {
            camera: camera("north"),
            offset_s: -0.002,
            sigma_s: 0.001,
            drift: None,
        };
        let report = ClockReport {
            node: fusion(),
            cameras: vec![clock],
        };
        self.hear(at_ns, KeyRef::Clocks(fusion()), &report);
    }

    fn text(&self) -> String {
        let bridge = BridgeFigures {
            is_connected: true,
            uptime_s: 5.0,
            clients: 1,
            replaced: 0,
            rejected: serde_json::json!({ "damaged": 1 }),
        };
        self.metrics.text(&self.mirror, &bridge, 0)
    }

    /// What ails it at this time.
    fn abouts(&self, now_ns: u64) -> Vec<String> {
        let ailments = self.metrics.ailments(&self.mirror, now_ns);
        ailments.into_iter().map(|ailment| ailment.about).collect()
    }
}

#[test]
fn figures_are_those_of_the_messages() {
    let text = Site::new().text();
    for line in [
        "sextant_bridge_connected 1",
        "sextant_bridge_rejected_total{cause=\"damaged\"} 1",
        "sextant_node_up{kind=\"fusion\",node=\"main\"} 1",
        "sextant_node_info{kind=\"camera\",node=\"north\",version=\"0.1.0\",host=\"a \\\"board\\\"\"} 1",
        "sextant_camera_captured_images_total{camera=\"north\"} 100",
        "sextant_camera_tags_total{camera=\"north\"} 2",
        "sextant_camera_detection_seconds{camera=\"north\",quantile=\"0.99\"} 0.008",
        "sextant_camera_clock_offset_seconds{node=\"main\",camera=\"north\"} -0.002",
        "sextant_image_stage_seconds_bucket{camera=\"north\",stage=\"capture\",le=\"0.01\"} 1",
        "sextant_image_stage_seconds_bucket{camera=\"north\",stage=\"network\",le=\"0.02\"} 0",
        "sextant_image_stage_seconds_count{camera=\"north\",stage=\"network\"} 1",
        "sextant_fusion_rejected_total{node=\"main\",camera=\"north\",cause=\"damaged\"} 2",
        "sextant_fusion_rejected_total{node=\"main\",camera=\"north\",cause=\"late\"} 1",
        "sextant_fusion_rejected_tags_total{node=\"main\",camera=\"north\",cause=\"unknown\"} 4",
        "sextant_faults{node=\"main\",kind=\"camera_moved\"} 1",
        "sextant_object_state{node=\"main\",object=\"cube\",state=\"tracking\"} 1",
        "sextant_object_state{node=\"main\",object=\"cube\",state=\"lost\"} 0",
        "sextant_poses_total{object=\"cube\"} 1",
        "sextant_pose_position_sigma_meters{object=\"cube\"} 0.002",
        "sextant_pose_latency_seconds_bucket{object=\"cube\",until=\"received\",le=\"0.05\"} 1",
    ] {
        assert!(text.lines().any(|other| other == line), "{line} of\n{text}");
    }
}

/// Names in a text that begin like ours, without what histograms hang on.
fn names(text: &str) -> BTreeSet<String> {
    let is_of_name = |c: char| c.is_ascii_lowercase() || c == '_';
    let words = text.split(|c| !is_of_name(c));
    let words = words.filter(|word| word.starts_with("sextant_"));
    let bare = |word: &str| {
        let suffixes = ["_bucket", "_sum", "_count"].into_iter();
        let mut bare = suffixes.filter_map(|suffix| word.strip_suffix(suffix));
        bare.next().unwrap_or(word).to_owned()
    };
    words.map(bare).collect()
}

#[test]
fn the_dashboard_and_the_guide_name_metrics_that_exist() {
    let ours = names(&Site::new().text());
    let dashboard = include_str!("../../../deploy/grafana/sextant.json");
    serde_json::from_str::<serde_json::Value>(dashboard).unwrap();
    for (file, text) in [
        ("sextant.json", dashboard),
        ("outputs.md", include_str!("../../../docs/outputs.md")),
    ] {
        let named = names(text);
        assert!(named.len() > 10, "{file}: {named:?}");
        let unknown: Vec<_> = named.difference(&ours).collect();
        assert!(unknown.is_empty(), "{file} names {unknown:?}");
    }
}

#[test]
fn a_site_is_well_while_everything_reports() {
    let site = Site::new();
    assert_eq!(site.abouts(SILENCE_NS), Vec::<String>::new());
    let ailing = ["fusion main", "camera north"];
    assert_eq!(site.abouts(SILENCE_NS + 1), ailing);
}

#[test]
fn a_camera_of_the_rig_that_is_not_there_is_lost() {
    let mut site = Site::new();
    site.hear(0, KeyRef::ConfigRig, &rig(&["north", "south"]));
    assert_eq!(site.abouts(0), ["camera south"]);
    let down = "sextant_node_up{kind=\"camera\",node=\"south\"} 0\n";
    assert!(site.text().contains(down));
}

#[test]
fn without_a_fusion_node_nothing_else_is_needed() {
    let mut site = Site::new();
    site.mirror.handle_left(0, NodeKind::Fusion, &fusion());
    assert_eq!(site.abouts(0), ["fusion"]);
}

#[test]
fn landmarks_need_no_pose() {
    let mut site = Site::new();
    let landmark = ObjectConfig {
        world_from_object: Some(PoseConfig {
            position: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }),
        ..object()
    };
    site.hear(0, KeyRef::ConfigObject(cube()), &landmark);
    for second in 1..6 {
        site.sees(second * SECOND_NS, &[3]);
        site.fuses(second * SECOND_NS);
    }
    assert_eq!(site.abouts(5 * SECOND_NS), Vec::<String>::new());
}

#[test]
fn visible_tags_without_a_pose_are_an_ailment_and_hidden_ones_are_none() {
    let mut site = Site::new();
    for second in 1..6 {
        site.sees(second * SECOND_NS, &[3]);
        site.fuses(second * SECOND_NS);
    }
    assert_eq!(site.abouts(5 * SECOND_NS), ["object cube"]);
    for second in 6..12 {
        site.sees(second * SECOND_NS, &[]);
        site.fuses(second * SECOND_NS);
    }
    assert_eq!(site.abouts(11 * SECOND_NS), Vec::<String>::new());
    // Seen again after a long pause: the first pose may take its time.
    site.works(29 * SECOND_NS);
    site.sees(30 * SECOND_NS, &[3]);
    assert_eq!(site.abouts(30 * SECOND_NS), Vec::<String>::new());
}

#[test]
fn what_the_site_has_no_more_is_forgotten() {
    let mut site = Site::new();
    let without = FusionStatus {
        objects: Vec::new(),
        ..fusion_status()
    };
    site.hear(4 * SECOND_NS, KeyRef::FusionStatus(fusion()), &without);
    site.metrics.keep_known(&site.mirror);
    let text = site.text();
    let left: Vec<&str> = text.lines().filter(|line| line.contains("cube")).collect();
    assert_eq!(left, Vec::<&str>::new());
}

#[test]
fn only_what_the_mirror_takes_in_is_counted() {
    let mut site = Site::new();
    for n in 0..4 * OBJECTS {
        let id = format!("x{n}");
        let forged = ObjectPose {
            object: ObjectId::new(&id).unwrap(),
            ..pose()
        };
        site.hear(0, KeyRef::Pose(forged.object.clone()), &forged);
        let key = KeyRef::Observations(camera(&id));
        site.hear(0, key, &image(&id, &[]));
    }
    let figures = site.metrics.lock();
    let sizes = [figures.cameras.len(), figures.objects.len()];
    assert_eq!(sizes, [CAMERAS, OBJECTS]);
    assert!(figures.cameras.contains_key(&camera("north")));
}
