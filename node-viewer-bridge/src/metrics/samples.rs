//! The metrics by name. Names and labels are what people's dashboards rely on: docs/outputs.md lists them.

use super::MetricsView;
use super::figures::{CameraFigures, IMAGE_STAGES, POSE_STAGES};
use super::text::{FamilyKind, family};
use serde::Serialize;
use sextant_proto::{CameraStatus, FusionStatus, NodeId, NodeKind, ObjectPose};
use sextant_site_mirror::{Camera, Heard};
use sextant_site_report::State;
use std::collections::BTreeMap;

/// Type of the text.
pub(crate) const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Figures of the bridge itself.
#[derive(Debug)]
pub(crate) struct BridgeFigures {
    pub(crate) is_connected: bool,
    pub(crate) uptime_s: f64,
    pub(crate) clients: usize,
    /// Frames that clients skipped.
    pub(crate) replaced: u64,
    /// Payloads that could not be shown, by cause.
    pub(crate) rejected: serde_json::Value,
}

use FamilyKind::{Counter, Gauge, Histogram};

impl MetricsView<'_> {
    pub(super) fn text(&self, bridge: &BridgeFigures, now_ns: u64) -> String {
        let mut text = String::new();
        bridge.text(&mut text);
        self.nodes(&mut text);
        self.camera_counts(&mut text);
        self.camera_gauges(&mut text, now_ns);
        self.image_stages(&mut text);
        self.intake(&mut text);
        self.clocks(&mut text);
        self.findings(&mut text);
        self.objects(&mut text, now_ns);
        self.poses(&mut text);
        text
    }

    fn nodes(&self, text: &mut String) {
        let mut up = family(
            text,
            "sextant_node_up",
            Gauge,
            "1 while the node is on the network; 0 for a camera of the rig that is not.",
        );
        for kind in NodeKind::ALL {
            for (node, _) in self.site.alive(kind) {
                up.sample(&[("kind", kind.as_str()), ("node", node.as_str())], 1.0);
            }
        }
        let is_up = |camera: &str| {
            let mut alive = self.site.alive(NodeKind::Camera);
            alive.any(|(node, _)| node.as_str() == camera)
        };
        let rig = self.site.rig().into_iter().flat_map(|rig| &rig.cameras);
        let rig = rig.map(|camera| camera.id.as_str());
        for camera in rig.filter(|camera| !is_up(camera)) {
            up.sample(&[("kind", "camera"), ("node", camera)], 0.0);
        }
        let mut info = family(
            text,
            "sextant_node_info",
            Gauge,
            "1, with the node's version and machine as labels.",
        );
        self.per_node(|labels, version, host, _| {
            let more = [("version", version), ("host", host)];
            info.sample(&[labels, &more].concat(), 1.0);
        });
        let mut uptime = family(
            text,
            "sextant_node_uptime_seconds",
            Gauge,
            "Time since the node's process started.",
        );
        self.per_node(|labels, _, _, uptime_s| uptime.sample(labels, uptime_s as f64));
    }

    /// Kind and name, version, host and uptime of each node that publishes a status.
    fn per_node(&self, mut sample: impl FnMut(&[(&'static str, &str)], &str, &str, u64)) {
        self.per_camera_status(|camera, status| {
            let labels = [("kind", "camera"), ("node", camera)];
            sample(&labels, &status.version, &status.host, status.uptime_s);
        });
        self.per_fusion(|node, status| {
            let labels = [("kind", "fusion"), ("node", node)];
            sample(&labels, &status.version, "", status.uptime_s);
        });
    }

    fn per_camera_status(&self, mut sample: impl FnMut(&str, &CameraStatus)) {
        for (id, camera) in self.site.cameras() {
            if let Some(status) = &camera.status {
                sample(id.as_str(), &status.message);
            }
        }
    }

    fn camera_counts(&self, text: &mut String) {
        type Reported = fn(&CameraStatus) -> u64;
        let reported: [(&str, Reported, &str); 4] = [
            (
                "sextant_camera_captured_images_total",
                |status| status.captured,
                "Images captured.",
            ),
            (
                "sextant_camera_detected_images_total",
                |status| status.detected,
                "Images that went through the detector.",
            ),
            (
                "sextant_camera_dropped_images_total",
                |status| status.dropped,
                "Images dropped before detection, since a newer one was there.",
            ),
            (
                "sextant_camera_published_images_total",
                |status| status.published,
                "Observations handed to the network.",
            ),
        ];
        for (name, count, help) in reported {
            let mut family = family(text, name, Counter, help);
            self.per_camera_status(|camera, status| {
                family.sample(&[("camera", camera)], count(status) as f64);
            });
        }
        type Counted = fn(&CameraFigures) -> u64;
        let counted: [(&str, Counted, &str); 3] = [
            (
                "sextant_camera_received_images_total",
                |figures| figures.images,
                "Observations that reached the bridge.",
            ),
            (
                "sextant_camera_tags_total",
                |figures| figures.tags,
                "Tags detected in images that reached the bridge.",
            ),
            (
                "sextant_camera_back_in_time_total",
                |figures| figures.back_in_time,
                "Stages of images that ended before they began, since clocks differ.",
            ),
        ];
        for (name, count, help) in counted {
            let mut family = family(text, name, Counter, help);
            self.per_camera(|camera, _, figures| {
                family.sample(&[("camera", camera)], count(figures) as f64);
            });
        }
    }

    fn camera_gauges(&self, text: &mut String, now_ns: u64) {
        let mut rate = family(
            text,
            "sextant_camera_image_rate_hertz",
            Gauge,
            "Images detected a second, over the last seconds.",
        );
        self.per_camera_status(|camera, status| {
            rate.sample(&[("camera", camera)], status.rate_hz.into());
        });
        let mut age = family(
            text,
            "sextant_camera_image_age_seconds",
            Gauge,
            "Time since the last observation reached the bridge.",
        );
        self.per_camera(|camera, known, _| {
            if let Some(last_ns) = known.last_image_ns {
                age.sample(&[("camera", camera)], seconds_since(last_ns, now_ns));
            }
        });
        let mut detection = family(
            text,
            "sextant_camera_detection_seconds",
            Gauge,
            "Time of detection an image, over the last seconds.",
        );
        self.per_camera_status(|camera, status| {
            for (quantile, ms) in ["0.5", "0.99"].into_iter().zip(status.detect_ms) {
                let labels = [("camera", camera), ("quantile", quantile)];
                detection.sample(&labels, f64::from(ms) * 1e-3);
            }
        });
        let mut error = family(
            text,
            "sextant_camera_clock_error_seconds",
            Gauge,
            "Error of the camera node's clock as its own machine estimates it.",
        );
        self.per_camera_status(|camera, status| {
            let labels = [("camera", camera), ("source", status.clock.source.name())];
            error.sample(&labels, status.clock.error_ns as f64 * 1e-9);
        });
    }

    /// The cameras that were heard of, with what was counted.
    fn per_camera(&self, mut sample: impl FnMut(&str, &Camera, &CameraFigures)) {
        let none = CameraFigures::default();
        for (id, camera) in self.site.cameras() {
            if camera.heard_ns().is_some() {
                let figures = self.figures.cameras.get(id).unwrap_or(&none);
                sample(id.as_str(), camera, figures);
            }
        }
    }

    fn image_stages(&self, text: &mut String) {
        let help = "Duration of an image's stages: capture (middle of the exposure until the \
            detector has the image), detect, publish, network (until the bridge).";
        let mut family = family(text, "sextant_image_stage_seconds", Histogram, help);
        self.per_camera(|camera, _, figures| {
            for (stage, histogram) in IMAGE_STAGES.into_iter().zip(&figures.stages) {
                family.histogram(&[("camera", camera), ("stage", stage)], histogram);
            }
        });
    }

    /// What fusion nodes took in of each camera.
    fn intake(&self, text: &mut String) {
        let mut received = family(
            text,
            "sextant_fusion_received_total",
            Counter,
            "Observations that reached the fusion node, refused ones included.",
        );
        self.per_intake(|node, camera| {
            received.sample(
                &[("node", node), ("camera", camera.camera.as_str())],
                camera.received as f64,
            );
        });
        let mut rejected = family(
            text,
            "sextant_fusion_rejected_total",
            Counter,
            "Observations that the fusion node did not use, by cause.",
        );
        self.per_intake(|node, camera| {
            let late = [("late", camera.late)].map(|(cause, count)| (cause.to_owned(), count));
            for (cause, count) in counts_of(&camera.rejected).into_iter().chain(late) {
                rejected.sample(
                    &[
                        ("node", node),
                        ("camera", camera.camera.as_str()),
                        ("cause", &cause),
                    ],
                    count as f64,
                );
            }
        });
        let mut tags = family(
            text,
            "sextant_fusion_rejected_tags_total",
            Counter,
            "Tags that the fusion node did not use: of no object, or outliers.",
        );
        self.per_intake(|node, camera| {
            for (cause, count) in [("unknown", camera.unknown_tags), ("outlier", camera.gated)] {
                tags.sample(
                    &[
                        ("node", node),
                        ("camera", camera.camera.as_str()),
                        ("cause", cause),
                    ],
                    count as f64,
                );
            }
        });
    }

    fn per_intake(&self, mut sample: impl FnMut(&str, &sextant_proto::CameraIntake)) {
        for status in self.site.statuses() {
            for camera in &status.cameras {
                sample(status.node.as_str(), camera);
            }
        }
    }

    fn clocks(&self, text: &mut String) {
        let mut offset = family(
            text,
            "sextant_camera_clock_offset_seconds",
            Gauge,
            "Offset of the camera's clock as the fusion node estimates it from the motion.",
        );
        self.per_clock(|labels, clock| offset.sample(labels, clock.offset_s));
        let mut sigma = family(
            text,
            "sextant_camera_clock_offset_sigma_seconds",
            Gauge,
            "Standard deviation of this offset.",
        );
        self.per_clock(|labels, clock| sigma.sample(labels, clock.sigma_s));
    }

    fn per_clock(
        &self,
        mut sample: impl FnMut(&[(&'static str, &str)], &sextant_proto::CameraClock),
    ) {
        for (node, known) in self.site.fusion_nodes() {
            for clock in &known.clocks {
                sample(
                    &[("node", node.as_str()), ("camera", clock.camera.as_str())],
                    clock,
                );
            }
        }
    }

    /// Faults, imperfections and notices by kind.
    fn findings(&self, text: &mut String) {
        let mut faults = family(
            text,
            "sextant_faults",
            Gauge,
            "Faults of the site that the fusion node reports, by kind.",
        );
        self.per_fusion(|node, status| {
            per_kind(&status.faults, |kind, n| {
                faults.sample(&[("node", node), ("kind", kind)], n)
            });
            faults.sample(
                &[("node", node), ("kind", "left_out")],
                status.faults_left_out.into(),
            );
        });
        let mut imperfections = family(
            text,
            "sextant_imperfections",
            Gauge,
            "Errors of the site's files that poses allow for, by kind.",
        );
        self.per_fusion(|node, status| {
            per_kind(&status.imperfections, |kind, n| {
                imperfections.sample(&[("node", node), ("kind", kind)], n)
            });
        });
        let mut notices = family(
            text,
            "sextant_notices",
            Gauge,
            "Notices of the fusion node about itself and its intake, by kind.",
        );
        self.per_fusion(|node, status| {
            per_kind(&status.notices, |kind, n| {
                notices.sample(&[("node", node), ("kind", kind)], n)
            });
        });
    }

    fn per_fusion(&self, mut sample: impl FnMut(&str, &FusionStatus)) {
        for status in self.site.statuses() {
            sample(status.node.as_str(), status);
        }
    }

    fn objects(&self, text: &mut String, now_ns: u64) {
        let mut state = family(
            text,
            "sextant_object_state",
            Gauge,
            "1 for the object's state, 0 for the others.",
        );
        self.per_health(|node, object| {
            for (name, one) in STATES {
                let labels = [
                    ("node", node.as_str()),
                    ("object", object.object.as_str()),
                    ("state", name),
                ];
                state.sample(&labels, f64::from(u8::from(object.state == one)));
            }
        });
        let mut rate = family(
            text,
            "sextant_pose_rate_hertz",
            Gauge,
            "Poses of the object a second, over the last seconds.",
        );
        self.per_health(|node, object| {
            rate.sample(
                &[("node", node.as_str()), ("object", object.object.as_str())],
                object.rate_hz.into(),
            );
        });
        let mut age = family(
            text,
            "sextant_pose_age_seconds",
            Gauge,
            "Time since the object's last pose reached the bridge.",
        );
        self.per_pose(|object, pose| {
            age.sample(&[("object", object)], seconds_since(pose.at_ns, now_ns));
        });
    }

    fn per_health(&self, mut sample: impl FnMut(&NodeId, &sextant_proto::ObjectHealth)) {
        for status in self.site.statuses() {
            for object in &status.objects {
                sample(&status.node, object);
            }
        }
    }

    fn poses(&self, text: &mut String) {
        let mut poses = family(
            text,
            "sextant_poses_total",
            Counter,
            "Poses that reached the bridge.",
        );
        for (object, figures) in &self.figures.objects {
            poses.sample(&[("object", object.as_str())], figures.poses as f64);
        }
        type Gauged = fn(&ObjectPose) -> f64;
        let gauges: [(&str, Gauged, &str); 5] = [
            (
                "sextant_pose_position_sigma_meters",
                |pose| largest_sigma(pose, 0),
                "Largest standard deviation of the newest pose's position along an axis.",
            ),
            (
                "sextant_pose_orientation_sigma_radians",
                |pose| largest_sigma(pose, 3),
                "Largest standard deviation of the newest pose's attitude about an axis.",
            ),
            (
                "sextant_pose_cameras",
                |pose| pose.cameras.into(),
                "Cameras that saw the object.",
            ),
            (
                "sextant_pose_tags",
                |pose| pose.tags.into(),
                "Tags that entered the newest pose.",
            ),
            (
                "sextant_pose_reprojection_error_pixels",
                |pose| pose.rms_px.into(),
                "Root mean square reprojection error of the newest pose.",
            ),
        ];
        for (name, gauge, help) in gauges {
            let mut family = family(text, name, Gauge, help);
            self.per_pose(|object, pose| {
                family.sample(&[("object", object)], gauge(&pose.message));
            });
        }
        let help = "Time from the middle of the exposure until the fusion node published the \
            pose, and until the bridge received it.";
        let mut latency = family(text, "sextant_pose_latency_seconds", Histogram, help);
        for (object, figures) in &self.figures.objects {
            for (until, histogram) in POSE_STAGES.into_iter().zip(&figures.stages) {
                latency.histogram(&[("object", object.as_str()), ("until", until)], histogram);
            }
        }
    }

    /// The newest pose of each object that the site has.
    fn per_pose(&self, mut sample: impl FnMut(&str, &Heard<ObjectPose>)) {
        let objects = self.site.objects();
        for (id, object) in objects.filter(|(_, object)| object.gone_ns.is_none()) {
            if let Some(pose) = &object.pose {
                sample(id.as_str(), pose);
            }
        }
    }
}

impl BridgeFigures {
    fn text(&self, text: &mut String) {
        let gauges = [
            (
                "sextant_bridge_connected",
                f64::from(u8::from(self.is_connected)),
                "1 while the bridge is connected to the site's router.",
            ),
            (
                "sextant_bridge_uptime_seconds",
                self.uptime_s,
                "Time since the bridge started.",
            ),
            (
                "sextant_bridge_clients",
                self.clients as f64,
                "Connected pages and other clients of the WebSocket.",
            ),
        ];
        for (name, value, help) in gauges {
            family(text, name, Gauge, help).sample(&[], value);
        }
        family(
            text,
            "sextant_bridge_skipped_frames_total",
            Counter,
            "Messages that slow clients skipped.",
        )
        .sample(&[], self.replaced as f64);
        let mut rejected = family(
            text,
            "sextant_bridge_rejected_total",
            Counter,
            "Messages that the bridge could not use, by cause.",
        );
        for (cause, count) in numbers_of(&self.rejected) {
            rejected.sample(&[("cause", &cause)], count as f64);
        }
    }
}

const STATES: [(&str, State); 4] = [
    ("initialising", State::Initialising),
    ("tracking", State::Tracking),
    ("coasting", State::Coasting),
    ("lost", State::Lost),
];

fn seconds_since(then_ns: u64, now_ns: u64) -> f64 {
    now_ns.saturating_sub(then_ns) as f64 * 1e-9
}

fn largest_sigma(pose: &ObjectPose, from: usize) -> f64 {
    let variances = (from..from + 3).map(|axis| pose.covariance[axis * 7]);
    variances.fold(0.0, f64::max).sqrt()
}

/// Counts by the names of their fields.
fn counts_of(counts: &impl Serialize) -> Vec<(String, u64)> {
    numbers_of(&serde_json::to_value(counts).unwrap_or_default())
}

fn numbers_of(counts: &serde_json::Value) -> Vec<(String, u64)> {
    let fields = counts.as_object().into_iter().flatten();
    fields
        .filter_map(|(name, count)| Some((name.clone(), count.as_u64()?)))
        .collect()
}

/// How many there are of each variant, by its name in JSON.
fn per_kind(findings: &[impl Serialize], mut sample: impl FnMut(&str, f64)) {
    let mut counts: BTreeMap<String, u32> = BTreeMap::new();
    for finding in findings {
        let value = serde_json::to_value(finding).unwrap_or_default();
        let name = value.as_object().and_then(|variant| variant.keys().next());
        if let Some(name) = name {
            *counts.entry(name.clone()).or_default() += 1;
        }
    }
    counts
        .iter()
        .for_each(|(kind, n)| sample(kind, (*n).into()));
}
