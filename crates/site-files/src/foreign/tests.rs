//! Files as other tools write them, what becomes of them, and the way back.

use super::*;
use sextant_geometry::{Intrinsics, Lens, LensModel, Pose};
use sextant_site_model::CameraId;

const ROS: &str = "image_width: 640
image_height: 480
camera_name: narrow Stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [438.783367, 0.000000, 305.593336, 0.000000, 437.302876, 243.738352, 0.000000, 0.000000, 1.000000]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.999978, 0.002789, -0.006046, -0.002816, 0.999986, -0.004401, 0.006034, 0.004417, 0.999972]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.000000, 322.797939, 0.000000, 0.000000, 393.653800, 241.090902, 0.000000, 0.000000, 0.000000, 1.000000, 0.000000]
";

const MESSAGE: &str = "header:\n  stamp: {sec: 1, nanosec: 2}\n  frame_id: camera
height: 480\nwidth: 640\ndistortion_model: equidistant\nd:\n- 0.1\n- 0.01\n- 0.001\n- 0.0001
k:\n- 300.0\n- 0.0\n- 319.5\n- 0.0\n- 301.0\n- 239.5\n- 0.0\n- 0.0\n- 1.0
binning_x: 0\nbinning_y: 0\nroi:\n  x_offset: 0\n  do_rectify: false\n---\n";

const KALIBR: &str = "cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.8e-05]
  distortion_model: radtan
  intrinsics: [458.6, 457.3, 367.2, 248.4]
  resolution: [752, 480]
  rostopic: /left/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, -0.11]
  - [1.0, 0.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.003]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.01, -0.002, 0.003, -0.0004]
  distortion_model: equidistant
  intrinsics: [457.5, 456.1, 379.9, 255.2]
  resolution: [752, 480]
  rostopic: /right/image_raw
";

const OPENCV: &str = "%YAML:1.0
---
calibration_time: \"Fri 20 Nov 2026\"
image_width: 640
image_height: 480
flags: 0
fisheye_model: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 6.5e+02, 0., 3.195e+02, 0., 6.6e+02, 2.395e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -4.1e-01, 5.7e-01, 0., 1.e-03, -2.2e+00 ]
avg_reprojection_error: 1.99e-01
";

fn parsed(text: &str) -> Result<(ForeignFormat, Rig), String> {
    parse_foreign(Path::new("folder/north.yaml"), text).map_err(|error| error.to_string())
}

fn refused(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    parsed(&text.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn a_camera_info_is_read_as_it_is() {
    let (format, rig) = parsed(ROS).unwrap();
    assert_eq!(format, ForeignFormat::Ros);
    let [camera] = rig.cameras() else {
        panic!("one camera")
    };
    assert_eq!(camera.id.as_str(), "narrow_stereo_left");
    assert_eq!(camera.resolution, [640, 480]);
    // Pixels are counted from the same place: the centre carries over unchanged.
    assert_eq!(camera.lens.intrinsics().cx, 305.593336);
    assert_eq!(
        camera.lens.distortion(),
        [-0.361976, 0.110510, 0.001014, 0.000505, 0.0]
    );
    assert_eq!(camera.world_from_camera, None);
}

#[test]
fn a_camera_info_message_is_read_too_and_named_after_its_file() {
    let text = MESSAGE.trim_end_matches("---\n");
    let (_, rig) = parsed(text).unwrap();
    let camera = &rig.cameras()[0];
    assert_eq!(camera.id.as_str(), "north");
    assert_eq!(camera.lens.model(), LensModel::KannalaBrandt);
    assert_eq!(camera.lens.distortion(), [0.1, 0.01, 0.001, 0.0001]);
    assert!(refused(text, "binning_x: 0", "binning_x: 2").contains("binned by 2"));
}

/// A point of the second camera, by the chain's own words and by ours.
#[test]
fn kalibrs_chain_maps_points_of_the_former_camera_into_the_next() {
    let (format, rig) = parsed(KALIBR).unwrap();
    assert_eq!(format, ForeignFormat::Kalibr);
    let [left, right] = rig.cameras() else {
        panic!("two cameras")
    };
    assert_eq!((left.id.as_str(), right.id.as_str()), ("left", "right"));
    assert_eq!(left.world_from_camera, Some(Pose::identity()));
    let in_left = nalgebra::Point3::new(0.3, 0.2, 2.0);
    // T_cn_cnm1 by hand: x' = -y - 0.11, y' = x + 0.02, z' = z + 0.003.
    let in_right = nalgebra::Point3::new(-0.31, 0.32, 2.003);
    let world_from_right = right.world_from_camera.unwrap();
    assert!((world_from_right * in_right - in_left).norm() < 1e-12);
    assert_eq!(right.lens.model(), LensModel::KannalaBrandt);
    assert_eq!(left.lens.distortion(), [-0.28, 0.07, 0.0002, 1.8e-05, 0.0]);
}

#[test]
fn a_chain_about_an_imu_is_read_as_well() {
    let of = |x: f64| {
        format!(
            "T_cam_imu:\n  - [1, 0, 0, {x}]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n"
        )
    };
    let link = KALIBR.find("  T_cn_cnm1").unwrap()..KALIBR.find("  cam_overlaps: [0]").unwrap();
    let mut text = KALIBR.to_owned();
    text.replace_range(link, &format!("  {}", of(0.5)));
    let text = text.replacen("cam0:\n", &format!("cam0:\n  {}", of(0.2)), 1);
    let (_, rig) = parsed(&text).unwrap();
    let right = rig.cameras()[1].world_from_camera.unwrap();
    assert!((right.translation.vector.x - (0.2 - 0.5)).abs() < 1e-12);
}

#[test]
fn opencvs_own_dialect_is_read() {
    let (format, rig) = parsed(OPENCV).unwrap();
    assert_eq!(format, ForeignFormat::OpenCv);
    let lens = rig.cameras()[0].lens;
    let expected = Intrinsics {
        fx: 650.0,
        fy: 660.0,
        cx: 319.5,
        cy: 239.5,
    };
    assert_eq!(lens.intrinsics(), expected);
    assert_eq!(lens.distortion(), [-0.41, 0.57, 0.0, 0.001, -2.2]);
    let fisheye = OPENCV
        .replace("fisheye_model: 0", "fisheye_model: 1")
        .replace(
            "[ -4.1e-01, 5.7e-01, 0., 1.e-03, -2.2e+00 ]",
            "[ 0.1, 0.2, 0.3, 0.4 ]",
        );
    let (_, rig) = parsed(&fisheye).unwrap();
    assert_eq!(rig.cameras()[0].lens.model(), LensModel::KannalaBrandt);
}

#[test]
fn what_our_lenses_cannot_say_is_refused_with_its_cause() {
    let rational = ROS
        .replace("plumb_bob", "rational_polynomial")
        .replace("0.000505, 0.000000]", "0.000505, 0.0, 0.0, 0.1, 0.0]");
    assert!(
        parsed(&rational)
            .unwrap_err()
            .contains("rational or thin-prism terms (k4 and beyond) are not zero")
    );
    let harmless = rational.replace("0.0, 0.1, 0.0]", "0.0, 0.0, 0.0]");
    assert_eq!(
        parsed(&harmless).unwrap().1.cameras()[0].lens.model(),
        LensModel::BrownConrady
    );
    for (text, from, to, expected) in [
        (
            ROS,
            "[438.783367, 0.000000",
            "[438.783367, 0.5",
            "camera_matrix: a skew of 0.5 pixels",
        ),
        (
            ROS,
            "plumb_bob",
            "thin_prism",
            "distortion_model: the distortion model `thin_prism`",
        ),
        (
            ROS,
            "0.000505, 0.000000]",
            "0.000505, 0.0, 1.0]",
            "6 coefficients where",
        ),
        (ROS, "438.783367", "-438.0", "focal length fx = -438"),
        (
            ROS,
            "438.783367",
            ".nan",
            "camera_matrix: this is no list of finite numbers",
        ),
        (
            ROS,
            "image_width: 640",
            "image_width: 0",
            "image_width: this is no number of pixels",
        ),
        (ROS, "image_width: 640\n", "", "image_width: it is missing"),
        (ROS, "rows: 3", "rows: [", "malformed YAML"),
        (
            KALIBR,
            "camera_model: pinhole",
            "camera_model: omni",
            "cam0.camera_model: the camera model `omni`",
        ),
        (
            KALIBR,
            "radtan",
            "fov",
            "cam0.distortion_model: the distortion model `fov`",
        ),
        (
            KALIBR,
            "T_cn_cnm1",
            "T_cnm1_cn",
            "cam1.T_cn_cnm1: it is missing",
        ),
        (
            KALIBR,
            "[0.0, -1.0, 0.0, -0.11]",
            "[0.0, -1.2, 0.0, -0.11]",
            "cam1.T_cn_cnm1: this is no rotation",
        ),
        (KALIBR, "/right/", "/left/", "camera left is there twice"),
        (
            KALIBR,
            "cam0",
            "cam7",
            "this is no calibration that is known",
        ),
    ] {
        let message = refused(text, from, to);
        assert!(message.contains(expected), "{from} -> {to}: {message}");
        assert!(message.starts_with("folder/north.yaml"), "{message}");
    }
}

#[test]
fn yaml_that_would_grow_without_end_is_refused() {
    let mut bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n".to_owned();
    for level in 1..40 {
        let former = format!("*a{}, ", level - 1).repeat(9);
        bomb += &format!("a{level}: &a{level} [{former}]\n");
    }
    assert!(parsed(&bomb).is_err());
    assert!(parsed(&"[".repeat(100_000)).is_err());
}

fn camera(id: &str, lens: Lens, world_from_camera: Option<Pose>) -> Camera {
    Camera::new(
        CameraId::new(id).unwrap(),
        [640, 480],
        lens,
        world_from_camera,
    )
}

fn lenses() -> [Lens; 3] {
    let numbers = Intrinsics {
        fx: 601.234567890123,
        fy: 600.1,
        cx: 318.7,
        cy: 1e-7,
    };
    [
        Lens::pinhole(numbers).unwrap(),
        Lens::brown_conrady(numbers, [-0.31, 0.12, 1e-4, -2e-5, 0.0]).unwrap(),
        Lens::kannala_brandt(numbers, [0.01, -0.02, 0.03, -1e-9]).unwrap(),
    ]
}

#[test]
fn what_is_written_is_read_back_exactly() {
    for format in [
        ForeignFormat::Ros,
        ForeignFormat::OpenCv,
        ForeignFormat::Kalibr,
    ] {
        for lens in lenses() {
            let camera = camera("north", lens, None);
            let text = foreign_text(format, std::slice::from_ref(&camera)).unwrap();
            let (found, rig) = parsed(&text).unwrap();
            assert_eq!((found, rig.cameras()), (format, &[camera][..]), "{text}");
        }
    }
}

#[test]
fn a_rig_goes_through_kalibrs_chain_relative_to_its_first_camera() {
    let pose = |x: f64, turn: f64| {
        Pose::new(
            nalgebra::Vector3::new(x, 1.0, 2.0),
            nalgebra::Vector3::new(0.1, turn, -turn),
        )
    };
    let [a, b, c] = lenses();
    let rig = [
        camera("a", a, Some(pose(0.0, 0.3))),
        camera("b", b, Some(pose(1.0, 1.3))),
        camera("c", c, Some(pose(2.0, -2.0))),
    ];
    let (_, read) = parsed(&foreign_text(ForeignFormat::Kalibr, &rig).unwrap()).unwrap();
    let first_from_world = rig[0].world_from_camera.unwrap().inverse();
    for (ours, read) in rig.iter().zip(read.cameras()) {
        assert_eq!((&ours.id, &ours.lens), (&read.id, &read.lens));
        let expected = first_from_world * ours.world_from_camera.unwrap();
        let off = expected.inverse() * read.world_from_camera.unwrap();
        assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7);
    }
}

#[test]
fn what_a_format_lacks_is_said() {
    let numbers = lenses()[0].intrinsics();
    let k3 = Lens::brown_conrady(numbers, [0.1, 0.0, 0.0, 0.0, 0.01]).unwrap();
    let camera = camera("north", k3, None);
    let refused = |format, cameras: &[Camera]| foreign_text(format, cameras).unwrap_err().cause;
    assert!(
        refused(ForeignFormat::Kalibr, std::slice::from_ref(&camera)).contains("third radial term")
    );
    assert!(
        refused(ForeignFormat::Ros, &[camera.clone(), camera])
            .contains("holds one camera, there are 2")
    );
}
