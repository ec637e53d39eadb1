//! A message as one line for people, or as it is for programs.

use crate::words;
use serde::Serialize;
use sextant_proto::{
    AnyMessage, CameraSettings, CameraStatus, ChangeOutcome, ClockReport, ConfigAnswer,
    DetectionReport, FusionInputs, FusionStatus, Heartbeat, NodeId, ObjectConfig, ObjectLinks,
    ObjectPose, Observations, Part, Proposal, RigConfig,
};
use sextant_site_model::CameraId;

/// A message as JSON for programs: as in the contract, but with the length of a preview in place of its image.
#[derive(Serialize)]
#[serde(untagged)]
pub enum JsonMessage<'a> {
    /// Anything but a preview.
    Whole(&'a AnyMessage),
    /// A preview.
    Preview {
        camera: &'a CameraId,
        sequence: u64,
        capture_ns: u64,
        resolution: [u16; 2],
        jpeg_bytes: usize,
    },
    /// A proposal with its models in place of their payloads.
    Proposal {
        node: &'a NodeId,
        t_ns: u64,
        rig: Option<RigConfig>,
        objects: Vec<ObjectConfig>,
        n_images: u32,
        before_px: f64,
        after_px: f64,
    },
}

impl<'a> From<&'a AnyMessage> for JsonMessage<'a> {
    fn from(message: &'a AnyMessage) -> Self {
        match message {
            AnyMessage::Preview(preview) => Self::Preview {
                camera: &preview.camera,
                sequence: preview.sequence,
                capture_ns: preview.capture_ns,
                resolution: preview.resolution,
                jpeg_bytes: preview.jpeg.len(),
            },
            AnyMessage::Proposal(proposal) => Self::Proposal {
                node: &proposal.node,
                t_ns: proposal.t_ns,
                rig: proposal.rig_config().ok().flatten(),
                objects: proposal.object_configs().unwrap_or_default(),
                n_images: proposal.n_images,
                before_px: proposal.before_px,
                after_px: proposal.after_px,
            },
            other => Self::Whole(other),
        }
    }
}

/// The message as one line.
pub fn text_of(message: &AnyMessage) -> String {
    match message {
        AnyMessage::Observations(message) => observations(message),
        AnyMessage::Preview(preview) => format!("{} bytes of JPEG", preview.jpeg.len()),
        AnyMessage::CameraStatus(status) => camera_status(status),
        AnyMessage::ObjectPose(pose) => object_pose(pose),
        AnyMessage::ObjectTruth(truth) => format!(
            "off by {:.2} mm, {:.3} deg",
            truth.position_error_m * 1e3,
            truth.attitude_error_rad.to_degrees()
        ),
        AnyMessage::FusionStatus(status) => fusion_status(status),
        AnyMessage::RigConfig(rig) => rig_config(rig),
        AnyMessage::ObjectConfig(object) => object_config(object),
        AnyMessage::ObjectLinks(links) => object_links(links),
        AnyMessage::ClockReport(report) => clock_report(report),
        AnyMessage::ConfigAnswer(answer) => config_answer(answer),
        AnyMessage::DetectionReport(report) => detection_report(report),
        AnyMessage::Proposal(proposal) => self::proposal(proposal),
        AnyMessage::FusionInputs(message) => fusion_inputs(message),
        AnyMessage::CameraSettings(settings) => camera_settings(settings),
        AnyMessage::Heartbeat(beat) => heartbeat(beat),
    }
}

/// The capture time of a message, where it has one.
pub fn capture_ns(message: &AnyMessage) -> Option<u64> {
    match message {
        AnyMessage::Observations(message) => Some(message.capture_ns),
        AnyMessage::Preview(message) => Some(message.capture_ns),
        AnyMessage::DetectionReport(message) => Some(message.capture_ns),
        AnyMessage::ObjectPose(message) => Some(message.capture_ns),
        AnyMessage::ObjectTruth(message) => Some(message.capture_ns),
        AnyMessage::ObjectLinks(message) => Some(message.capture_ns),
        _ => None,
    }
}

fn observations(message: &Observations) -> String {
    let tags = message.tags.iter().map(|tag| {
        let [x, y] = [0, 1].map(|axis| tag.corners.iter().map(|c| c[axis]).sum::<f32>() / 4.0);
        format!("{}:{} at {x:.1} {y:.1}", tag.family, tag.id)
    });
    let tags: Vec<String> = tags.collect();
    if tags.is_empty() {
        format!("image {}: no tags", message.sequence)
    } else {
        format!("image {}: {}", message.sequence, tags.join(", "))
    }
}

fn object_pose(pose: &ObjectPose) -> String {
    let [x, y, z] = pose.position;
    let [qx, qy, qz, qw] = pose.orientation;
    let sigma = |from: usize| {
        let variances = (from..from + 3).map(|k| pose.covariance[k * 7]);
        variances.fold(0.0, f64::max).sqrt()
    };
    format!(
        "{:<12} position {x:8.4} {y:8.4} {z:8.4} m  orientation {qx:7.4} {qy:7.4} {qz:7.4} \
         {qw:7.4}  sigma {:.2} mm {:.3} deg  cameras {} tags {}",
        words::state(pose.state),
        sigma(0) * 1e3,
        sigma(3).to_degrees(),
        pose.cameras,
        pose.tags
    )
}

fn object_links(message: &ObjectLinks) -> String {
    let joints = message.joints.iter().map(|joint| {
        let sigma = joint.variance.sqrt();
        format!(
            "{} {:.4} (sigma {sigma:.4}, {:+.3}/s)",
            joint.joint, joint.value, joint.velocity
        )
    });
    let links = message.links.iter().map(|link| {
        let [x, y, z] = link.position;
        format!("{} at {x:.4} {y:.4} {z:.4} m", link.link)
    });
    format!(
        "{:<12} joints: {}; links: {}",
        words::state(message.state),
        joints.collect::<Vec<_>>().join(", "),
        links.collect::<Vec<_>>().join(", ")
    )
}

fn detection_report(report: &DetectionReport) -> String {
    let (ms, rejected) = (&report.stage_ms, &report.rejected);
    format!(
        "image {}: {} from {}: {} no quad, {} misshapen, {} faint, {} without a code, {} hardly \
         legible; ms: tiles {:.3} threshold {:.3} components {:.3} quads {:.3} decode {:.3} refine {:.3}",
        report.sequence,
        words::count(report.tags as usize, "tag"),
        words::count(report.candidates as usize, "candidate"),
        rejected.not_a_quad,
        rejected.shape,
        rejected.faint_border,
        rejected.no_code,
        rejected.small_margin,
        ms.tiles,
        ms.threshold,
        ms.components,
        ms.quads,
        ms.decode,
        ms.refine
    )
}

fn camera_settings(settings: &CameraSettings) -> String {
    let said = [
        settings.exposure_us.map(|us| format!("exposure {us} us")),
        settings.gain.map(|gain| format!("gain {gain}")),
        settings.rate_hz.map(|hz| format!("{hz} images/s")),
    ];
    let said: Vec<String> = said.into_iter().flatten().collect();
    if said.is_empty() {
        "all up to the camera".to_owned()
    } else {
        said.join(", ")
    }
}

fn camera_status(status: &CameraStatus) -> String {
    let mut line = format!(
        "{} on {}: {:.1} images/s, {} captured, {} detected, {} dropped, detection {:.1} ms (99 %: {:.1} ms)",
        status.version,
        status.host,
        status.rate_hz,
        status.captured,
        status.detected,
        status.dropped,
        status.detect_ms[0],
        status.detect_ms[1]
    );
    for finding in words::camera_findings(status) {
        line.push_str("; ");
        line.push_str(&finding.words);
    }
    line
}

fn fusion_status(status: &FusionStatus) -> String {
    let objects = status.objects.iter().map(|object| {
        let state = words::state(object.state);
        format!("{} {state} {:.1}/s", object.object, object.rate_hz)
    });
    let refused: u64 = status.cameras.iter().map(|c| c.rejected.total()).sum();
    let duty = match status.epoch {
        Some(_) => "",
        None => "standby, ",
    };
    let mut line = format!(
        "{}: {duty}{} cameras, objects: {}; {} payloads refused",
        status.version,
        status.cameras.len(),
        objects.collect::<Vec<_>>().join(", "),
        refused + status.foreign.total()
    );
    for finding in words::findings(status) {
        line.push_str("; ");
        line.push_str(&finding.words);
    }
    line
}

fn rig_config(rig: &RigConfig) -> String {
    let cameras = rig.cameras.iter().map(|camera| {
        let [width, height] = camera.resolution;
        let place = match (&camera.world_from_camera, &camera.mount) {
            (_, Some(mount)) => format!(" (on {})", mount.carrier),
            (Some(_), None) => String::new(),
            (None, None) => " (not calibrated)".to_owned(),
        };
        format!("{} {width}x{height}{place}", camera.id)
    });
    format!("cameras: {}", cameras.collect::<Vec<_>>().join(", "))
}

fn fusion_inputs(message: &FusionInputs) -> String {
    let n_inputs = message.inputs.len();
    format!("{n_inputs} inputs from number {}", message.first)
}

fn heartbeat(beat: &Heartbeat) -> String {
    let others = beat.heard.iter().map(|heard| heard.node.to_string());
    let others = others.collect::<Vec<_>>().join(", ");
    if let Some(sharing) = &beat.sharing {
        let parts = sharing.objects.iter().map(|one| one.part);
        let n_published = parts.filter(|part| matches!(part, Part::Publishing(_)));
        let (n_published, n_tracked) = (n_published.count(), sharing.objects.len());
        return format!("publishes {n_published} of {n_tracked} objects; others: {others}");
    }
    match beat.epoch {
        Some(epoch) => format!("publishes, epoch {epoch}; others: {others}"),
        None => format!("stands by; others: {others}"),
    }
}

fn clock_report(report: &ClockReport) -> String {
    if report.cameras.is_empty() {
        return "every clock is taken at its word".to_owned();
    }
    let clocks = report.cameras.iter().map(|clock| {
        let drift = clock
            .drift
            .map_or_else(String::new, |drift| format!(", {:+.1} ppm", drift * 1e6));
        format!(
            "{} {:+.3} ms (sigma {:.3}{drift})",
            clock.camera,
            clock.offset_s * 1e3,
            clock.sigma_s * 1e3
        )
    });
    format!("clocks: {}", clocks.collect::<Vec<_>>().join(", "))
}

fn config_answer(answer: &ConfigAnswer) -> String {
    let key = words::plain(&answer.key);
    let outcome = words::outcome(&answer.outcome);
    match &answer.outcome {
        ChangeOutcome::Refused(refusal) => {
            format!("{key} {outcome}: {}", words::plain(&refusal.to_string()))
        }
        _ => format!("{key} {outcome}"),
    }
}

fn proposal(proposal: &Proposal) -> String {
    if proposal.is_empty() {
        return "nothing is proposed".to_owned();
    }
    let objects = proposal.object_configs().unwrap_or_default();
    let rig = proposal.rig.iter().map(|_| "the rig".to_owned());
    let models = rig.chain(objects.iter().map(|object| format!("object {}", object.id)));
    let models = models.collect::<Vec<_>>().join(", ");
    match proposal.n_images {
        0 => format!("as before the last change: {models}"),
        n_images => format!(
            "{models}: {:.3} px to {:.3} px on {}",
            proposal.before_px,
            proposal.after_px,
            words::count(n_images as usize, "held-back image")
        ),
    }
}

fn object_config(object: &ObjectConfig) -> String {
    if object.is_removal() {
        return "removed".to_owned();
    }
    let tags = object.tags.iter();
    let tags = tags.map(|tag| format!("{}:{}", tag.family, tag.id));
    let tags = format!("tags: {}", tags.collect::<Vec<_>>().join(", "));
    if object.links.is_empty() {
        return tags;
    }
    let joints = object.joints.iter();
    let joints =
        joints.map(|joint| format!("{} from {} to {}", joint.id, joint.parent, joint.child));
    format!(
        "{}; joints: {}; {tags}",
        words::count(object.links.len(), "link"),
        joints.collect::<Vec<_>>().join(", "),
    )
}
