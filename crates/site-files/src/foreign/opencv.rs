//! OpenCV's dialect of YAML: its version line and its tag for matrices.

use super::distortion::ros_distortion;
use sextant_geometry::{Intrinsics, LensModel};
use sextant_site_model::Camera;

/// Removes the line `%YAML:1.0` or `%YAML 1.2`, of which OpenCV's former is no valid directive, and its tag
/// `!!opencv-matrix`: the rest is plain YAML. Line numbers and other texts are unchanged.
pub(super) fn as_plain_yaml(text: &str) -> String {
    let text = match text.strip_prefix("%YAML") {
        Some(rest) => format!("#{rest}"),
        None => text.to_owned(),
    };
    text.replace("!!opencv-matrix", "")
}

/// The file of a camera in the format of OpenCV's calibration sample.
pub(super) fn text(camera: &Camera) -> String {
    let [width, height] = camera.resolution;
    let Intrinsics { fx, fy, cx, cy } = camera.lens.intrinsics();
    let (_, coefficients) = ros_distortion(&camera.lens);
    let fisheye = u8::from(camera.lens.model() == LensModel::KannalaBrandt);
    format!(
        "%YAML:1.0
---
camera_name: \"{}\"
image_width: {width}
image_height: {height}
fisheye_model: {fisheye}
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ {fx:?}, 0., {cx:?}, 0., {fy:?}, {cy:?}, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: {}
   cols: 1
   dt: d
   data: {coefficients:?}
",
        camera.id,
        coefficients.len()
    )
}
