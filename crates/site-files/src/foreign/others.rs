//! Calibrations of nerfstudio, MATLAB, VINS and others of camodocal's kind: one camera each.
//!
//! Two count pixels from elsewhere: COLMAP and nerfstudio have (0, 0) at the corner of the top left pixel, half a pixel
//! before its centre; MATLAB has (1, 1) at its centre.

use super::distortion::{Keys, lens_of};
use super::matrix::{exactly, first, intrinsics, missing, numbers, pixels};
use super::name_of;
use crate::error::Complaint;
use sextant_geometry::{Intrinsics, Lens};
use sextant_site_model::{Camera, CameraId};
use yaml_serde::Value;

/// nerfstudio's `transforms.json`. The poses of its frames are those of one moving camera and are passed over.
pub(super) fn nerfstudio(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    let fx = number(document, "fl_x")?;
    let intrinsics = Intrinsics {
        fx,
        fy: optional(document, "fl_y")?.unwrap_or(fx),
        cx: number(document, "cx")? - 0.5,
        cy: number(document, "cy")? - 0.5,
    };
    let model = text(document, "camera_model").unwrap_or("OPENCV");
    let (model, terms): (_, &[&str]) = match model {
        "OPENCV_FISHEYE" => ("equidistant", &["k1", "k2", "k3", "k4"]),
        "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" | "SIMPLE_RADIAL" | "RADIAL" => {
            ("plumb_bob", &["k1", "k2", "p1", "p2", "k3"])
        }
        other => (other, &[]),
    };
    let coefficients: Result<Vec<f64>, Complaint> = terms
        .iter()
        .map(|term| Ok(optional(document, term)?.unwrap_or(0.0)))
        .collect();
    let size = [size(document, "w")?, size(document, "h")?];
    let keys = Keys {
        model: "camera_model",
        coefficients: "k1",
    };
    let lens = lens_of(&keys, model, intrinsics, &coefficients?, size)?;
    named(stem, size, lens)
}

/// MATLAB's `cameraParameters` or `cameraIntrinsics`, as `jsonencode(toStruct(parameters))` writes them.
pub(super) fn matlab(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    let list = |key: &'static str| match document.get(key) {
        Some(value) => numbers(key, value),
        None => Err(missing(key)),
    };
    let [rows, columns] = exactly("ImageSize", list("ImageSize")?)?;
    let size = [
        pixels("ImageSize", &columns.into())?,
        pixels("ImageSize", &rows.into())?,
    ];
    let counted_from_one = matlab_intrinsics(document)?;
    let intrinsics = Intrinsics {
        cx: counted_from_one.cx - 1.0,
        cy: counted_from_one.cy - 1.0,
        ..counted_from_one
    };
    let radial = list("RadialDistortion")?;
    let [p1, p2] = match document.get("TangentialDistortion") {
        Some(_) => exactly("TangentialDistortion", list("TangentialDistortion")?)?,
        None => [0.0; 2],
    };
    let [k1, k2, k3] = match radial[..] {
        [k1, k2] => [k1, k2, 0.0],
        [k1, k2, k3] => [k1, k2, k3],
        _ => exactly("RadialDistortion", radial)?,
    };
    let keys = Keys {
        model: "",
        coefficients: "RadialDistortion",
    };
    let coefficients = [k1, k2, p1, p2, k3];
    let lens = lens_of(&keys, "plumb_bob", intrinsics, &coefficients, size)?;
    named(stem, size, lens)
}

/// `K`, or `IntrinsicMatrix`, which is its transpose, or `FocalLength` and `PrincipalPoint`.
fn matlab_intrinsics(document: &Value) -> Result<Intrinsics, Complaint> {
    if let Some((key, value)) = first(document, &["K"]) {
        return intrinsics(key, value);
    }
    if let Some((key, value)) = first(document, &["IntrinsicMatrix"]) {
        let m: [f64; 9] = exactly(key, numbers(key, value)?)?;
        let transposed = [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];
        return intrinsics(key, &transposed.to_vec().into());
    }
    let pair = |key: &'static str| {
        let (key, value) = first(document, &[key]).ok_or_else(|| missing(key))?;
        exactly(key, numbers(key, value)?)
    };
    let ([fx, fy], [cx, cy]) = (pair("FocalLength")?, pair("PrincipalPoint")?);
    Ok(Intrinsics { fx, fy, cx, cy })
}

/// Camodocal's files, which VINS-Mono and VINS-Fusion read: `model_type` and `projection_parameters`.
pub(super) fn camodocal(document: &Value, stem: &str) -> Result<Camera, Complaint> {
    let model = text(document, "model_type").unwrap_or_default();
    let (ours, focal, centre, terms) = match model {
        "PINHOLE" => (
            "plumb_bob",
            ["fx", "fy"],
            ["cx", "cy"],
            ["k1", "k2", "p1", "p2"],
        ),
        "KANNALA_BRANDT" => (
            "equidistant",
            ["mu", "mv"],
            ["u0", "v0"],
            ["k2", "k3", "k4", "k5"],
        ),
        other => {
            let cause = format!("the camera model `{other}` has no counterpart here");
            let remedy = "calibrate with PINHOLE, or with KANNALA_BRANDT where the lens is wide";
            return Err(Complaint::new("model_type", cause, remedy));
        }
    };
    let part = |key: &'static str| document.get(key).ok_or_else(|| missing(key));
    let projection = part("projection_parameters")?;
    let distortion = match model {
        "PINHOLE" => part("distortion_parameters")?,
        _ => projection,
    };
    let intrinsics = Intrinsics {
        fx: number(projection, focal[0])?,
        fy: number(projection, focal[1])?,
        cx: number(projection, centre[0])?,
        cy: number(projection, centre[1])?,
    };
    let coefficients: Result<Vec<f64>, Complaint> =
        terms.iter().map(|term| number(distortion, term)).collect();
    let size = [
        size(document, "image_width")?,
        size(document, "image_height")?,
    ];
    let keys = Keys {
        model: "model_type",
        coefficients: "distortion_parameters",
    };
    let lens = lens_of(&keys, ours, intrinsics, &coefficients?, size)?;
    let name = text(document, "camera_name").filter(|name| *name != "camera");
    named(name.unwrap_or(stem), size, lens)
}

fn named(name: &str, size: [u32; 2], lens: Lens) -> Result<Camera, Complaint> {
    let id = CameraId::new(&name_of(name));
    let id = id.map_err(|error| Complaint::new("", error.to_string(), "rename the file"))?;
    Ok(Camera::new(id, size, lens, None))
}

fn text<'a>(document: &'a Value, key: &str) -> Option<&'a str> {
    document.get(key).and_then(Value::as_str)
}

fn optional(document: &Value, key: &str) -> Result<Option<f64>, Complaint> {
    let number = |value: &Value| {
        let number = value.as_f64().filter(|number| number.is_finite());
        number.ok_or_else(|| Complaint::new(key, "this is no finite number", ""))
    };
    document.get(key).map(number).transpose()
}

fn number(document: &Value, key: &str) -> Result<f64, Complaint> {
    optional(document, key)?.ok_or_else(|| missing(key))
}

fn size(document: &Value, key: &str) -> Result<u32, Complaint> {
    pixels(key, document.get(key).ok_or_else(|| missing(key))?)
}
