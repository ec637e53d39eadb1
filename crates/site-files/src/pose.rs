//! Poses and their standard deviations as tables of a file.

use crate::error::Complaint;
use serde::Deserialize;
use sextant_geometry::{Pose, PoseParts};
use sextant_site_model::PoseSigma;

/// Largest deviation of a quaternion's length from 1; within it, it is normalised.
const QUATERNION_TOLERANCE: f64 = 1e-3;

/// What to do about an invalid standard deviation of a scale.
pub(crate) const SCALE_SIGMA_REMEDY: &str =
    "write a share of 1, such as 0.003 for 0.3 %, or leave it out";

/// Standard deviations of a pose, equal for all axes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SigmaTable {
    /// m.
    position: f64,
    /// rad.
    orientation: f64,
}

impl From<&SigmaTable> for PoseSigma {
    fn from(table: &SigmaTable) -> Self {
        Self {
            position_m: table.position,
            orientation_rad: table.orientation,
        }
    }
}

pub(crate) fn sigma_toml(sigma: &PoseSigma) -> String {
    format!(
        "{{ position = {:?}, orientation = {:?} }}",
        sigma.position_m, sigma.orientation_rad
    )
}

/// Checks a pose of the file; `key` names it in messages.
pub(crate) fn pose_of(parts: Option<&PoseParts>, key: &str) -> Result<Option<Pose>, Complaint> {
    let Some(parts) = parts else { return Ok(None) };
    if !parts.position.iter().all(|number| number.is_finite()) {
        let cause = format!("{:?} is not finite", parts.position);
        let remedy = "write three finite numbers in metres";
        return Err(Complaint::new(format!("{key}.position"), cause, remedy));
    }
    let length = parts.orientation.iter().map(|q| q * q).sum::<f64>().sqrt();
    // The comparison also refuses NaN.
    let is_unit = (length - 1.0).abs() <= QUATERNION_TOLERANCE;
    let turned = |cause| {
        let remedy = "write x, y, z, w of length 1; no rotation is [0, 0, 0, 1]";
        Complaint::new(format!("{key}.orientation"), cause, remedy)
    };
    if !is_unit {
        let cause = format!("this is no unit quaternion, its length is {length}");
        return Err(turned(cause));
    }
    let pose = parts.to_pose().map_err(|error| turned(error.to_string()))?;
    Ok(Some(pose))
}

pub(crate) fn pose_toml(pose: &PoseParts) -> String {
    let PoseParts {
        position,
        orientation,
    } = pose;
    format!("{{ position = {position:?}, orientation = {orientation:?} }}")
}
