//! Frames, signs and pixels of what is published, and which messages lead to which.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use jpeg_encoder::{ColorType, Encoder};
use nalgebra::{Isometry3, Point2, Point3, Quaternion, Translation3, UnitQuaternion};
use sextant_geometry::Lens;
use sextant_proto::{
    CameraConfig, ClockQuality, FusionStatus, KeyRef, LensConfig, Message, NodeId, ObjectConfig,
    ObjectPose, ObjectTagConfig, Observations, PoseConfig, Preview, Rejections, RigConfig,
    TagObservation, Timing, encode,
};
use sextant_ros2::messages::{CameraInfo, Transform};
use sextant_ros2::{Also, Bridge, BridgeOptions, Outgoing, TopicKind, convert};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::State;
use sextant_tag_families::Family;

const SECOND: u64 = 1_000_000_000;
const NOW: u64 = 1_700_000_000 * SECOND;

fn camera(id: &str) -> CameraConfig {
    CameraConfig {
        id: CameraId::new(id).expect("an id"),
        resolution: [640, 480],
        lens: LensConfig::Pinhole {
            fx: 600.0,
            fy: 605.0,
            cx: 319.5,
            cy: 242.0,
        },
        lens_sigma: None,
        // 1 m above the world's origin, looking along the world's x: its right is the world's -y, its down the world's
        // -z.
        world_from_camera: Some(PoseConfig {
            position: [0.0, 0.0, 1.0],
            orientation: [-0.5, 0.5, -0.5, 0.5],
        }),
        mount: None,
        world_from_camera_sigma: None,
        line_delay_s: None,
        exposure: None,
    }
}

fn pose(object: &str, capture_ns: u64, state: State) -> ObjectPose {
    ObjectPose {
        object: ObjectId::new(object).expect("an id"),
        epoch: 1,
        sequence: 1,
        capture_ns,
        published_ns: capture_ns,
        state,
        position: [2.0, 0.25, 1.5],
        orientation: [0.0, 0.0, 0.6, 0.8],
        covariance: std::array::from_fn(|k| if k % 7 == 0 { 1e-6 } else { 1e-9 * k as f64 }),
        twist: [0.0; 6],
        cameras: 2,
        tags: 3,
        rms_px: 0.1,
    }
}

fn tag(id: u32) -> TagObservation {
    TagObservation {
        family: Family::Tag36h11,
        id,
        hamming: 1,
        margin: 50.0,
        corners: [
            [100.0, 200.0],
            [180.0, 210.0],
            [170.0, 290.0],
            [95.0, 280.0],
        ],
        corner_covariance: [[0.01, 0.0, 0.01]; 4],
        corner_cross_covariance: [[0.0; 4]; 6],
        poses: Vec::new(),
    }
}

fn image(capture_ns: u64) -> Observations {
    Observations {
        camera: CameraId::new("north").expect("an id"),
        sequence: 1,
        capture_ns,
        exposure_ns: 0,
        clock: ClockQuality::default(),
        resolution: [640, 480],
        timing: Timing::default(),
        tags: vec![tag(7)],
    }
}

fn preview(size: [u16; 2]) -> Preview {
    let mut jpeg = Vec::new();
    let pixels = vec![128; usize::from(size[0]) * usize::from(size[1])];
    let encoder = Encoder::new(&mut jpeg, 50);
    encoder
        .encode(&pixels, size[0], size[1], ColorType::Luma)
        .expect("an image");
    Preview {
        camera: CameraId::new("north").expect("an id"),
        sequence: 1,
        capture_ns: NOW,
        resolution: [640, 480],
        jpeg,
    }
}

fn motion(transform: &Transform) -> Isometry3<f64> {
    let (t, q) = (&transform.translation, &transform.rotation);
    Isometry3::from_parts(
        Translation3::new(t.x, t.y, t.z),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}

/// As a ROS node projects a point of a camera's optical frame.
fn project(info: &CameraInfo, point: Point3<f64>) -> Point2<f64> {
    let k = info.k;
    Point2::new(
        k[0] * point.x / point.z + k[2],
        k[4] * point.y / point.z + k[5],
    )
}

#[test]
fn what_tf_and_camera_info_say_is_where_the_camera_sees_it() {
    let camera = camera("north");
    let fixed = convert::static_transforms(std::iter::once(&camera), [].iter(), "world", NOW);
    assert_eq!(fixed[0].header.frame_id, "world");
    assert_eq!(fixed[0].child_frame_id, "north_optical");
    let object = convert::object_transform(&pose("cube", NOW, State::Tracking), "world");
    let optical_from_object = motion(&fixed[0].transform).inverse() * motion(&object.transform);
    let seen = optical_from_object * Point3::new(0.01, 0.02, 0.03);
    // Left of the axis and above it, two metres ahead.
    assert!(
        seen.x < 0.0 && seen.y < 0.0 && (seen.z - 2.0).abs() < 0.1,
        "{seen}"
    );
    let lens = Lens::try_from(&camera.lens).expect("a lens");
    let info = convert::camera_info(&camera, NOW);
    let pixel = lens.project(&seen).expect("in front of it");
    assert!((project(&info, seen) - pixel).norm() < 1e-9);
    assert_eq!(info.header.frame_id, "north_optical");
}

#[test]
fn a_smaller_picture_has_a_smaller_lens() {
    let camera = camera("north");
    let info = convert::picture_info(&camera, &preview([160, 120])).expect("a JPEG");
    assert_eq!([info.width, info.height], [160, 120]);
    let point = Point3::new(0.1, -0.2, 1.5);
    let whole = project(&convert::camera_info(&camera, NOW), point);
    let small = project(&info, point);
    // Edges of pixels lie half a pixel beside their centres.
    let expected = whole.map(|pixel| (pixel + 0.5) / 4.0 - 0.5);
    assert!((small - expected).norm() < 1e-9, "{small} {expected}");
}

#[test]
fn lenses_have_the_names_of_ros() {
    let mut camera = camera("north");
    assert_eq!(convert::camera_info(&camera, NOW).d, [0.0; 5]);
    let (fx, fy, cx, cy) = (500.0, 500.0, 320.0, 240.0);
    camera.lens = LensConfig::BrownConrady {
        fx,
        fy,
        cx,
        cy,
        distortion: [0.1, 0.2, 0.3, 0.4, 0.5],
    };
    let info = convert::camera_info(&camera, NOW);
    assert_eq!(info.distortion_model, "plumb_bob");
    assert_eq!(info.d, [0.1, 0.2, 0.3, 0.4, 0.5]);
    camera.lens = LensConfig::KannalaBrandt {
        fx,
        fy,
        cx,
        cy,
        distortion: [0.1, 0.2, 0.3, 0.4],
    };
    let info = convert::camera_info(&camera, NOW);
    assert_eq!(info.distortion_model, "equidistant");
    assert_eq!(info.d, [0.1, 0.2, 0.3, 0.4]);
}

#[test]
fn a_detection_has_the_corners_and_homography_of_the_apriltag_library() {
    let message = convert::detections(&image(NOW));
    let found = &message.detections[0];
    let corners = found.corners.each_ref().map(|corner| [corner.x, corner.y]);
    assert_eq!(
        corners,
        [
            [95.0, 280.0],
            [170.0, 290.0],
            [180.0, 210.0],
            [100.0, 200.0]
        ]
    );
    let h = found.homography;
    let map = |x: f64, y: f64| {
        let w = h[6] * x + h[7] * y + h[8];
        [
            (h[0] * x + h[1] * y + h[2]) / w,
            (h[3] * x + h[4] * y + h[5]) / w,
        ]
    };
    // The library's corner k lies at x = -1, 1, 1, -1 and y = 1, 1, -1, -1, with y down.
    for (corner, (x, y)) in corners
        .iter()
        .zip([(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
    {
        let mapped = map(x, y);
        assert!((mapped[0] - corner[0]).hypot(mapped[1] - corner[1]) < 1e-9);
    }
    assert_eq!([found.centre.x, found.centre.y], map(0.0, 0.0));
    assert_eq!(h[8], 1.0);
    assert_eq!((found.id, found.hamming), (7, 1));
}

#[test]
fn a_tag_without_an_area_is_left_out() {
    let mut image = image(NOW);
    image.tags[0].corners = [[1.0, 1.0]; 4];
    assert!(convert::detections(&image).detections.is_empty());
}

fn bridge(max_rate_hz: Option<f64>) -> Bridge {
    Bridge::new(BridgeOptions {
        namespace: "sextant".parse().expect("a namespace"),
        world: "world".to_owned(),
        max_rate_hz,
        also: Vec::new(),
    })
}

fn take<M: Message>(bridge: &mut Bridge, key: KeyRef, message: &M) -> Vec<Outgoing> {
    let payload = encode(message).expect("a message");
    bridge.handle(NOW, &key, Some("fusion/main"), Ok(&payload))
}

fn take_pose(bridge: &mut Bridge, pose: &ObjectPose) -> Vec<Outgoing> {
    take(bridge, KeyRef::Pose(pose.object.clone()), pose)
}

fn names(outgoing: &[Outgoing]) -> Vec<&str> {
    outgoing
        .iter()
        .map(|message| message.topic.name.as_str())
        .collect()
}

#[test]
fn a_pose_becomes_further_messages_where_they_are_asked_for() {
    let mut bridge = Bridge::new(BridgeOptions {
        namespace: "sextant".parse().expect("a namespace"),
        world: "world".to_owned(),
        max_rate_hz: None,
        also: vec![Also::Odometry, Also::NamedPoses, Also::RigidBodies],
    });
    let outgoing = take_pose(&mut bridge, &pose("pad-2", NOW, State::Initialising));
    assert_eq!(
        names(&outgoing),
        [
            "/sextant/object/pad_2/pose",
            "/sextant/object/pad_2/quality"
        ]
    );
    let outgoing = take_pose(&mut bridge, &pose("pad-2", NOW + 1, State::Tracking));
    assert_eq!(
        names(&outgoing)[3..],
        ["/sextant/object/pad_2/odom", "/poses", "/rigid_bodies"]
    );
}

#[test]
fn odometry_has_velocities_in_the_axes_of_the_object() {
    // Turned to the left by 90 degrees, on its way along the world's x axis, and turning on.
    let turned = ObjectPose {
        orientation: [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()],
        twist: [2.0, 0.0, 0.0, 0.0, 0.0, 3.0],
        ..pose("cube", NOW, State::Tracking)
    };
    let odometry = convert::odometry(&turned, "world");
    assert_eq!(odometry.child_frame_id, "cube");
    let (linear, angular) = (odometry.twist.twist.linear, odometry.twist.twist.angular);
    assert!(linear.x.abs() < 1e-12 && (linear.y + 2.0).abs() < 1e-12);
    assert!((angular.z - 3.0).abs() < 1e-12);
}

#[test]
fn a_pose_is_published_with_its_transform_once_its_attitude_is_known() {
    let mut bridge = bridge(None);
    let mut at = |ns, state| {
        let outgoing = take_pose(&mut bridge, &pose("pad-2", NOW + ns, state));
        names(&outgoing).join(" ")
    };
    let always = "/sextant/object/pad_2/pose /sextant/object/pad_2/quality";
    assert_eq!(at(1, State::Initialising), always);
    assert_eq!(at(2, State::Tracking), format!("/tf {always}"));
    assert_eq!(at(3, State::Coasting), format!("/tf {always}"));
    assert_eq!(at(4, State::Lost), "");
    // tf2 complains about transforms of the same time.
    assert_eq!(at(3, State::Tracking), "");
    assert_eq!(bridge.counts().superseded, 1);
}

#[test]
fn quality_has_the_lengths_of_errors_and_what_entered() {
    let mut pose = pose("cube", NOW, State::Tracking);
    for (place, variance) in [4e-6, 4e-6, 1e-6, 4e-4, 4e-4, 1e-4].iter().enumerate() {
        pose.covariance[7 * place] = *variance;
    }
    let quality = convert::quality(&pose);
    let expected = [0.003, 0.03, f64::from(0.1_f32), 2.0, 3.0];
    let pairs = quality.data.iter().zip(expected);
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-12));
    let axis = &quality.layout.dim[0];
    assert_eq!(axis.label.split(' ').count(), pairs.len());
    assert_eq!([axis.size, axis.stride], [5, 5]);
}

#[test]
fn a_whole_image_comes_with_the_lens_at_its_time() {
    let mut bridge = bridge(None);
    let (rig, north) = (
        vec![camera("north")],
        CameraId::new("north").expect("an id"),
    );
    let rig = RigConfig {
        cameras: rig,
        scale_sigma: None,
    };
    take(&mut bridge, KeyRef::ConfigRig, &rig);
    let outgoing = bridge.image(&north, NOW, "png", vec![1, 2, 3]);
    assert_eq!(
        names(&outgoing),
        [
            "/sextant/camera/north/camera_info",
            "/sextant/camera/north/image/compressed"
        ]
    );
    assert!(bridge.image(&north, NOW, "png", vec![1, 2, 3]).is_empty());
}

#[test]
fn the_covariance_is_the_message_s_own() {
    let pose = pose("cube", NOW, State::Tracking);
    let message = convert::object_pose(&pose, "world");
    assert_eq!(message.pose.covariance, pose.covariance);
    assert_eq!(message.pose.pose.position.y, 0.25);
}

#[test]
fn streams_keep_to_the_rate() {
    let mut bridge = bridge(Some(10.0));
    let images = (0..30).map(|k| NOW + k * SECOND / 30);
    let passed = images.filter(|&t| {
        let image = image(t);
        let key = KeyRef::Observations(image.camera.clone());
        !take(&mut bridge, key, &image).is_empty()
    });
    assert_eq!(passed.count(), 10);
    assert_eq!(bridge.counts().over_rate, 20);
}

#[test]
fn a_rig_makes_lenses_and_all_static_transforms() {
    let mut bridge = bridge(None);
    let object = ObjectConfig {
        id: ObjectId::new("cube").expect("an id"),
        links: Vec::new(),
        joints: Vec::new(),
        tags: vec![ObjectTagConfig {
            family: Family::Tag36h11,
            id: 3,
            size_m: 0.04,
            size_sigma_m: None,
            link: None,
            object_from_tag: Some(PoseConfig {
                position: [0.0, 0.0, 0.03],
                orientation: [0.0, 0.0, 0.0, 1.0],
            }),
            object_from_tag_sigma: None,
        }],
        frame_sigma: None,
        scale_sigma: None,
        world_from_object: None,
    };
    let key = || KeyRef::ConfigObject(object.id.clone());
    let first = take(&mut bridge, key(), &object);
    assert_eq!(names(&first), ["/tf_static"]);
    let rig = RigConfig {
        cameras: vec![camera("north"), camera("east")],
        scale_sigma: None,
    };
    let second = take(&mut bridge, KeyRef::ConfigRig, &rig);
    let lenses = ["north", "east"].map(|id| format!("/sextant/camera/{id}/camera_info"));
    assert_eq!(names(&second), [&lenses[0], &lenses[1], "/tf_static"]);
    let text = String::from_utf8_lossy(&second[2].payload).into_owned();
    for frame in ["north_optical", "east_optical", "cube/tag36h11:3"] {
        assert!(text.contains(frame), "{frame}");
    }
    let removed = take(
        &mut bridge,
        key(),
        &ObjectConfig::removal(object.id.clone()),
    );
    let text = String::from_utf8_lossy(&removed[0].payload).into_owned();
    assert!(!text.contains("cube/tag36h11:3"));
}

#[test]
fn pictures_come_with_their_lens() {
    let mut bridge = bridge(None);
    let preview = preview([320, 240]);
    let key = || KeyRef::Preview(preview.camera.clone());
    let picture = "/sextant/camera/north/preview/image/compressed";
    let outgoing = take(&mut bridge, key(), &preview);
    assert_eq!(names(&outgoing), [picture]);
    let rig = RigConfig {
        cameras: vec![camera("north")],
        scale_sigma: None,
    };
    take(&mut bridge, KeyRef::ConfigRig, &rig);
    let later = Preview {
        capture_ns: NOW + SECOND,
        ..preview.clone()
    };
    let outgoing = take(&mut bridge, key(), &later);
    assert_eq!(
        names(&outgoing),
        ["/sextant/camera/north/preview/camera_info", picture]
    );
}

#[test]
fn names_that_are_taken_are_refused_and_counted() {
    let mut bridge = bridge(None);
    for (object, count) in [("pad-2", 3), ("pad_2", 0), ("world", 0)] {
        let outgoing = take_pose(&mut bridge, &pose(object, NOW, State::Tracking));
        assert_eq!(outgoing.len(), count, "{object}");
    }
    assert_eq!(bridge.counts().name_taken, 2);
}

#[test]
fn what_is_no_message_or_belongs_elsewhere_is_counted() {
    let mut bridge = bridge(None);
    let key = KeyRef::Pose(ObjectId::new("cube").expect("an id"));
    assert!(bridge.handle(NOW, &key, None, Ok(b"nonsense")).is_empty());
    assert!(take(&mut bridge, key, &pose("other", NOW, State::Tracking)).is_empty());
    assert_eq!(bridge.counts().invalid, 2);
}

#[test]
fn diagnostics_name_each_node_and_go_stale() {
    let mut bridge = bridge(None);
    let status = FusionStatus {
        node: NodeId::new("main").expect("an id"),
        version: "0.1.0".to_owned(),
        uptime_s: 1,
        epoch: Some(1),
        cameras: Vec::new(),
        foreign: Rejections::default(),
        objects: Vec::new(),
        faults: vec![sextant_site_report::Fault::CameraMoved {
            camera: CameraId::new("north").expect("an id"),
        }],
        faults_left_out: 0,
        imperfections: Vec::new(),
        notices: Vec::new(),
    };
    take(
        &mut bridge,
        KeyRef::FusionStatus(status.node.clone()),
        &status,
    );
    let mut report = |now| {
        let message = bridge.diagnostics(now, &[("messages published", 7)]);
        assert_eq!(message.topic.kind, TopicKind::Diagnostics);
        String::from_utf8_lossy(&message.payload).into_owned()
    };
    let soon = report(NOW + SECOND);
    assert!(soon.contains("sextant: fusion main") && soon.contains("camera north is not where"));
    assert!(report(NOW + 6 * SECOND).contains("no status for more than 3 s"));
    assert!(!report(NOW + 400 * SECOND).contains("fusion main"));
}
