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
  data: [393.653800, 0.000000, 322.797939, 0.000000, 0.000000, 393.653800, 241.090902, 0.000000, \
  0.000000, 0.000000, 1.000000, 0.000000]
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
    let harmless = ROS
        .replace("plumb_bob", "rational_polynomial")
        .replace("0.000505, 0.000000]", "0.000505, 0.0, 0.0, 0.0, 0.0]");
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
            "0.000505, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0]",
            "a tilted sensor (tx, ty)",
        ),
        (
            ROS,
            "0.000505, 0.000000]",
            "0.000505, 0.0, 9.0, 0.0, 80.0]",
            "rational or thin-prism terms (k4 and beyond) that no lens here follows",
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
        (
            ROS,
            "image_width: 640\n",
            "",
            "image_width: the file does not say the size of the images; add `image_width: ...`",
        ),
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

/// Numbers of OpenCV's `projectPoints`.
#[test]
fn a_rational_lens_becomes_the_nearest_one() {
    let photon = r#"{"resolution": {"width": 1600.0, "height": 1200.0}, "cameraIntrinsics": {"rows": 3, "cols": 3, "type": 6,
        "data": [905.5, 0.0, 801.0, 0.0, 905.75, 604.0, 0.0, 0.0, 1.0]}, "distCoeffs": {"rows": 1, "cols": 8, "type": 6,
        "data": [-0.0403, -0.036, -0.00163, -0.00066, 0.1477, -0.0943, 0.0575, 0.1157]}, "calobjectWarp": [0.0006, 6e-05]}"#;
    let (format, rig) = parsed(photon).unwrap();
    assert_eq!(format, ForeignFormat::PhotonVision);
    let camera = &rig.cameras()[0];
    assert_eq!(camera.resolution, [1600, 1200]);
    let seen = camera.lens.distort(&[0.5, -0.4].into()).unwrap();
    let expected = nalgebra::Point2::new(1257.786812742934, 237.66826869994753);
    assert!((seen - expected).norm() < 0.1, "{seen}");
    // One of those of Luxonis, whose terms above and below the line cancel for the most part.
    let oak = MESSAGE
        .replace("equidistant", "rational_polynomial")
        .replace("width: 640", "width: 1280")
        .replace("height: 480", "height: 800")
        .replace("- 300.0", "- 640.25")
        .replace("- 319.5", "- 638.5")
        .replace("- 301.0", "- 640.5")
        .replace("- 239.5", "- 398.25")
        .replace(
            "- 0.1\n- 0.01\n- 0.001\n- 0.0001\n",
            "- 7.1\n- -1.4\n- 0.00041\n- -0.00022\n- 1.2011\n- 7.05\n- -1.25\n- 1.1001\n",
        );
    let (_, rig) = parsed(&oak).unwrap();
    let seen = rig.cameras()[0].lens.distort(&[0.5, -0.4].into()).unwrap();
    let expected = nalgebra::Point2::new(958.5832400520799, 142.14487057322407);
    assert!((seen - expected).norm() < 0.5, "{seen}");
}

#[test]
fn an_equidistant_lens_may_have_zeros_behind_its_four_numbers() {
    let five = MESSAGE.replace("- 0.0001\nk:", "- 0.0001\n- 0.0\nk:");
    let (_, rig) = parsed(&five).unwrap();
    assert_eq!(
        rig.cameras()[0].lens.distortion(),
        [0.1, 0.01, 0.001, 0.0001]
    );
    let error = parsed(&five.replace("- 0.0\nk:", "- 0.5\nk:")).unwrap_err();
    assert!(error.contains("5 coefficients where 4 of equidistant belong"));
}

#[test]
fn messages_of_ros_end_with_a_separator() {
    assert!(MESSAGE.ends_with("---\n"));
    let (_, one) = parsed(MESSAGE).unwrap();
    let (_, of_several) = parsed(&MESSAGE.repeat(3)).unwrap();
    assert_eq!(one, of_several);
}

/// The numbers of [`OPENCV`] in the other formats.
#[test]
fn files_are_recognised_by_their_content() {
    let json = r#"{"image_width": 640, "image_height": 480,
        "camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": [650.0, 0.0, 319.5, 0.0, 660.0, 239.5, 0.0, 0.0, 1.0]},
        "distortion_coefficients": {"type_id": "opencv-matrix", "rows": 5, "cols": 1, "dt": "d", "data": [-0.41, 0.57, 0.0, 0.001, -2.2]}}"#;
    let xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n<image_width>640</image_width>\n\
        <image_height>480</image_height>
<camera_matrix type_id=\"opencv-matrix\"><rows>3</rows><cols>3</cols><dt>d</dt><data>\n    650. \
0. 319.5 0. 660. 239.5 0. 0. 1.</data></camera_matrix>
<distortion_coefficients \
type_id=\"opencv-matrix\"><rows>5</rows><cols>1</cols><dt>d</dt><data>-0.41 0.57 0. 0.001 \
-2.2</data></distortion_coefficients>
</opencv_storage>\n";
    let wpical = r#"{"camera_matrix": [650.0, 0.0, 319.5, 0.0, 660.0, 239.5, 0.0, 0.0, 1.0], "img_size": [640, 480],
        "distortion_coefficients": [-0.41, 0.57, 0.0, 0.001, -2.2], "avg_reprojection_error": 0.3}"#;
    let matlab = r#"{"RadialDistortion": [-0.41, 0.57, -2.2], "TangentialDistortion": [0.0, 0.001], "ImageSize": [480, 640],
        "IntrinsicMatrix": [[650.0, 0, 0], [0, 660.0, 0], [320.5, 240.5, 1]], "EstimateSkew": false}"#;
    let matlabs_k = r#"{"RadialDistortion": [-0.41, 0.57, -2.2], "TangentialDistortion": [0.0, 0.001], "ImageSize": [480, 640],
        "K": [[650.0, 0, 320.5], [0, 660.0, 240.5], [0, 0, 1]]}"#;
    let nerfstudio = r#"{"camera_model": "OPENCV", "fl_x": 650.0, "fl_y": 660.0, "cx": 320.0, "cy": 240.0, "w": 640, "h": 480,
        "k1": -0.41, "k2": 0.57, "k3": -2.2, "p2": 0.001, "frames": []}"#;
    let anipose = "[cam_0]\nname = \"north\"\nsize = [640, 480]\n\
        matrix = [[650.0, 0.0, 319.5], [0.0, 660.0, 239.5], [0.0, 0.0, 1.0]]
distortions = [-0.41, 0.57, 0.0, 0.001, -2.2]\n\n[metadata]\nadjusted = false\n";
    let caliscope = anipose
        .replace("[cam_0]", "[cameras.0]")
        .replace("name = \"north\"\n", "port = 0\n");
    let euroc = "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0, 0, 1, 0, \
        0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [640, 480]
camera_model: pinhole\nintrinsics: [650.0, 660.0, 319.5, 239.5]\n\
distortion_model: radial-tangential\ndistortion_coefficients: [-0.41, 0.57, 0.0, 0.001, -2.2]\n";
    let orb = "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 650.0\nCamera1.fy: 660.0\n\
        Camera1.cx: 319.5\nCamera1.cy: 239.5
Camera1.k1: -0.41\nCamera1.k2: 0.57\nCamera1.p1: 0.0\nCamera1.p2: 0.001\nCamera1.k3: -2.2\n\
Camera.width: 640\nCamera.height: 480\n";
    let stella = "Camera:\n  name: \"any\"\n  model: \"perspective\"\n  fx: 650.0\n  fy: \
        660.0\n  cx: 319.5\n  cy: 239.5\n  k1: -0.41\n  k2: 0.57\n  p1: 0.0
  p2: 0.001\n  k3: -2.2\n  cols: 640\n  rows: 480\n";
    let basalt = r#"{"value0": {"T_imu_cam": [{"px": 1, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1}],
        "intrinsics": [{"camera_type": "pinhole-radtan8", "intrinsics": {"fx": 650.0, "fy": 660.0, "cx": 319.5, "cy": 239.5, "k1": -0.41, "k2": 0.57, "p1": 0.0, "p2": 0.001, "k3": -2.2}}],
        "resolution": [[640, 480]]}}"#;
    let realsense = r#"{"width": 640, "height": 480, "ppx": 319.5, "ppy": 239.5, "fx": 650.0, "fy": 660.0, "model": "distortion.brown_conrady",
        "coeffs": [-0.41, 0.57, 0.0, 0.001, -2.2]}"#;
    let metashape = "<?xml version=\"1.0\"?>\n<calibration>\n\
        <projection>frame</projection><width>640</width><height>480</height><f>660</f><b1>-10</b1>
<k1>-0.41</k1><k2>0.57</k2><k3>-2.2</k3><p1>0.001</p1><date>2023-01-01</date></calibration>\n";
    let expected = parsed(OPENCV).unwrap().1.cameras()[0].lens;
    for (text, format) in [
        (euroc, ForeignFormat::Euroc),
        (orb, ForeignFormat::OrbSlam),
        (stella, ForeignFormat::OrbSlam),
        (basalt, ForeignFormat::Basalt),
        (realsense, ForeignFormat::RealSense),
        (metashape, ForeignFormat::Metashape),
        (json, ForeignFormat::OpenCv),
        (xml, ForeignFormat::OpenCv),
        (wpical, ForeignFormat::Ros),
        (matlab, ForeignFormat::Matlab),
        (matlabs_k, ForeignFormat::Matlab),
        (nerfstudio, ForeignFormat::Nerfstudio),
        (anipose, ForeignFormat::Anipose),
        (&caliscope, ForeignFormat::Anipose),
    ] {
        let (found, rig) = parsed(text).unwrap();
        assert_eq!(found, format);
        let camera = &rig.cameras()[0];
        assert_eq!(
            (camera.lens, camera.resolution),
            (expected, [640, 480]),
            "{found}"
        );
        // Whatever the file is called.
        assert!(is_foreign(Path::new("rig.toml"), text), "{found}");
        assert!(
            foreign_text(found, rig.cameras()).is_ok()
                == matches!(found, ForeignFormat::Ros | ForeignFormat::OpenCv)
        );
    }
}

#[test]
fn poses_of_anipose_are_inverted_and_in_the_unit_that_makes_sense() {
    let camera = "size = [640, 480]\nmatrix = [[650.0, 0.0, 319.5], [0.0, 660.0, 239.5], [0.0, \
        0.0, 1.0]]\ndistortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n";
    let of = |unit: f64| {
        let half = std::f64::consts::PI;
        let text = format!(
            "[cam_0]\n{camera}rotation = [0.0, 0.0, 0.0]\ntranslation = [0.0, 0.0, 0.0]\n\
             [cam_1]\n{camera}rotation = [0.0, {half}, 0.0]\ntranslation = [{}, 0.0, {}]\n",
            0.5 * unit,
            2.0 * unit
        );
        parsed(&text).unwrap().1.cameras()[1]
            .world_from_camera
            .unwrap()
    };
    for pose in [of(1.0), of(1000.0)] {
        // Turned by half a turn about y: what lies at +x and +z of the camera is at -x and -z of the world.
        let centre = pose.translation.vector;
        assert!(
            (centre - nalgebra::Vector3::new(0.5, 0.0, 2.0)).norm() < 1e-9,
            "{centre}"
        );
    }
}

/// The window of a message is that of the full image, whose centre is elsewhere in the window.
#[test]
fn a_region_of_interest_moves_the_principal_point() {
    let whole = parsed(MESSAGE).unwrap().1.cameras()[0].clone();
    let roi = |window: &str| {
        let none = "roi:\n  x_offset: 0\n  do_rectify: false\n";
        assert!(MESSAGE.contains(none));
        MESSAGE.replace(none, &format!("roi: {{{window}}}\n"))
    };
    let full = roi("x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false");
    assert_eq!(parsed(&full).unwrap().1.cameras()[0], whole);
    let part = roi("x_offset: 160, y_offset: 120, height: 240, width: 320, do_rectify: false");
    let part = parsed(&part).unwrap().1.cameras()[0].clone();
    assert_eq!(part.resolution, [320, 240]);
    let (all, part) = (whole.lens.intrinsics(), part.lens.intrinsics());
    assert_eq!((part.cx, part.cy), (all.cx - 160.0, all.cy - 120.0));
}

#[test]
fn no_camera_of_a_file_is_passed_over() {
    let names = |text: &str| -> Vec<String> {
        let (_, rig) = parsed(text).unwrap();
        rig.cameras()
            .iter()
            .map(|camera| camera.id.to_string())
            .collect()
    };
    let matrix = |fx: f64| {
        format!(
            "!!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {fx:?}, 0., 330., 0., \
             530., 230., 0., 0., 1. ]"
        )
    };
    let stereo = format!(
        "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nM1: {}\nD1: [0.1, 0, 0, 0, 0]\n\
         M2: {}\nD2: [0.2, 0, 0, 0, 0]\n",
        matrix(530.0),
        matrix(531.0)
    );
    assert_eq!(names(&stereo), ["north_1", "north_2"]);
    let (_, rig) = parsed(&stereo).unwrap();
    let second = rig.cameras()[1].lens;
    assert_eq!(
        (second.intrinsics().fx, second.distortion()[0]),
        (531.0, 0.2)
    );
    let link = "  camera_model: pinhole\n  intrinsics: [600, 600, 320, 240]\n  distortion_model: \
        radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n";
    let error = parsed(&format!("cam0:\n{link}cam2:\n{link}")).unwrap_err();
    assert!(
        error.contains("cam1: it is missing, but there is cam2"),
        "{error}"
    );
    let zed = "[LEFT_CAM_HD]\nfx=700.5\nfy=700.5\ncx=640\ncy=360.5\nk1=-0.17\nk2=0.02\np1=0\n\
        p2=0\nk3=0\n\n[RIGHT_CAM_VGA]\nfx=350\nfy=350\ncx=336\ncy=188\n\n[STEREO]\nBaseline=119.9\n";
    assert_eq!(names(zed), ["left_hd", "right_vga"]);
    assert!(is_foreign(Path::new("SN1234.conf"), zed));
    let at = |px: f64| {
        format!(r#"{{"px": {px}, "py": 0, "pz": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 1}}"#)
    };
    let lens = r#"{"camera_type": "kb4", "intrinsics": {"fx": 461.5, "fy": 460.2, "cx": 365.8, "cy": 249.1, "k1": -0.01, "k2": 0, "k3": 0, "k4": 0}}"#;
    let basalt = format!(
        r#"{{"value0": {{"T_imu_cam": [{}, {}], "intrinsics": [{lens}, {lens}], "resolution": [[752, 480], [752, 480]]}}}}"#,
        at(0.5),
        at(0.75)
    );
    let (_, rig) = parsed(&basalt).unwrap();
    let apart = rig.cameras()[1].world_from_camera.unwrap().translation.x;
    assert_eq!(
        (names(&basalt), apart),
        (vec!["cam0".to_owned(), "cam1".to_owned()], 0.25)
    );
    let error = parsed(&basalt.replacen("kb4", "ds", 2)).unwrap_err();
    assert!(error.contains("`ds` has no counterpart"), "{error}");
}

#[test]
fn a_size_of_other_images_is_refused() {
    let file = |k: &str, size: &str| {
        format!(
            r#"{{"camera_matrix": {k}, "dist_coeffs": [0.1, 0, 0, 0, 0], "image_size": {size}}}"#
        )
    };
    let vga = "[[600, 0, 320], [0, 600, 240], [0, 0, 1]]";
    assert!(parsed(&file(vga, "[640, 480]")).is_ok());
    // As numpy's `shape` has it.
    let error = parsed(&file(vga, "[480, 640]")).unwrap_err();
    assert!(
        error.contains("in the middle of images of 640 x 480 pixels"),
        "{error}"
    );
    assert!(error.contains("exchange width and height"), "{error}");
    let hd = "[[1200, 0, 960], [0, 1200, 540], [0, 0, 1]]";
    let error = parsed(&file(hd, "[640, 480]")).unwrap_err();
    assert!(
        error.contains("(960, 540) lies outside of the images of 640 x 480"),
        "{error}"
    );
}

#[test]
fn the_name_of_eurocs_camera_is_its_folders() {
    let text = "camera_model: pinhole\nintrinsics: [650.0, 660.0, 319.5, 239.5]\n\
        distortion_model: none\nresolution: [640, 480]\n";
    let (_, rig) = parse_foreign(Path::new("mav0/cam1/sensor.yaml"), text).unwrap();
    assert_eq!(rig.cameras()[0].id.as_str(), "cam1");
}

#[test]
fn what_is_no_calibration_or_none_yet_is_said() {
    let zeros = "image_width: 640\nimage_height: 480\n\
        camera_matrix: {rows: 3, cols: 3, data: [0, 0, 0, 0, 0, 0, 0, 0, 0]}\n";
    let error = parsed(zeros).unwrap_err();
    assert!(
        error.contains("this camera has not been calibrated"),
        "{error}"
    );
    let inverse = r#"{"width": 640, "height": 480, "ppx": 319.5, "ppy": 239.5, "fx": 650.0, "fy": 660.0, "model": "distortion.inverse_brown_conrady",
        "coeffs": [-0.05, 0.06, 0.0, 0.001, -0.02]}"#;
    let error = parsed(inverse).unwrap_err();
    assert!(
        error.contains("`inverse_brown_conrady` has no counterpart"),
        "{error}"
    );
    let folder = tempfile::tempdir().unwrap();
    for (text, remedy) in [
        (
            "# oST version 5.0 parameters\n\n[image]\n\nwidth\n640\n",
            "give the ost.yaml",
        ),
        (
            "Calibration results\n====================\n",
            "camchain.yaml",
        ),
        (
            "# Camera list with one line of data per camera:\n1 PINHOLE 640 480 600 600 320 240\n",
            "COLMAP",
        ),
    ] {
        let file = folder.path().join("lens.txt");
        std::fs::write(&file, text).unwrap();
        let error = crate::read_rig(&file).unwrap_err().to_string();
        assert!(error.contains(remedy), "{error}");
    }
}

#[test]
fn the_unit_of_anipose_is_assumed_and_said_or_named() {
    let camera = "size = [640, 480]\nmatrix = [[650.0, 0.0, 319.5], [0.0, 660.0, 239.5], [0.0, \
        0.0, 1.0]]\ndistortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("calibration.toml");
    let read = |x: f64, unit: &str| {
        let text = format!(
            "[cam_0]\n{camera}rotation = [0.0, 0.0, 0.0]\ntranslation = [{x}, 0.0, 0.0]\n\
             [metadata]\nadjusted = false\n{unit}"
        );
        std::fs::write(&file, text).unwrap();
        let assumed = crate::assumptions(&file).map(|all| all.join("; "));
        let rig = crate::read_rig(&file).map_err(|error| error.to_string())?;
        let pose = rig.cameras()[0].world_from_camera.unwrap();
        Ok::<_, String>((-pose.translation.x, assumed.unwrap()))
    };
    let (x, assumed) = read(150.0, "").unwrap();
    assert_eq!(x, 0.15);
    for part in ["millimetres", "0.150 m from the origin", "[metadata]"] {
        assert!(assumed.contains(part), "{assumed}");
    }
    let (x, assumed) = read(1.5, "").unwrap();
    assert!(x == 1.5 && assumed.contains("for metres"), "{assumed}");
    assert_eq!(read(150.0, "unit = \"cm\"\n"), Ok((1.5, String::new())));
    let error = read(150.0, "unit = \"inch\"\n").unwrap_err();
    assert!(
        error.contains("metadata.unit: this is no unit") && error.contains("write m, cm or mm"),
        "{error}"
    );
    assert_eq!(read(0.0, ""), Ok((0.0, String::new())));
}

#[test]
fn models_without_a_counterpart_are_named() {
    let omni = "front:\n  camera_model: omni\n  distortion_coeffs: [-0.04, 0.12, 0.0, 0.0]\n  \
        distortion_model: radtan\n  intrinsics: [1.6, 2010.5, 2011.0, 1220.0, 1021.0]\n  \
        resolution: [2448, 2048]\n  rostopic: /front\n";
    assert!(
        parsed(omni)
            .unwrap_err()
            .contains("front.camera_model: the camera model `omni` has no counterpart")
    );
    let mei = "%YAML:1.0\n---\nmodel_type: MEI\ncamera_name: camera\nimage_width: 752\n\
        image_height: 480\nmirror_parameters:\n   xi: 1.2\n";
    assert!(
        parsed(mei)
            .unwrap_err()
            .contains("the camera model `MEI` has no counterpart")
    );
    let vins = "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 752\n\
        image_height: 480\ndistortion_parameters:\n   k1: -0.1\n   k2: 0.02\n   p1: 0.001\n   \
        p2: -0.001\nprojection_parameters:\n   fx: 460.0\n   fy: 461.0\n   cx: 367.0\n   cy: 248.0\n";
    let (format, rig) = parsed(vins).unwrap();
    assert_eq!(format, ForeignFormat::Camodocal);
    assert_eq!(
        rig.cameras()[0].lens.distortion(),
        [-0.1, 0.02, 0.001, -0.001, 0.0]
    );
}

/// The example of MC-Calib's documentation, shortened.
const MC_CALIB: &str = "%YAML:1.0
---
nb_camera: 2
camera_0:
   camera_matrix: !!opencv-matrix
      rows: 3
      cols: 3
      dt: d
      data: [ 6.9e+02, 0., 6.4e+02, 0., 6.9e+02, 3.6e+02, 0., 0., 1. ]
   distortion_vector: !!opencv-matrix
      rows: 1
      cols: 5
      dt: d
      data: [ 1.0e-02, -2.0e-02, 0., 0., 0. ]
   distortion_type: 0
   camera_group: 0
   img_width: 1280
   img_height: 720
   camera_pose_matrix: !!opencv-matrix
      rows: 4
      cols: 4
      dt: d
      data: [ 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1. ]
camera_1:
   camera_matrix: !!opencv-matrix
      rows: 3
      cols: 3
      dt: d
      data: [ 5.0e+02, 0., 6.4e+02, 0., 5.0e+02, 3.6e+02, 0., 0., 1. ]
   distortion_vector: !!opencv-matrix
      rows: 1
      cols: 4
      dt: d
      data: [ 1.0e-02, 0., 0., 0. ]
   distortion_type: 1
   camera_group: 0
   img_width: 1280
   img_height: 720
   camera_pose_matrix: !!opencv-matrix
      rows: 4
      cols: 4
      dt: d
      data: [ 0., -1., 0., 1200., 1., 0., 0., 50., 0., 0., 1., 0., 0., 0., 0., 1. ]
";

/// As multical's documentation shows it.
const MULTICAL: &str = r#"{"cameras": {
  "cam1": {"model": "standard", "image_size": [2048, 1536],
    "K": [[1800.0, 0.0, 1020.0], [0.0, 1801.0, 760.0], [0.0, 0.0, 1.0]],
    "dist": [[-0.1, 0.05, 0.0, 0.0, 0.0]]},
  "cam2": {"model": "standard", "image_size": [2048, 1536],
    "K": [[1790.0, 0.0, 1030.0], [0.0, 1791.0, 770.0], [0.0, 0.0, 1.0]],
    "dist": [[-0.1, 0.05, 0.0, 0.0, 0.0]]}},
 "camera_poses": {"cam1": {"R": [[1,0,0],[0,1,0],[0,0,1]], "T": [0, 0, 0]}}}"#;

#[test]
fn cameras_one_level_below_the_top_are_read() {
    let path = Path::new("calibrated_cameras_data.yml");
    let (format, rig) = parse_foreign(path, MC_CALIB).unwrap();
    assert_eq!(format, ForeignFormat::McCalib);
    let second = &rig.cameras()[1];
    assert_eq!(second.lens.model(), LensModel::KannalaBrandt);
    let pose = second.world_from_camera.unwrap();
    assert_eq!(pose.translation.vector.as_slice(), [1.2, 0.05, 0.0]);
    let (format, rig) = parse_foreign(Path::new("calibration.json"), MULTICAL).unwrap();
    assert_eq!((format, rig.cameras().len()), (ForeignFormat::Multical, 2));
    assert_eq!(rig.cameras()[1].lens.intrinsics().fy, 1791.0);
    let missing = MC_CALIB.replacen("img_width", "width", 1);
    let refused = parse_foreign(path, &missing).unwrap_err().to_string();
    assert!(refused.contains("camera_0.img_width"), "{refused}");
}

/// freemocap names cameras after its recording: the ends differ.
#[test]
fn long_names_of_cameras_keep_what_tells_them_apart() {
    let names = ["Cam1", "Cam2"].map(|end| {
        name_of(&format!(
            "sesh_2022-09-19_16_16_50_in_class_jsm_synced_{end}"
        ))
    });
    assert_eq!(names[0].len(), 32);
    assert!(
        names[0].starts_with("sesh_2022") && names[0].ends_with("synced_cam1"),
        "{names:?}"
    );
    assert_ne!(names[0], names[1]);
    assert_eq!(name_of("Left Camera"), "left_camera");
}

/// caliscope wrote rotations as matrices.
#[test]
fn a_rotation_as_a_matrix_is_read() {
    let text = "[cam_0]\nname = \"a\"\nsize = [640, 480]\n\
        matrix = [[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]\n\
        distortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n\
        rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]\ntranslation = [1.0, 2.0, 3.0]\n";
    let (_, rig) = parse_foreign(Path::new("config.toml"), text).unwrap();
    let pose = rig.cameras()[0].world_from_camera.unwrap();
    let origin = pose.translation.vector;
    assert!(
        (origin - nalgebra::Vector3::new(-2.0, 1.0, -3.0)).norm() < 1e-9,
        "{origin}"
    );
}

/// A refusal says what the file is, or what is in it.
#[test]
fn files_without_lenses_are_named() {
    for (text, words) in [
        (
            "cam0:\n  pose:\n    position: {x: 0, y: 0, z: 1}\n",
            "TagSLAM's camera_poses.yaml",
        ),
        (
            "bodies:\n- rig:\n    is_static: false\n",
            "TagSLAM's tagslam.yaml",
        ),
        (
            "parameters: {eye_on_hand: false}\ntransformation: {x: 0.1, y: 0, z: 0, qx: 0, qy: 0, qz: 0, qw: 1}\n",
            "easy_handeye",
        ),
        ("lens: 3\nzoom: 4\n", "it has the keys lens, zoom"),
    ] {
        let refused = parse_foreign(Path::new("f.yaml"), text)
            .unwrap_err()
            .to_string();
        assert!(refused.contains(words), "{refused}");
    }
}
