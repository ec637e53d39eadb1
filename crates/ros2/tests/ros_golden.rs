//! Bytes and type hashes equal those of other implementations: rosbags wrote the files of `golden/`, and Fast CDR reads
//! them (`golden/oracle.py`, which `cargo xtask ros2` runs again).

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_ros2::messages::{
    AprilTagDetection, AprilTagDetectionArray, Byte, CameraInfo, CompressedImage, DiagnosticArray,
    DiagnosticStatus, Float64MultiArray, Header, KeyValue, MocapMarker, MultiArrayDimension,
    MultiArrayLayout, NamedPose, NamedPoseArray, Odometry, PixelPoint, Point, Pose,
    PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, RegionOfInterest, RigidBodies,
    RigidBody, TFMessage, Transform, TransformStamped, Twist, TwistWithCovariance, Vector3,
};
use sextant_ros2::{RosMessage, definition, encode, type_hash};
use std::path::Path;

fn golden(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden");
    std::fs::read(folder.join(name)).expect("a golden file")
}

/// The same bytes, and the hash of the same type.
fn compare<M: RosMessage>(name: &str, message: &M) {
    let expected = golden(&format!("{name}.cdr"));
    assert_eq!(encode(message), expected, "{name}");
    let hashes = String::from_utf8(golden("hashes.txt")).expect("a text");
    let line = format!("{} {}", M::TYPE_NAME, type_hash::<M>());
    assert!(hashes.lines().any(|known| known == line), "{line}");
}

fn header(sec: u64, nanosec: u64, frame: &str) -> Header {
    Header::new(sec * 1_000_000_000 + nanosec, frame)
}

fn transform(header: Header, child: &str, [x, y, z]: [f64; 3], q: [f64; 4]) -> TransformStamped {
    TransformStamped {
        header,
        child_frame_id: child.to_owned(),
        transform: Transform {
            translation: Vector3 { x, y, z },
            rotation: quaternion(q),
        },
    }
}

fn quaternion([x, y, z, w]: [f64; 4]) -> Quaternion {
    Quaternion { x, y, z, w }
}

#[test]
fn transforms() {
    let transforms = vec![
        transform(
            header(1_700_000_000, 123_456_789, "world"),
            "cube",
            [1.5, -2.25, 0.125],
            [0.5, -0.5, 0.5, 0.5],
        ),
        transform(
            header(1_700_000_000, 999_999_999, "world"),
            "pad-2",
            [-1e-3, 1e6, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ),
    ];
    compare("tf", &TFMessage { transforms });
    let transforms = Vec::new();
    compare("tf-empty", &TFMessage { transforms });
}

#[test]
fn poses() {
    let pose = Pose {
        position: Point {
            x: 0.25,
            y: -0.5,
            z: 1.75,
        },
        orientation: quaternion([0.5, 0.5, -0.5, 0.5]),
    };
    let covariance = std::array::from_fn(|k| k as f64 / 8.0);
    let message = PoseWithCovarianceStamped {
        header: header(1_700_000_001, 5, "map"),
        pose: PoseWithCovariance {
            pose: pose.clone(),
            covariance,
        },
    };
    compare("pose", &message);
    let vector = |x, y, z| Vector3 { x, y, z };
    let twist = Twist {
        linear: vector(1.0, -2.0, 0.5),
        angular: vector(0.25, 0.0, -4.0),
    };
    let odometry = Odometry {
        header: header(1_700_000_001, 6, "map"),
        child_frame_id: "cube".to_owned(),
        pose: PoseWithCovariance {
            pose: pose.clone(),
            covariance,
        },
        twist: TwistWithCovariance { twist, covariance },
    };
    compare("odometry", &odometry);
    let named = |name: &str| NamedPose {
        name: name.to_owned(),
        pose: pose.clone(),
    };
    let poses = NamedPoseArray {
        header: header(1_700_000_001, 7, "map"),
        poses: vec![named("cube"), named("pad-2")],
    };
    compare("named-poses", &poses);
    let marker = MocapMarker {
        id_type: 2,
        marker_index: -3,
        marker_name: "tag36h11:3".to_owned(),
        translation: pose.position.clone(),
    };
    let body = |name: &str, markers: Vec<MocapMarker>| RigidBody {
        rigid_body_name: name.to_owned(),
        markers,
        pose: pose.clone(),
    };
    let bodies = RigidBodies {
        header: header(1_700_000_001, 8, "map"),
        frame_number: 9,
        rigidbodies: vec![
            body("cube", vec![marker.clone(), marker]),
            body("pad-2", Vec::new()),
        ],
    };
    compare("rigid-bodies", &bodies);
}

#[test]
fn lenses() {
    let message = CameraInfo {
        header: header(1_700_000_002, 0, "north_optical"),
        height: 480,
        width: 640,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![-0.25, 0.125, 0.001, -0.002, 0.5],
        k: [600.0, 0.0, 319.5, 0.0, 601.0, 239.5, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [
            600.0, 0.0, 319.5, 0.0, 0.0, 601.0, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0,
        ],
        binning_x: 0,
        binning_y: 0,
        roi: RegionOfInterest {
            x_offset: 1,
            y_offset: 2,
            height: 3,
            width: 4,
            do_rectify: true,
        },
    };
    compare("camera-info", &message);
}

#[test]
fn pictures() {
    let message = CompressedImage {
        header: header(1_700_000_003, 1, "n_optical"),
        format: "jpeg".to_owned(),
        data: vec![0xff, 0xd8, 0xff, 0xe0, 0x00, 0xff, 0xd9],
    };
    compare("picture", &message);
}

#[test]
fn detections() {
    let point = |x, y| PixelPoint { x, y };
    let detection = AprilTagDetection {
        family: "tag36h11".to_owned(),
        id: 586,
        hamming: 1,
        goodness: 0.0,
        decision_margin: 61.5,
        centre: point(320.25, 240.75),
        corners: [
            point(300.0, 260.0),
            point(340.5, 261.0),
            point(341.0, 220.0),
            point(299.5, 221.0),
        ],
        homography: [20.0, 1.0, 320.25, -1.0, 20.5, 240.75, 0.001, -0.002, 1.0],
    };
    let message = AprilTagDetectionArray {
        header: header(1_700_000_004, 2, "east_optical"),
        detections: vec![detection.clone(), detection],
    };
    compare("detections", &message);
}

#[test]
fn diagnostics() {
    let value = |key: &str, value: &str| KeyValue {
        key: key.to_owned(),
        value: value.to_owned(),
    };
    let status = |level, [name, message, hardware]: [&str; 3], values| DiagnosticStatus {
        level: Byte(level),
        name: name.to_owned(),
        message: message.to_owned(),
        hardware_id: hardware.to_owned(),
        values,
    };
    let message = DiagnosticArray {
        header: header(1_700_000_005, 3, ""),
        status: vec![
            status(
                0,
                ["sextant: camera north", "30.0 images/s", "pi-1"],
                vec![value("images", "7"), value("µ", "")],
            ),
            status(
                2,
                [
                    "sextant: fusion main",
                    "camera east is not where the rig says",
                    "",
                ],
                Vec::new(),
            ),
        ],
    };
    compare("diagnostics", &message);
}

#[test]
fn numbers() {
    let axis = MultiArrayDimension {
        label: "sigma_m rms_px".to_owned(),
        size: 2,
        stride: 2,
    };
    let layout = MultiArrayLayout {
        dim: vec![axis],
        data_offset: 0,
    };
    let data = vec![0.001, 0.25];
    compare("quality", &Float64MultiArray { layout, data });
}

#[test]
fn a_definition_has_the_fields_and_then_the_types_that_they_refer_to() {
    let rule = "=".repeat(80);
    let expected = format!(
        "geometry_msgs/TransformStamped[] transforms\n\
         {rule}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
         {rule}\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n\
         {rule}\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n\
         {rule}\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\n\
         string child_frame_id\ngeometry_msgs/Transform transform\n\
         {rule}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n\
         {rule}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    );
    assert_eq!(definition::<TFMessage>(), expected);
    let info = definition::<CameraInfo>();
    assert!(info.contains("\nfloat64[] d\nfloat64[9] k\n") && info.contains("\nbool do_rectify\n"));
}
