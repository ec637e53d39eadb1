//! A lens in TOML, as `rig.toml` has it.

use serde::{Deserialize, Serialize};
use sextant_geometry::{Lens, LensModel};

/// As a camera of `rig.toml` holds a lens.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Camera {
    lens: Lens,
}

const BROWN_CONRADY: &str = r#"lens = { model = "brown-conrady", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5, distortion = [0, 0, 0, 0, 0] }"#;
const KANNALA_BRANDT: &str = r#"lens = { model = "kannala-brandt", fx = 300, fy = 300, cx = 319.5, cy = 239.5, distortion = [0.1, 0, 0, -0.01] }"#;
const PINHOLE: &str =
    r#"lens = { model = "pinhole", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5 }"#;

fn read(text: &str) -> Result<Lens, String> {
    toml::from_str::<Camera>(text)
        .map(|camera| camera.lens)
        .map_err(|error| error.to_string())
}

#[test]
fn each_model_is_read() {
    assert_eq!(read(PINHOLE).unwrap().model(), LensModel::Pinhole);
    assert_eq!(
        read(BROWN_CONRADY).unwrap().model(),
        LensModel::BrownConrady
    );
    let fisheye = read(KANNALA_BRANDT).unwrap();
    assert_eq!(
        fisheye.parameters(),
        [300.0, 300.0, 319.5, 239.5, 0.1, 0.0, 0.0, -0.01]
    );
}

#[test]
fn each_model_is_written_as_it_is_read() {
    for text in [PINHOLE, BROWN_CONRADY, KANNALA_BRANDT] {
        let lens = read(text).unwrap();
        let written = toml::to_string(&Camera { lens }).unwrap();
        assert_eq!(read(&written), Ok(lens), "{written}");
    }
}

#[test]
fn unknown_keys_are_refused_by_name() {
    for text in [PINHOLE, BROWN_CONRADY, KANNALA_BRANDT] {
        let error = read(&text.replace("}", ", skew = 0 }")).unwrap_err();
        assert!(error.contains("unknown field `skew`"), "{error}");
    }
    let error = read(&PINHOLE.replace("}", ", distortion = [0, 0, 0, 0, 0] }")).unwrap_err();
    assert!(error.contains("unknown field `distortion`"), "{error}");
}

#[test]
fn missing_keys_are_named() {
    let error = read(&PINHOLE.replace("fy = 600.0,", "")).unwrap_err();
    assert!(error.contains("missing field `fy`"), "{error}");
    let error = read(&PINHOLE.replace(r#"model = "pinhole","#, "")).unwrap_err();
    assert!(error.contains("missing field `model`"), "{error}");
}

#[test]
fn an_unknown_model_is_answered_with_those_there_are() {
    let error = read(&PINHOLE.replace("pinhole", "fisheye")).unwrap_err();
    assert!(
        error.contains("unknown variant `fisheye`") && error.contains("kannala-brandt"),
        "{error}"
    );
}

#[test]
fn too_few_coefficients_are_refused() {
    assert!(read(&BROWN_CONRADY.replace("[0, 0, 0, 0, 0]", "[0, 0, 0, 0]")).is_err());
}

#[test]
fn a_lens_that_cannot_be_is_refused_with_line_and_cause() {
    let error = read(&PINHOLE.replace("fx = 600.0", "fx = -600.0")).unwrap_err();
    assert!(error.contains("line 1"), "{error}");
    assert!(
        error.contains("focal length fx = -600 must be between 1"),
        "{error}"
    );
    assert!(read(&PINHOLE.replace("cx = 319.5", "cx = nan")).is_err());
}
