//! One message of each kind with every field away from its default, for the golden files and the mutations.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file takes the samples that it needs, and a test may panic"
)]

use sextant_proto::*;
use sextant_site_model::{CameraId, JointId, JointKind, LinkId, ObjectId, Stamp, TagId};
use sextant_site_report::{Fault, Imperfection, State};
use sextant_tag_families::Family;

const CAPTURE_NS: u64 = 1_800_000_000_123_456_789;

fn camera() -> CameraId {
    CameraId::new("north").unwrap()
}

fn object() -> ObjectId {
    ObjectId::new("cube").unwrap()
}

pub fn observations() -> Observations {
    let pose = |rms_px| TagPose {
        position: [0.125, -0.25, 1.5],
        orientation: [1.0, 0.0, 0.0, 0.0],
        rms_px,
    };
    let corners = [
        [100.25, 80.5],
        [140.75, 81.0],
        [139.5, 121.125],
        [99.0, 120.0],
    ];
    Observations {
        camera: camera(),
        sequence: 300,
        capture_ns: CAPTURE_NS,
        exposure_ns: 4_000_000,
        clock: ClockQuality {
            source: ClockSource::Ntp,
            error_ns: 250_000,
        },
        resolution: [640, 480],
        timing: Timing {
            received_ns: CAPTURE_NS + 2_500_000,
            detected_ns: CAPTURE_NS + 9_000_000,
            published_ns: CAPTURE_NS + 9_100_000,
        },
        tags: vec![
            TagObservation {
                family: Family::Tag36h11,
                id: 586,
                hamming: 1,
                margin: 61.5,
                corners,
                corner_covariance: [[0.0025, -0.000_5, 0.005]; 4],
                corner_cross_covariance: [[0.000_25, -0.001, 0.000_5, -0.000_25]; 6],
                poses: vec![pose(0.0625), pose(1.75)],
            },
            TagObservation {
                family: Family::Tag25h9,
                id: 3,
                hamming: 0,
                margin: 88.0,
                corners,
                corner_covariance: [[0.0, 0.0, 0.0]; 4],
                corner_cross_covariance: [[0.0; 4]; 6],
                poses: vec![],
            },
        ],
    }
}

pub fn preview() -> Preview {
    Preview {
        camera: camera(),
        sequence: 301,
        capture_ns: CAPTURE_NS,
        resolution: [1280, 800],
        jpeg: vec![0xff, 0xd8, 0x00, 0x7f, 0xff, 0xd9],
    }
}

pub fn detection_report() -> DetectionReport {
    DetectionReport {
        camera: camera(),
        sequence: 302,
        capture_ns: CAPTURE_NS,
        resolution: [640, 480],
        searched: 0.25,
        stage_ms: StageTimes {
            tiles: 0.0625,
            threshold: 0.125,
            components: 0.25,
            quads: 0.03125,
            decode: 0.5,
            refine: 0.75,
        },
        noise_sigma: 1.5,
        contrast_gate: 20,
        components: 300,
        candidates: 12,
        dropped: 1,
        tags: 3,
        rejected: RejectionCounts {
            not_a_quad: 4,
            shape: 2,
            faint_border: 200,
            no_code: 1,
            small_margin: 5,
        },
        examples: vec![RejectedCandidate {
            cause: RejectionCause::NoCode,
            corners: [[10.5, 20.0], [30.25, 20.5], [30.0, 40.0], [-1.5, 39.5]],
        }],
    }
}

pub fn camera_status() -> CameraStatus {
    CameraStatus {
        camera: camera(),
        version: "0.1.0".into(),
        host: "board-7".into(),
        captured: 10_000,
        detected: 9_990,
        dropped: 10,
        rate_hz: 29.75,
        detect_ms: [4.25, 6.5],
        clock: ClockQuality {
            source: ClockSource::Ptp,
            error_ns: 900,
        },
        uptime_s: 333,
        published: 9_990,
        fallbacks: 31,
        brightness: 118.5,
        controls: CameraControls {
            exposure_us: Control {
                wanted: Some(4000.0),
                value: Some(3900.0),
                range: Some([100.0, 33_000.0]),
            },
            gain: Control::default(),
            rate_hz: Control {
                wanted: None,
                value: Some(30.0),
                range: None,
            },
            outcome: SettingsOutcome::Adjusted {
                detail: "exposure 3900 µs instead of 4000".to_owned(),
            },
        },
        notices: vec![
            CameraNotice::NoImage { silent_s: 12.0 },
            CameraNotice::NameTaken {
                host: "board-8".into(),
            },
            CameraNotice::ImageRefused {
                detail: "`tags` is out of range".into(),
            },
            CameraNotice::NotInRig,
            CameraNotice::ModelRefused {
                key: "config/rig".into(),
                detail: "the payload is damaged".into(),
            },
            CameraNotice::TooManyTags {
                key: "config/object/cube".into(),
            },
        ],
    }
}

pub fn camera_settings() -> CameraSettings {
    CameraSettings {
        camera: camera(),
        exposure_us: Some(4000.0),
        gain: Some(2.5),
        rate_hz: None,
    }
}

pub fn object_pose() -> ObjectPose {
    ObjectPose {
        object: object(),
        epoch: CAPTURE_NS - 60_000_000_000,
        sequence: 77,
        capture_ns: CAPTURE_NS,
        published_ns: CAPTURE_NS + 15_000_000,
        state: State::Tracking,
        position: [1.5, -2.25, 0.75],
        orientation: [0.0, 0.6, 0.0, 0.8],
        covariance: std::array::from_fn(|k| {
            if k % 7 == 0 {
                1e-6
            } else {
                (k as f64 - 17.5) * 1e-9
            }
        }),
        twist: [0.5, 0.25, -0.125, 3.0, -2.0, 1.0],
        cameras: 3,
        tags: 5,
        rms_px: 0.125,
    }
}

pub fn object_truth() -> ObjectTruth {
    ObjectTruth {
        object: object(),
        capture_ns: CAPTURE_NS,
        position: [1.5, -2.25, 0.751],
        orientation: [0.0, 0.6, 0.0, 0.8],
        position_error_m: 0.001,
        attitude_error_rad: 0.002,
    }
}

pub fn fusion_status() -> FusionStatus {
    let rejected = Rejections {
        bad_magic: 1,
        foreign_version: 2,
        wrong_kind: 3,
        damaged: 4,
        too_long: 5,
        out_of_range: 6,
        wrong_camera: 7,
    };
    FusionStatus {
        node: NodeId::new("fusion").unwrap(),
        version: "0.1.0".into(),
        uptime_s: 60,
        epoch: Some(CAPTURE_NS - 60_000_000_000),
        cameras: vec![CameraIntake {
            camera: camera(),
            received: 1_828,
            rejected,
            unknown_tags: 9,
            late: 8,
            gated: 10,
            last_capture_ns: CAPTURE_NS,
            rate_hz: 30.0,
        }],
        foreign: Rejections {
            wrong_camera: 300,
            ..Rejections::default()
        },
        objects: vec![ObjectHealth {
            object: object(),
            state: State::Coasting,
            rate_hz: 118.5,
        }],
        faults: faults(),
        faults_left_out: 300,
        imperfections: imperfections(),
        notices: notices(),
    }
}

pub fn tag() -> TagId {
    TagId {
        family: Family::Tag25h9,
        id: 300,
    }
}

/// One of each.
fn faults() -> Vec<Fault> {
    let south = || CameraId::new("south").unwrap();
    let (object, tag) = (object(), tag());
    vec![
        Fault::CameraMoved { camera: camera() },
        Fault::CamerasDisagree {
            a: camera(),
            b: south(),
        },
        Fault::TagMisplaced {
            object: object.clone(),
            tag,
        },
        Fault::TagSize {
            object: object.clone(),
            tag,
            ratio: 1.03125,
        },
        Fault::TagElsewhere {
            object: object.clone(),
            tag,
            on: Some(ObjectId::new("box").unwrap()),
        },
        Fault::TagElsewhere {
            object,
            tag,
            on: None,
        },
        Fault::ClockOff {
            camera: camera(),
            offset_s: -0.25,
        },
        Fault::Untimely {
            camera: camera(),
            age_s: 3600.5,
        },
        Fault::DuplicateTag {
            camera: south(),
            tag,
        },
        Fault::HostClockOff { offset_s: -7200.25 },
        Fault::CameraFrozen {
            camera: camera(),
            still_s: 2.5,
        },
        Fault::LensOff { camera: south() },
        Fault::ObjectScaled {
            object: self::object(),
            ratio: 1.5,
        },
        Fault::ObjectContradicted {
            object: self::object(),
            share: 0.75,
        },
        Fault::ObjectUnplaced {
            object: self::object(),
        },
        Fault::ImageSize {
            camera: south(),
            size: [640, 480],
            of_rig: [1280, 720],
        },
        Fault::CameraTurned {
            camera: south(),
            degrees: 90,
        },
        Fault::CamerasExchanged {
            a: camera(),
            b: south(),
        },
        Fault::LensChanged {
            camera: south(),
            ratio: 1.3,
        },
        Fault::TagTurned {
            object: self::object(),
            tag,
            degrees: 180,
        },
        Fault::TagsExchanged {
            object: self::object(),
            a: tag,
            b: tag,
        },
        Fault::CameraBlind {
            camera: camera(),
            object: self::object(),
            blind_s: 6.5,
        },
    ]
}

/// One of each.
fn imperfections() -> Vec<Imperfection> {
    let (object, tag) = (object(), tag());
    vec![
        Imperfection::CamerasDisagree {
            a: camera(),
            b: CameraId::new("south").unwrap(),
            apart_m: 0.0125,
        },
        Imperfection::TagOff {
            object: object.clone(),
            tag,
            position_m: 0.002,
            orientation_rad: 0.0625,
        },
        Imperfection::SizeOff {
            object: object.clone(),
            tag,
            ratio: 0.984375,
        },
        Imperfection::FocalLengthOff {
            camera: camera(),
            ratio: 1.0078125,
        },
        Imperfection::ScaleOff {
            object,
            ratio: 0.9921875,
        },
    ]
}

/// One of each, and one for each refusal.
fn notices() -> Vec<Notice> {
    let notices = [
        Notice::CameraSilent {
            camera: camera(),
            silent_s: 4.5,
        },
        Notice::LateObservations {
            camera: camera(),
            total: 300,
        },
        Notice::Overload {
            dropped: 7,
            total: 1000,
        },
        Notice::Unpublished {
            total: 2,
            detail: "`position` is out of range".into(),
        },
        Notice::ClockStepped { by_s: -2.5 },
        Notice::NameTaken {
            host: "board-8".into(),
        },
        Notice::RefinementProposed {
            n_images: 24,
            before_px: 0.75,
            after_px: 0.5,
        },
        Notice::OldModels {
            node: NodeId::new("spare").unwrap(),
            newer: NodeId::new("fusion").unwrap(),
        },
        Notice::NotKept {
            detail: "no space left on device".into(),
        },
        Notice::SetAside {
            node: NodeId::new("fusion").unwrap(),
            by: NodeId::new("spare").unwrap(),
            t_ns: 1_800_000_000_000_000_000,
            detail: "in the rig camera north is 300.0 mm and 0.00 degrees away".into(),
        },
        Notice::CamerasSlow {
            cameras: vec![camera(), CameraId::new("south").unwrap()],
            behind_s: 1.5,
        },
    ];
    let refused = refusals().into_iter().map(|refusal| Notice::ChangeRefused {
        key: "config/rig".into(),
        sender: Some("ann@desk".into()),
        refusal,
    });
    notices.into_iter().chain(refused).collect()
}

/// One of each.
fn refusals() -> Vec<Refusal> {
    let detail = || "why".to_owned();
    vec![
        Refusal::Undecodable { detail: detail() },
        Refusal::WrongId {
            described: object(),
        },
        Refusal::NoCamera,
        Refusal::InvalidCamera {
            camera: camera(),
            detail: detail(),
        },
        Refusal::InvalidObject {
            tag: Some(tag()),
            detail: detail(),
        },
        Refusal::UnknownTag {
            tag: tag(),
            n_ids: 35,
        },
        Refusal::SharedTag {
            tag: tag(),
            first: object(),
            second: ObjectId::new("box").unwrap(),
        },
        Refusal::TooManyObjects { limit: 1024 },
        Refusal::Unpublishable { detail: detail() },
        Refusal::NotStored { detail: detail() },
        Refusal::Other { detail: detail() },
    ]
}

pub fn rig_config() -> RigConfig {
    let (fx, fy, cx, cy) = (600.0, 601.5, 319.5, 239.5);
    let pose = PoseConfig {
        position: [1.0, 0.0, 1.25],
        orientation: [-1.0, 0.0, 0.0, 0.0],
    };
    let north = CameraConfig {
        id: camera(),
        resolution: [640, 480],
        lens: LensConfig::Pinhole { fx, fy, cx, cy },
        lens_sigma: None,
        world_from_camera: Some(pose),
        mount: None,
        world_from_camera_sigma: None,
        line_delay_s: None,
        exposure: None,
    };
    let south = CameraConfig {
        id: CameraId::new("south").unwrap(),
        lens: LensConfig::BrownConrady {
            fx,
            fy,
            cx,
            cy,
            distortion: [-0.25, 0.125, 1e-3, -2e-3, -0.0625],
        },
        lens_sigma: Some(LensSigmaConfig {
            focal_px: 0.25,
            distortion_px: 0.125,
        }),
        mount: None,
        world_from_camera_sigma: Some(SigmaConfig {
            position_m: 0.000_5,
            orientation_rad: 0.000_25,
        }),
        line_delay_s: Some(-2.5e-5),
        exposure: Some(ExposureConfig {
            length_s: 0.004,
            stamp: Stamp::End,
        }),
        ..north.clone()
    };
    let top = CameraConfig {
        id: CameraId::new("top").unwrap(),
        lens: LensConfig::KannalaBrandt {
            fx,
            fy,
            cx,
            cy,
            distortion: [0.03125, 0.0, -0.015_625, 0.5e-3],
        },
        world_from_camera: None,
        mount: Some(MountConfig {
            carrier: ObjectId::new("drone").unwrap(),
            carrier_from_camera: pose,
        }),
        ..north.clone()
    };
    RigConfig {
        cameras: vec![north, south, top],
        scale_sigma: Some(0.003),
    }
}

/// An object of links; [`rigid_object_config`] is one without.
pub fn object_config() -> ObjectConfig {
    let joint = |id: &str, kind, child: &str| JointConfig {
        id: JointId::new(id).unwrap(),
        kind,
        parent: link("base"),
        child: link(child),
        axis: [0.0, 0.6, 0.8],
        parent_from_joint: PoseConfig {
            position: [0.0, 0.125, 0.25],
            orientation: [0.0, 0.0, 0.6, 0.8],
        },
        limits: None,
        max_speed: None,
    };
    let hinge = JointConfig {
        limits: Some([-1.5, 0.25]),
        max_speed: Some(3.0),
        ..joint("hinge", JointKind::Revolute, "lid")
    };
    let mut tags = rigid_object_config().tags;
    (tags[0].link, tags[1].link) = (Some(1), Some(0));
    ObjectConfig {
        id: object(),
        links: vec![link("base"), link("lid"), link("foot")],
        joints: vec![hinge, joint("weld", JointKind::Fixed, "foot")],
        tags,
        frame_sigma: Some(SigmaConfig {
            position_m: 0.000_5,
            orientation_rad: 0.004,
        }),
        scale_sigma: Some(0.001),
        world_from_object: None,
    }
}

pub fn rigid_object_config() -> ObjectConfig {
    let learned = ObjectTagConfig {
        family: Family::Tag36h11,
        id: 3,
        size_m: 0.04,
        size_sigma_m: Some(0.000_25),
        link: None,
        object_from_tag: Some(PoseConfig {
            position: [0.0, 0.0, 0.03],
            orientation: [0.0, 0.0, 0.0, 1.0],
        }),
        object_from_tag_sigma: Some(SigmaConfig {
            position_m: 0.000_125,
            orientation_rad: 0.002,
        }),
    };
    let new = ObjectTagConfig {
        family: Family::Tag25h9,
        id: 30,
        size_m: 0.03,
        size_sigma_m: None,
        link: None,
        object_from_tag: None,
        object_from_tag_sigma: None,
    };
    ObjectConfig {
        id: object(),
        links: vec![],
        joints: vec![],
        tags: vec![learned, new],
        frame_sigma: None,
        scale_sigma: None,
        world_from_object: Some(PoseConfig {
            position: [2.5, -1.0, 0.5],
            orientation: [0.0, 0.6, 0.0, 0.8],
        }),
    }
}

fn link(name: &str) -> LinkId {
    LinkId::new(name).unwrap()
}

pub fn object_links() -> ObjectLinks {
    let pose = |name: &str, z| LinkPose {
        link: link(name),
        position: [1.5, -2.25, z],
        orientation: [0.0, 0.6, 0.0, 0.8],
        covariance: object_pose().covariance,
    };
    ObjectLinks {
        object: object(),
        epoch: CAPTURE_NS - 60_000_000_000,
        sequence: 77,
        capture_ns: CAPTURE_NS,
        published_ns: CAPTURE_NS + 15_000_000,
        state: State::Tracking,
        links: vec![pose("base", 0.75), pose("lid", 0.875)],
        joints: vec![JointState {
            joint: JointId::new("hinge").unwrap(),
            value: -0.5,
            variance: 1e-6,
            velocity: 2.5,
            velocity_variance: 1e-2,
        }],
    }
}

pub fn fusion_inputs() -> FusionInputs {
    let image = InputSource::Image {
        camera: camera(),
        sequence: 4711,
        capture_ns: 1_800_000_000_000_000_000,
    };
    let sources = [
        InputSource::Rig(0xcbf2_9ce4_8422_2325),
        InputSource::Objects(vec![0x8594_4171_f739_67e8, 0]),
        image,
        InputSource::ClockStep,
        InputSource::Tick,
        InputSource::Adjusted,
    ];
    let input = |(k, source)| FusionInput {
        now_ns: 1_800_000_000_020_000_000 + k,
        source,
    };
    FusionInputs {
        node: NodeId::new("fusion").unwrap(),
        first: 0,
        inputs: (0_u64..).zip(sources).map(input).collect(),
    }
}

pub fn heartbeat() -> Heartbeat {
    Heartbeat {
        node: NodeId::new("fusion").unwrap(),
        sent_ns: 300_000_000_000,
        epoch: None,
        newest: CAPTURE_NS - 60_000_000_000,
        heard: vec![HeardBeat {
            node: NodeId::new("spare").unwrap(),
            sent_ns: 7_250_000_000,
        }],
        sharing: Some(Sharing {
            standbys: Some(1),
            objects: (["ball", "box", "cube"].into_iter())
                .zip([
                    Part::Preparing,
                    Part::Ready,
                    Part::Publishing(CAPTURE_NS - 60_000_000_000),
                ])
                .map(|(object, part)| Share {
                    object: ObjectId::new(object).unwrap(),
                    part,
                })
                .collect(),
        }),
        models: ModelsState {
            version: Some(ModelsVersion {
                counter: 7,
                t_ns: CAPTURE_NS - 3_600_000_000_000,
                author: NodeId::new("spare").unwrap(),
            }),
            fingerprint: 0xfedc_ba98_7654_3210,
        },
    }
}

pub fn clock_report() -> ClockReport {
    ClockReport {
        node: NodeId::new("fusion").unwrap(),
        cameras: vec![
            CameraClock {
                camera: camera(),
                offset_s: -0.012_5,
                sigma_s: 0.000_125,
                drift: Some(-2.5e-5),
            },
            CameraClock {
                camera: CameraId::new("south").unwrap(),
                offset_s: 0.25,
                sigma_s: 0.5,
                drift: None,
            },
        ],
    }
}

pub fn config_answer() -> ConfigAnswer {
    ConfigAnswer {
        node: NodeId::new("fusion").unwrap(),
        key: "config/object/cube".into(),
        fingerprint: 0x0123_4567_89ab_cdef,
        outcome: ChangeOutcome::Refused(Refusal::SharedTag {
            tag: tag(),
            first: object(),
            second: ObjectId::new("box").unwrap(),
        }),
        followers: vec![NodeId::new("spare").unwrap()],
        behind: vec![NodeId::new("third").unwrap()],
    }
}

pub fn proposal() -> Proposal {
    Proposal {
        node: NodeId::new("fusion").unwrap(),
        t_ns: CAPTURE_NS,
        rig: Some(ModelPayload::encode(&rig_config()).unwrap()),
        objects: vec![ModelPayload::encode(&object_config()).unwrap()],
        n_images: 300,
        before_px: 0.75,
        after_px: 0.125,
    }
}
