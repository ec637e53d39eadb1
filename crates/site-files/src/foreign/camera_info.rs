//! One camera: ROS `camera_info`, and the calibration files of OpenCV, PhotonVision and WPILib, which have nearly the
//! same keys.

use super::distortion::{Keys, lens_of, ros_distortion};
use super::matrix::{first, intrinsics, missing, numbers, pixels};
use super::name_of;
use crate::error::Complaint;
use sextant_geometry::Intrinsics;
use sextant_site_model::{Camera, CameraId};
use yaml_serde::Value;

const WIDTH: [&str; 3] = ["image_width", "width", "image_Width"];
const HEIGHT: [&str; 3] = ["image_height", "height", "image_Height"];
pub(super) const MATRIX: [&str; 10] = [
    "camera_matrix",
    "K",
    "k",
    "Camera_Matrix",
    "cameraMatrix",
    "M",
    "M1",
    "mtx",
    "cameraIntrinsics",
    "intrinsic_matrix",
];
const COEFFICIENTS: [&str; 11] = [
    // PhotonVision's name for them until 2023.
    "cameraExtrinsics",
    "distortion_coefficients",
    "D",
    "d",
    "Distortion_Coefficients",
    "distCoeffs",
    "dist_coeffs",
    "dist_coeff",
    "D1",
    "dist",
    "distortion",
];

/// The camera of a document, or the two of a stereo calibration of OpenCV, without places: its unit of length is that
/// of the board.
pub(super) fn cameras(document: &Value, stem: &str) -> Result<Vec<Camera>, Complaint> {
    const OF_TWO: [([&str; 2], [&str; 2]); 3] = [
        (["M1", "D1"], ["M2", "D2"]),
        (["K1", "D1"], ["K2", "D2"]),
        (
            ["cameraMatrix1", "distCoeffs1"],
            ["cameraMatrix2", "distCoeffs2"],
        ),
    ];
    let has = |[matrix, _]: [&str; 2]| document.get(matrix).is_some();
    let Some((first, second)) = OF_TWO.into_iter().find(|two| has(two.0) && has(two.1)) else {
        return camera(document, stem).map(|camera| vec![camera]);
    };
    let one = |number: u32, [matrix, coefficients]: [&str; 2]| {
        let mut alone = document.as_mapping().cloned().unwrap_or_default();
        for (key, of_two) in [
            ("camera_matrix", matrix),
            ("distortion_coefficients", coefficients),
        ] {
            let value = document.get(of_two).cloned().unwrap_or_default();
            alone.insert(key.into(), value);
        }
        camera(&Value::Mapping(alone), &format!("{stem}_{number}"))
    };
    Ok(vec![one(1, first)?, one(2, second)?])
}

/// The camera of a document; a camera without a name gets that of its file.
fn camera(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    check_binning(document)?;
    let (key, matrix) = first(document, &MATRIX).ok_or_else(|| missing(MATRIX[0]))?;
    let mut intrinsics = intrinsics(key, matrix)?;
    let coefficients = match first(document, &COEFFICIENTS) {
        Some((key, value)) => (key, numbers(key, value)?),
        None => (COEFFICIENTS[0], Vec::new()),
    };
    let keys = Keys {
        model: "distortion_model",
        coefficients: coefficients.0,
    };
    let mut size = [size(document, 0)?, size(document, 1)?];
    if let Some(shown) = region(document)? {
        let [x, y] = shown.upper_left;
        size = shown.size;
        (intrinsics.cx, intrinsics.cy) = (intrinsics.cx - x, intrinsics.cy - y);
    }
    let lens = lens_of(&keys, model(document), intrinsics, &coefficients.1, size)?;
    let name = document.get("camera_name").and_then(Value::as_str);
    let id = CameraId::new(&name_of(name.unwrap_or(stem)))
        .map_err(|error| Complaint::new("camera_name", error.to_string(), ""))?;
    Ok(Camera::new(id, size, lens, None))
}

/// Width (0) or height (1): a key of its own, or a part of PhotonVision's `resolution` or of a list of both.
fn size(document: &Value, axis: usize) -> Result<u32, Complaint> {
    let keys = [&WIDTH, &HEIGHT][axis];
    if let Some((key, value)) = first(document, keys) {
        return pixels(key, value);
    }
    let both = first(document, &["resolution", "image_size", "img_size"]);
    let part = both.and_then(|(key, both)| {
        let part = both
            .get(["width", "height"][axis])
            .or_else(|| both.get(axis))?;
        Some(pixels(key, part))
    });
    part.unwrap_or_else(|| {
        let cause = "the file does not say the size of the images";
        let remedy =
            "add `image_width: ...` and `image_height: ...`, those with which it was calibrated";
        Err(Complaint::new(keys[0], cause, remedy))
    })
}

/// ROS names the model; OpenCV's sample writes `fisheye_model: 1`, and nothing for its polynomial.
fn model(document: &Value) -> &str {
    let stated = document.get("distortion_model").and_then(Value::as_str);
    let fisheye = document.get("fisheye_model").and_then(Value::as_f64);
    match (stated, fisheye) {
        (Some(model), _) => model,
        (None, Some(flag)) if flag != 0.0 => "fisheye",
        _ => "plumb_bob",
    }
}

/// A part of the full image, in its pixels.
struct Region {
    upper_left: [f64; 2],
    size: [u32; 2],
}

/// The part of the full image that a message's images show; nothing where that is all.
fn region(document: &Value) -> Result<Option<Region>, Complaint> {
    let Some(roi) = document.get("roi") else {
        return Ok(None);
    };
    let number = |key: &str| roi.get(key).and_then(Value::as_f64).unwrap_or(0.0);
    if number("width") == 0.0 || number("height") == 0.0 {
        return Ok(None);
    }
    let size = |key: &str| pixels("roi", roi.get(key).unwrap_or(&Value::Null));
    Ok(Some(Region {
        upper_left: [number("x_offset"), number("y_offset")],
        size: [size("width")?, size("height")?],
    }))
}

/// A message with binning describes images of another size.
fn check_binning(document: &Value) -> Result<(), Complaint> {
    for key in ["binning_x", "binning_y"] {
        let binning = document.get(key).and_then(Value::as_f64).unwrap_or(0.0);
        if binning > 1.0 {
            return Err(Complaint::new(
                key,
                format!(
                    "the images are binned by {binning}, but the calibration is that of full ones"
                ),
                "calibrate at the resolution that is used",
            ));
        }
    }
    Ok(())
}

/// The file of a camera in the format of ROS's `camera_calibration_parsers`.
pub(super) fn text(camera: &Camera) -> String {
    let [width, height] = camera.resolution;
    let Intrinsics { fx, fy, cx, cy } = camera.lens.intrinsics();
    let (model, coefficients) = ros_distortion(&camera.lens);
    format!(
        "image_width: {width}
image_height: {height}
camera_name: {}
camera_matrix:
  rows: 3
  cols: 3
  data: [{fx:?}, 0.0, {cx:?}, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 1.0]
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {}
  data: {coefficients:?}
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [{fx:?}, 0.0, {cx:?}, 0.0, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 0.0, 1.0, 0.0]
",
        camera.id,
        coefficients.len()
    )
}
