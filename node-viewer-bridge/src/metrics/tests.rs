//! Figures of a small site: as text, as verdict, against the dashboard, at their bounds.

use super::health::SILENCE;
use super::*;
use crate::inventory::samples::status;
use sextant_proto::{
    CameraClock, CameraConfig, CameraControls, CameraIntake, ClockQuality, LensConfig,
    ObjectTagConfig, Rejections, TagObservation, Timing,
};
use sextant_site_report::{Fault, State};

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
        sequence: 1,
        capture_ns: CAPTURE_NS,
        exposure_ns: 0,
        clock: ClockQuality::default(),
        resolution: [640, 480],
        timing: Timing {
            received_ns: CAPTURE_NS + 10 * MS,
            detected_ns: CAPTURE_NS + 14 * MS,
            published_ns: CAPTURE_NS + 14 * MS,
        },
        tags: tags.iter().map(tag).collect(),
    }
}

fn pose() -> ObjectPose {
    let mut covariance = [0.0; 36];
    covariance[7] = 4e-6;
    ObjectPose {
        object: cube(),
        epoch: 1,
        sequence: 1,
        capture_ns: CAPTURE_NS,
        published_ns: CAPTURE_NS + 30 * MS,
        state: State::Tracking,
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        covariance,
        twist: [0.0; 6],
        cameras: 2,
        tags: 3,
        rms_px: 0.25,
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
        world_from_camera_sigma: None,
        line_delay_s: None,
        exposure: None,
    };
    RigConfig {
        cameras: ids.iter().map(camera).collect(),
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
        version: "0.1.0".to_owned(),
        host: "a \"board\"".to_owned(),
        captured: 100,
        detected: 90,
        dropped: 10,
        rate_hz: 30.0,
        detect_ms: [4.0, 8.0],
        clock: ClockQuality::default(),
        uptime_s: 60,
        published: 90,
        fallbacks: 0,
        brightness: 100.0,
        controls: CameraControls::default(),
        notices: Vec::new(),
    }
}

/// Figures of a site on which everything works, `age` after its last news.
struct Site {
    metrics: Metrics,
    start: Instant,
}

impl Site {
    fn new() -> Self {
        let (metrics, start) = (Metrics::default(), Instant::now());
        let site = Self { metrics, start };
        let now = site.after(Duration::ZERO);
        let north = NodeId::new("north").unwrap();
        site.metrics
            .presence(NodeKind::Fusion, &fusion(), true, now);
        site.metrics.presence(NodeKind::Camera, &north, true, now);
        site.metrics.rig(&rig(&["north"]));
        site.metrics.object(&object());
        site.works(Duration::ZERO);
        site
    }

    fn after(&self, age: Duration) -> Moment {
        Moment {
            at: self.start + age,
            ns: CAPTURE_NS + 40 * MS,
        }
    }

    /// News of everything at this age.
    fn works(&self, age: Duration) {
        let (metrics, now) = (&self.metrics, self.after(age));
        metrics.camera_status(&camera_status(), now);
        metrics.observations(&image("north", &[3, 8]), now);
        metrics.fusion_status(&fusion_status(), now);
        metrics.pose(&pose(), now);
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
        metrics.clocks(&report, now);
    }

    fn text(&self) -> String {
        let bridge = BridgeFigures {
            is_connected: true,
            uptime_s: 5.0,
            clients: 1,
            replaced: 0,
            rejected: serde_json::json!({ "damaged": 1 }),
        };
        self.metrics.text(&bridge, self.start)
    }

    /// What ails it at this age.
    fn abouts(&self, age: Duration) -> Vec<String> {
        let ailments = self.metrics.ailments(self.start + age);
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
    assert_eq!(site.abouts(SILENCE), Vec::<String>::new());
    let silent = SILENCE + Duration::from_millis(1);
    assert_eq!(site.abouts(silent), ["fusion main", "camera north"]);
}

#[test]
fn a_camera_of_the_rig_that_is_not_there_is_lost() {
    let site = Site::new();
    site.metrics.rig(&rig(&["north", "south"]));
    assert_eq!(site.abouts(Duration::ZERO), ["camera south"]);
    let down = "sextant_node_up{kind=\"camera\",node=\"south\"} 0\n";
    assert!(site.text().contains(down));
}

#[test]
fn without_a_fusion_node_nothing_else_is_needed() {
    let site = Site::new();
    let now = site.after(Duration::ZERO);
    site.metrics
        .presence(NodeKind::Fusion, &fusion(), false, now);
    assert_eq!(site.abouts(Duration::ZERO), ["fusion"]);
}

#[test]
fn visible_tags_without_a_pose_are_an_ailment_and_hidden_ones_are_none() {
    let site = Site::new();
    let seconds = Duration::from_secs;
    for second in 1..8 {
        let now = site.after(seconds(second));
        site.metrics.observations(&image("north", &[3]), now);
        site.metrics.fusion_status(&fusion_status(), now);
    }
    assert_eq!(site.abouts(seconds(7)), ["object cube"]);
    for second in 8..14 {
        let now = site.after(seconds(second));
        site.metrics.observations(&image("north", &[]), now);
        site.metrics.fusion_status(&fusion_status(), now);
    }
    assert_eq!(site.abouts(seconds(13)), Vec::<String>::new());
    // Seen again after a long pause: the first pose may take its time.
    let now = site.after(seconds(30));
    site.works(seconds(29));
    site.metrics.observations(&image("north", &[3]), now);
    assert_eq!(site.abouts(seconds(30)), Vec::<String>::new());
}

#[test]
fn a_flood_of_ids_ends_at_the_bounds() {
    let site = Site::new();
    let now = site.after(Duration::ZERO);
    for n in 0..4 * MAX_OBJECTS {
        let id = format!("x{n}");
        let mut forged = pose();
        forged.object = ObjectId::new(&id).unwrap();
        site.metrics.pose(&forged, now);
        site.metrics.observations(&image(&id, &[]), now);
        site.metrics.fusion_status(&status(&id, &[]), now);
        let node = NodeId::new(&id).unwrap();
        site.metrics.presence(NodeKind::Viewer, &node, true, now);
    }
    let figures = site.metrics.lock();
    let sizes = [
        figures.cameras.len(),
        figures.objects.len(),
        figures.fusion.len(),
        figures.alive.len(),
    ];
    assert_eq!(
        sizes,
        [MAX_CAMERAS, MAX_OBJECTS, MAX_FUSION_NODES, MAX_NODES]
    );
    assert!(figures.cameras.get(&camera("north")).is_some());
}
