//! Numbers, lists and matrices of a YAML value, by key.

use crate::error::Complaint;
use sextant_geometry::{Intrinsics, Pose, PoseParts};
use yaml_serde::Value;

/// Largest deviation of a 3x3 matrix from a rotation, per element.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// The first present key of several spellings, and its value.
pub(super) fn first<'a>(
    document: &'a Value,
    keys: &[&'static str],
) -> Option<(&'static str, &'a Value)> {
    keys.iter()
        .find_map(|&key| Some((key, document.get(key)?)))
        .filter(|(_, value)| !value.is_null())
}

/// The error for a missing key.
pub(super) fn missing(key: &str) -> Complaint {
    Complaint::new(
        key,
        "it is missing",
        "export it again from the tool that made it",
    )
}

/// A list of finite numbers: a YAML list, a list of rows, or an OpenCV matrix with its `data`.
pub(super) fn numbers(key: &str, value: &Value) -> Result<Vec<f64>, Complaint> {
    let list = value.get("data").unwrap_or(value);
    let mut numbers = Vec::new();
    flatten(list, &mut numbers)
        .ok_or_else(|| Complaint::new(key, "this is no list of finite numbers", ""))?;
    Ok(numbers)
}

fn flatten(value: &Value, numbers: &mut Vec<f64>) -> Option<()> {
    match value {
        Value::Sequence(items) => items.iter().try_for_each(|item| flatten(item, numbers)),
        Value::Number(number) => {
            let number = number.as_f64().filter(|number| number.is_finite())?;
            numbers.push(number);
            Some(())
        }
        _ => None,
    }
}

/// Exactly `N` numbers.
pub(super) fn exactly<const N: usize>(key: &str, numbers: Vec<f64>) -> Result<[f64; N], Complaint> {
    let given = numbers.len();
    numbers
        .try_into()
        .map_err(|_| Complaint::new(key, format!("{given} numbers where {N} belong"), ""))
}

/// A number of pixels as an integer.
pub(super) fn pixels(key: &str, value: &Value) -> Result<u32, Complaint> {
    // OpenCV's sample writes sizes as integers, others as 640.0.
    let number = value
        .as_f64()
        .filter(|n| n.fract() == 0.0 && (1.0..=65535.0).contains(n));
    number
        .map(|number| number as u32)
        .ok_or_else(|| Complaint::new(key, "this is no number of pixels from 1 to 65535", ""))
}

/// Focal lengths and principal point of a camera matrix, row by row; refuses skew and other matrices.
pub(super) fn intrinsics(key: &str, value: &Value) -> Result<Intrinsics, Complaint> {
    let all: [f64; 9] = exactly(key, numbers(key, value)?)?;
    if all == [0.0; 9] {
        let cause = "all zeros: this camera has not been calibrated";
        return Err(Complaint::new(
            key,
            cause,
            "calibrate its lens: `sextant calibrate lens`",
        ));
    }
    let [fx, skew, cx, shear, fy, cy, a, b, one] = all;
    if skew != 0.0 {
        return Err(Complaint::new(
            key,
            format!("a skew of {skew} pixels: its rows and columns are not at right angles"),
            "our lenses have none; calibrate again without it",
        ));
    }
    if [shear, a, b, one] != [0.0, 0.0, 0.0, 1.0] {
        return Err(Complaint::new(
            key,
            "this is no camera matrix",
            "it is [fx 0 cx 0 fy cy 0 0 1]",
        ));
    }
    Ok(Intrinsics { fx, fy, cx, cy })
}

/// A rigid motion of a 4x4 matrix.
pub(super) fn pose(key: &str, value: &Value) -> Result<Pose, Complaint> {
    let m: [f64; 16] = exactly(key, numbers(key, value)?)?;
    let rows = nalgebra::Matrix4::from_row_slice(&m);
    let rotation: nalgebra::Matrix3<f64> = rows.fixed_view::<3, 3>(0, 0).into();
    let off = (rotation * rotation.transpose() - nalgebra::Matrix3::identity()).amax();
    let last = [m[12], m[13], m[14], m[15] - 1.0];
    // The comparison also refuses NaN.
    let is_rigid = off <= ROTATION_TOLERANCE && rotation.determinant() > 0.0 && last == [0.0; 4];
    if !is_rigid {
        return Err(Complaint::new(
            key,
            "this is no rotation with a translation",
            "",
        ));
    }
    let rotation = nalgebra::UnitQuaternion::from_matrix(&rotation);
    Ok(Pose::from_parts(
        nalgebra::Translation3::new(m[3], m[7], m[11]),
        rotation,
    ))
}

/// A pose as a 4x4 matrix, row by row.
pub(super) fn rows_of(pose: &Pose) -> [[f64; 4]; 4] {
    let matrix = pose.to_homogeneous();
    [0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|column| matrix[(row, column)]))
}

/// Checks that numbers are a valid pose.
pub(super) fn is_writable(pose: &Pose) -> bool {
    PoseParts::from(pose).to_pose().is_ok()
}
