//! Rigs as written, read and refused.

use super::*;
use sextant_site_model::Prior;

const GOOD: &str = r#"
[[camera]]
id = "north"
resolution = [640, 480]
lens = { model = "brown-conrady", fx = 600.0, fy = 600, cx = 319.5, cy = 239.5, distortion = [0, 0, 0, 0, 0] }
world_from_camera = { position = [1.0, 0.0, 1.2], orientation = [0, 0, 0, 1] }

[[camera]]
id = "south"
resolution = [1280, 800]
lens = { model = "kannala-brandt", fx = 123.4567890123, fy = 600.0, cx = 639.5, cy = 399.5, distortion = [0.01, 0, 1e-7, 0] }
"#;

fn parsed(text: &str) -> Result<Rig, String> {
    parse_rig(Path::new("rig.toml"), text).map_err(|error| error.to_string())
}

fn with(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from));
    parsed(&GOOD.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn the_designs_file_is_read() {
    let rig = parsed(GOOD).unwrap();
    let [north, south] = rig.cameras() else {
        panic!("two cameras")
    };
    assert_eq!(north.resolution, [640, 480]);
    let at = PoseParts::from(&north.world_from_camera.unwrap());
    assert_eq!(at.position, [1.0, 0.0, 1.2]);
    assert_eq!(south.lens.distortion(), [0.01, 0.0, 1e-7, 0.0]);
    assert_eq!(south.world_from_camera, None);
}

#[test]
fn a_simulated_rig_is_exact() {
    let rig = parsed(&format!("exact = true\n{GOOD}")).unwrap();
    for camera in rig.cameras() {
        assert_eq!(camera.pose_prior, Prior::Exact);
        assert_eq!(camera.lens_prior, Prior::Exact);
    }
}

const WITH_SIGMA: &str =
    "[0, 0, 0, 1] }\nworld_from_camera_sigma = { position = 0.0004, orientation = 0.0002 }";

#[test]
fn how_well_a_pose_is_known_may_be_stated() {
    let rig = parsed(&GOOD.replacen("[0, 0, 0, 1] }", WITH_SIGMA, 1)).unwrap();
    let sigma = |index: usize| rig.cameras()[index].pose_prior.given();
    assert_eq!(sigma(0).map(|sigma| sigma.position_m), Some(0.0004));
    assert_eq!(sigma(1), None);
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    let negative = WITH_SIGMA.replace("0.0002", "-0.0002");
    let message = with("[0, 0, 0, 1] }", &negative);
    assert!(
        message.contains("camera[0].world_from_camera_sigma: "),
        "{message}"
    );
}

#[test]
fn how_well_a_lens_is_known_may_be_stated() {
    let stated = "[640, 480]\nlens_sigma = { focal = 0.3, distortion = 0.05 }\n";
    let rig = parsed(&GOOD.replacen("[640, 480]\n", stated, 1)).unwrap();
    let sigma = |index: usize| rig.cameras()[index].lens_prior.given();
    let both = sigma(0).map(|sigma| (sigma.focal_px, sigma.distortion_px));
    assert_eq!((both, sigma(1)), (Some((0.3, 0.05)), None));
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    let message = with("[640, 480]\n", &stated.replace("0.05", "-0.05"));
    assert!(message.contains("camera[0].lens_sigma: "), "{message}");
}

#[test]
fn how_well_the_common_scale_is_known_may_be_stated() {
    let rig = parsed(&format!("scale_sigma = 0.003\n{GOOD}")).unwrap();
    assert_eq!(rig.scale_sigma(), Some(0.003));
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    let message = parsed(&format!("scale_sigma = -1\n{GOOD}")).unwrap_err();
    assert!(
        message.contains("rig.toml:1:15: scale_sigma: "),
        "{message}"
    );
}

#[test]
fn a_shutter_may_roll() {
    let rolling = GOOD.replacen("[640, 480]\n", "[640, 480]\nline_delay = 2.95e-5\n", 1);
    let rig = parsed(&rolling).unwrap();
    let delay_s = |index: usize| rig.cameras()[index].line_delay_s;
    assert_eq!((delay_s(0), delay_s(1)), (Some(2.95e-5), None));
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    let message = with("[640, 480]\n", "[640, 480]\nline_delay = 0.0003\n");
    assert!(message.contains("camera[0].line_delay: "), "{message}");
}

#[test]
fn stamps_may_be_of_the_start_or_the_end_of_the_exposure() {
    let stated = "[640, 480]\nexposure = 0.004\nstamp = \"end\"\n";
    let rig = parsed(&GOOD.replacen("[640, 480]\n", stated, 1)).unwrap();
    let exposure = |index: usize| rig.cameras()[index].exposure;
    let read = exposure(0).map(|exposure| (exposure.length_s, exposure.stamp));
    assert_eq!((read, exposure(1)), (Some((0.004, Stamp::End)), None));
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    for (from, to, expected) in [
        (
            "0.004",
            "4.0",
            "rig.toml:5:12: camera[0].exposure: camera north: the exposure must lie between 0 and 1 s",
        ),
        (
            "exposure = 0.004\n",
            "",
            "rig.toml:5:9: camera[0].stamp: this moment does not give the middle of the exposure",
        ),
        (
            "\"end\"",
            "\"ends\"",
            "rig.toml:6:9: camera[0].stamp: unknown variant `ends`",
        ),
    ] {
        let message = with("[640, 480]\n", &stated.replace(from, to));
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn what_is_written_is_read_back_exactly() {
    let rig = parsed(GOOD).unwrap();
    assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
}

#[test]
fn wrong_cameras_are_refused_with_line_key_and_remedy() {
    for (from, to, expected) in [
        (
            "\"south\"",
            "\"north\"",
            "rig.toml:9:6: camera[1].id: camera \"north\" is there already, on line 3; give each camera",
        ),
        ("\"north\"", "\"North\"", "rig.toml:3:6: camera[0].id: "),
        (
            "[640, 480]",
            "[640, 0]",
            "rig.toml:4:14: camera[0].resolution: ",
        ),
        (
            "[640, 480]",
            "[640]",
            "rig.toml:4:14: camera[0].resolution: invalid length 1",
        ),
        (
            "[640, 480]",
            "[640, 480, 3]",
            "rig.toml:4:14: camera[0].resolution: 3 elements are too many; remove",
        ),
        (
            "[1.0, 0.0, 1.2]",
            "[1.0, 0.0, 1.2, 1.0]",
            "rig.toml:6:34: camera[0].world_from_camera.position: 4 elements are too many",
        ),
        (
            "[1280, 800]",
            "[1280, 800, 3]",
            "rig.toml:10:14: camera[1].resolution: 3 elements are too many",
        ),
        (
            "[640, 480]",
            "[-640, 480]",
            "rig.toml:4:15: camera[0].resolution[0]: invalid value: integer `-640`",
        ),
        (
            "resolution = [640, 480]\n",
            "",
            "camera[0]: missing field `resolution`; add `resolution = ...`",
        ),
        (
            "resolution",
            "resolutoin",
            "rig.toml:4:1: camera[0].resolutoin: unknown field `resolutoin`",
        ),
        (
            "fx = 600.0",
            "fx = -600.0",
            "rig.toml:5:8: camera[0].lens: focal length fx = -600 must be",
        ),
        (
            "fx = 600.0",
            "fx = nan",
            "rig.toml:5:8: camera[0].lens: focal length fx = NaN must be",
        ),
        (
            "cx = 319.5",
            "cx = inf",
            "rig.toml:5:8: camera[0].lens: cx = inf must be finite",
        ),
        (
            "cx = 319.5",
            "cx = 319.5, cz = 1",
            "camera[0].lens: unknown field `cz`, expected one of",
        ),
        (
            "brown-conrady",
            "brown-conradi",
            "did you mean `brown-conrady`?",
        ),
        (
            "distortion = [0, 0, 0, 0, 0]",
            "distortion = [0, 0]",
            "rig.toml:5:8: camera[0].lens: invalid length 2",
        ),
        (
            "[1.0, 0.0, 1.2]",
            "[nan, 0.0, 1.2]",
            "rig.toml:6:34: camera[0].world_from_camera.position: ",
        ),
        (
            "orientation = [0, 0, 0, 1]",
            "orientation = [0, 0, 0, 2]",
            "rig.toml:6:65: camera[0].world_from_camera.orientation: ",
        ),
        (
            "orientation = [0, 0, 0, 1]",
            "orientation = [0, 0, 0, 1.002]",
            "its length is 1.002",
        ),
        ("orientation", "orientatoin", "did you mean `orientation`?"),
        (
            "[[camera]]\nid = \"south\"",
            "[[camra]]\nid = \"south\"",
            "rig.toml:8:3: camra: unknown field `camra`, expected one of `exact`, `scale_sigma`, \
             `camera`; did you mean `camera`?",
        ),
        ("[[camera]]", "[[camera]", "rig.toml:2:"),
    ] {
        let message = with(from, to);
        assert!(message.contains(expected), "{from} -> {to}: {message}");
    }
}

#[test]
fn a_rounded_quaternion_is_normalised() {
    let text = GOOD.replace(
        "orientation = [0, 0, 0, 1]",
        "orientation = [0, 0, 0.7071, 0.7071]",
    );
    let rig = parsed(&text).unwrap();
    let rotation = rig.cameras()[0].world_from_camera.unwrap().rotation;
    assert!((rotation.quaternion().norm() - 1.0).abs() < 1e-15);
}

#[test]
fn an_empty_rig_is_refused() {
    assert!(parsed("").unwrap_err().contains("the rig has no camera"));
}
