//! The metrics by name. Names and labels are what people's dashboards rely on: docs/outputs.md lists them.

use super::Figures;
use super::record::{CameraRecord, FusionRecord, IMAGE_STAGES, ObjectRecord, POSE_STAGES};
use super::text::{Family, FamilyKind, family};
use serde::Serialize;
use sextant_proto::{NodeId, NodeKind};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::State;
use std::collections::BTreeMap;
use std::time::Instant;

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

impl Figures {
    pub(super) fn text(&self, bridge: &BridgeFigures, now: Instant) -> String {
        let mut text = String::new();
        bridge.text(&mut text);
        self.nodes(&mut text);
        self.camera_counts(&mut text);
        self.camera_gauges(&mut text, now);
        self.image_stages(&mut text);
        self.intake(&mut text);
        self.clocks(&mut text);
        self.findings(&mut text);
        self.objects(&mut text, now);
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
            for (node, _) in self.living(kind) {
                up.sample(&[("kind", kind.as_str()), ("node", node.as_str())], 1.0);
            }
        }
        let is_up = |camera: &CameraId| {
            let mut living = self.living(NodeKind::Camera);
            living.any(|(node, _)| node.as_str() == camera.as_str())
        };
        for camera in self.rig.iter().filter(|camera| !is_up(camera)) {
            up.sample(&[("kind", "camera"), ("node", camera.as_str())], 0.0);
        }
        let mut info = family(
            text,
            "sextant_node_info",
            Gauge,
            "1, with the node's version and machine as labels.",
        );
        for (camera, record) in self.cameras.iter() {
            if let Some(status) = &record.status {
                let labels = [
                    ("kind", "camera"),
                    ("node", camera.as_str()),
                    ("version", &status.version),
                    ("host", &status.host),
                ];
                info.sample(&labels, 1.0);
            }
        }
        for (node, record) in self.fusion.iter() {
            if let Some((status, _)) = &record.status {
                let labels = [
                    ("kind", "fusion"),
                    ("node", node.as_str()),
                    ("version", &status.version),
                    ("host", ""),
                ];
                info.sample(&labels, 1.0);
            }
        }
        let mut uptime = family(
            text,
            "sextant_node_uptime_seconds",
            Gauge,
            "Time since the node's process started.",
        );
        for (camera, record) in self.cameras.iter() {
            if let Some(status) = &record.status {
                uptime.sample(
                    &[("kind", "camera"), ("node", camera.as_str())],
                    status.uptime_s as f64,
                );
            }
        }
        for (node, record) in self.fusion.iter() {
            if let Some((status, _)) = &record.status {
                uptime.sample(
                    &[("kind", "fusion"), ("node", node.as_str())],
                    status.uptime_s as f64,
                );
            }
        }
    }

    fn camera_counts(&self, text: &mut String) {
        type Count = fn(&CameraRecord) -> Option<u64>;
        let counts: [(&str, Count, &str); 7] = [
            (
                "sextant_camera_captured_images_total",
                |c| Some(c.status.as_ref()?.captured),
                "Images captured.",
            ),
            (
                "sextant_camera_detected_images_total",
                |c| Some(c.status.as_ref()?.detected),
                "Images that went through the detector.",
            ),
            (
                "sextant_camera_dropped_images_total",
                |c| Some(c.status.as_ref()?.dropped),
                "Images dropped before detection, since a newer one was there.",
            ),
            (
                "sextant_camera_published_images_total",
                |c| Some(c.status.as_ref()?.published),
                "Observations handed to the network.",
            ),
            (
                "sextant_camera_received_images_total",
                |c| Some(c.images),
                "Observations that reached the bridge.",
            ),
            (
                "sextant_camera_tags_total",
                |c| Some(c.tags),
                "Tags detected in images that reached the bridge.",
            ),
            (
                "sextant_camera_back_in_time_total",
                |c| Some(c.back_in_time),
                "Stages of images that ended before they began, since clocks differ.",
            ),
        ];
        for (name, count, help) in counts {
            let mut family = family(text, name, Counter, help);
            self.per_camera(&mut family, |record| {
                count(record).map(|count| count as f64)
            });
        }
    }

    fn camera_gauges(&self, text: &mut String, now: Instant) {
        let mut rate = family(
            text,
            "sextant_camera_image_rate_hertz",
            Gauge,
            "Images detected a second, over the last seconds.",
        );
        self.per_camera(&mut rate, |record| {
            Some(record.status.as_ref()?.rate_hz.into())
        });
        let mut age = family(
            text,
            "sextant_camera_image_age_seconds",
            Gauge,
            "Time since the last observation reached the bridge.",
        );
        self.per_camera(&mut age, |record| {
            let age = now.saturating_duration_since(record.last_image?);
            Some(age.as_secs_f64())
        });
        let mut detection = family(
            text,
            "sextant_camera_detection_seconds",
            Gauge,
            "Time of detection an image, over the last seconds.",
        );
        for (camera, record) in self.cameras.iter() {
            let Some(status) = &record.status else {
                continue;
            };
            for (quantile, ms) in ["0.5", "0.99"].into_iter().zip(status.detect_ms) {
                detection.sample(
                    &[("camera", camera.as_str()), ("quantile", quantile)],
                    f64::from(ms) * 1e-3,
                );
            }
        }
        let mut error = family(
            text,
            "sextant_camera_clock_error_seconds",
            Gauge,
            "Error of the camera node's clock as its own machine estimates it.",
        );
        for (camera, record) in self.cameras.iter() {
            let Some(status) = &record.status else {
                continue;
            };
            let labels = [
                ("camera", camera.as_str()),
                ("source", status.clock.source.name()),
            ];
            error.sample(&labels, status.clock.error_ns as f64 * 1e-9);
        }
    }

    fn per_camera(&self, family: &mut Family<'_>, value: impl Fn(&CameraRecord) -> Option<f64>) {
        for (camera, record) in self.cameras.iter() {
            if let Some(value) = value(record) {
                family.sample(&[("camera", camera.as_str())], value);
            }
        }
    }

    fn image_stages(&self, text: &mut String) {
        let help = "Duration of an image's stages: capture (middle of the exposure until the detector has the image), detect, publish, network (until the bridge).";
        let mut family = family(text, "sextant_image_stage_seconds", Histogram, help);
        for (camera, record) in self.cameras.iter() {
            for (stage, histogram) in IMAGE_STAGES.into_iter().zip(&record.stages) {
                family.histogram(&[("camera", camera.as_str()), ("stage", stage)], histogram);
            }
        }
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
        for (node, record) in self.fusion.iter() {
            for camera in record.status.iter().flat_map(|(status, _)| &status.cameras) {
                sample(node.as_str(), camera);
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
        for (node, record) in self.fusion.iter() {
            for clock in &record.clocks {
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

    fn per_fusion(&self, mut sample: impl FnMut(&str, &sextant_proto::FusionStatus)) {
        for (node, FusionRecord { status, .. }) in self.fusion.iter() {
            if let Some((status, _)) = status {
                sample(node.as_str(), status);
            }
        }
    }

    fn objects(&self, text: &mut String, now: Instant) {
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
        self.per_object(&mut age, |record| {
            let (_, at) = record.pose.as_ref()?;
            Some(now.saturating_duration_since(*at).as_secs_f64())
        });
    }

    fn per_health(&self, mut sample: impl FnMut(&NodeId, &sextant_proto::ObjectHealth)) {
        for (node, record) in self.fusion.iter() {
            for object in record.status.iter().flat_map(|(status, _)| &status.objects) {
                sample(node, object);
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
        self.per_object(&mut poses, |record| Some(record.poses as f64));
        type Gauged = fn(&sextant_proto::ObjectPose) -> f64;
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
            self.per_object(&mut family, |record| Some(gauge(&record.pose.as_ref()?.0)));
        }
        let help = "Time from the middle of the exposure until the fusion node published the pose, and until the bridge received it.";
        let mut latency = family(text, "sextant_pose_latency_seconds", Histogram, help);
        for (object, record) in self.objects.iter() {
            for (until, histogram) in POSE_STAGES.into_iter().zip(&record.stages) {
                latency.histogram(&[("object", object.as_str()), ("until", until)], histogram);
            }
        }
    }

    fn per_object(&self, family: &mut Family<'_>, value: impl Fn(&ObjectRecord) -> Option<f64>) {
        for (object, record) in self.objects.iter() {
            let object: &ObjectId = object;
            if let Some(value) = value(record) {
                family.sample(&[("object", object.as_str())], value);
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

fn largest_sigma(pose: &sextant_proto::ObjectPose, from: usize) -> f64 {
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
