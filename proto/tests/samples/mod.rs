//! One message of each kind with every field away from its default, for the golden files and the mutations.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test file takes the samples that it needs, and a test may panic"
)]

use sextant_estimator::{CameraId, JointId, JointKind, LinkId, ObjectId, Stamp, State};
use sextant_proto::*;
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
        messages: vec!["10 images dropped: the detector is too slow".into()],
    }
}

pub fn object_pose() -> ObjectPose {
    ObjectPose {
        object: object(),
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
        faults: vec!["camera south sends, but the rig does not name it".into()],
    }
}

pub fn rig_config() -> RigConfig {
    let (fx, fy, cx, cy) = (600.0, 601.5, 319.5, 239.5);
    let with_lens = |id: &str, lens, world_from_camera| CameraConfig {
        id: CameraId::new(id).unwrap(),
        resolution: [640, 480],
        lens,
        world_from_camera,
    };
    let pose = PoseConfig {
        position: [1.0, 0.0, 1.25],
        orientation: [-1.0, 0.0, 0.0, 0.0],
    };
    let brown_conrady = LensConfig::BrownConrady {
        fx,
        fy,
        cx,
        cy,
        distortion: [-0.25, 0.125, 1e-3, -2e-3, -0.0625],
    };
    let kannala_brandt = LensConfig::KannalaBrandt {
        fx,
        fy,
        cx,
        cy,
        distortion: [0.03125, 0.0, -0.015_625, 0.5e-3],
    };
    RigConfig {
        cameras: vec![
            with_lens("north", LensConfig::Pinhole { fx, fy, cx, cy }, Some(pose)),
            with_lens("south", brown_conrady, Some(pose)),
            with_lens("top", kannala_brandt, None),
        ],
    }
}

pub fn object_config() -> ObjectConfig {
    let tag = |id, object_from_tag| ObjectTagConfig {
        family: Family::Tag36h11,
        id,
        size_m: 0.04,
        object_from_tag,
    };
    let pose = PoseConfig {
        position: [0.0, 0.0, 0.03],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    ObjectConfig {
        id: object(),
        tags: vec![tag(3, Some(pose)), tag(300, None)],
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

pub fn articulated_config() -> ArticulatedConfig {
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
    let mut tags = object_config().tags.into_iter();
    let mut tag = |link| LinkTagConfig {
        link,
        tag: tags.next().unwrap(),
    };
    ArticulatedConfig {
        id: object(),
        links: vec![link("base"), link("lid"), link("foot")],
        joints: vec![hinge, joint("weld", JointKind::Fixed, "foot")],
        tags: vec![tag(1), tag(0)],
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
        outcome: Outcome::Refused,
        words: "tag tag36h11:3 is on object cube and on object box".into(),
    }
}

pub fn proposal() -> Proposal {
    Proposal {
        node: NodeId::new("fusion").unwrap(),
        t_ns: CAPTURE_NS,
        rig: Some(ModelPayload::of(&full_rig()).unwrap()),
        objects: vec![ModelPayload::of(&full_object()).unwrap()],
        n_images: 300,
        before_px: 0.75,
        after_px: 0.125,
    }
}

pub fn full_rig() -> FullRig {
    let mut cameras = rig_config().cameras.into_iter();
    let plain = |camera| FullCamera {
        camera,
        pose_sigma: None,
        lens_sigma: None,
        line_delay_s: None,
        exposure: None,
    };
    let first = plain(cameras.next().unwrap());
    let second = FullCamera {
        pose_sigma: Some(SigmaConfig {
            position_m: 0.000_5,
            orientation_rad: 0.000_25,
        }),
        lens_sigma: Some(LensSigmaConfig {
            focal_px: 0.25,
            distortion_px: 0.125,
        }),
        line_delay_s: Some(-2.5e-5),
        exposure: Some(ExposureConfig {
            length_s: 0.004,
            stamp: Stamp::End,
        }),
        ..plain(cameras.next().unwrap())
    };
    FullRig {
        cameras: [first, second]
            .into_iter()
            .chain(cameras.map(plain))
            .collect(),
    }
}

pub fn full_object() -> FullObject {
    let arm = articulated_config();
    let known = SigmaConfig {
        position_m: 0.000_125,
        orientation_rad: 0.002,
    };
    let sigmas = [Some(known), None];
    let tags = arm.tags.into_iter().zip(sigmas);
    FullObject {
        id: arm.id,
        links: arm.links,
        joints: arm.joints,
        tags: tags
            .map(|(LinkTagConfig { link, tag }, sigma)| FullTag { link, tag, sigma })
            .collect(),
    }
}
