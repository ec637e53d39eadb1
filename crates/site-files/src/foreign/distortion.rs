//! Distortion models of other tools and the corresponding lenses.

use crate::error::Complaint;
use sextant_geometry::{Intrinsics, Lens, LensModel};

/// Location of a lens's parameters in the file, for messages.
pub(super) struct Keys {
    pub model: &'static str,
    pub coefficients: &'static str,
}

/// The lens of a model name of ROS, Kalibr or OpenCV.
pub(super) fn lens_of(
    keys: &Keys,
    model: &str,
    intrinsics: Intrinsics,
    coefficients: &[f64],
) -> Result<Lens, Complaint> {
    let lens = match model {
        "plumb_bob" | "radtan" | "rational_polynomial" => {
            polynomial(keys, intrinsics, coefficients)?
        }
        "equidistant" | "fisheye" => {
            let coefficients = four(keys, model, coefficients)?;
            Lens::kannala_brandt(intrinsics, coefficients)
        }
        "none" | "" => match coefficients.iter().all(|&k| k == 0.0) {
            true => Lens::pinhole(intrinsics),
            false => polynomial(keys, intrinsics, coefficients)?,
        },
        other => {
            return Err(Complaint::new(
                keys.model,
                format!("the distortion model `{other}` has no counterpart here"),
                "calibrate with plumb_bob (radtan) or equidistant (fisheye)",
            ));
        }
    };
    lens.map_err(|error| Complaint::new(keys.coefficients, error.to_string(), ""))
}

/// k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]] in OpenCV's order; everything from k4 on must be zero.
fn polynomial(
    keys: &Keys,
    intrinsics: Intrinsics,
    coefficients: &[f64],
) -> Result<Result<Lens, sextant_geometry::LensError>, Complaint> {
    if ![0, 4, 5, 8, 12, 14].contains(&coefficients.len()) {
        return Err(count(keys, coefficients, "0, 4, 5, 8, 12 or 14"));
    }
    let mut five = [0.0; 5];
    for (ours, theirs) in five.iter_mut().zip(coefficients) {
        *ours = *theirs;
    }
    if coefficients.iter().skip(5).any(|&k| k != 0.0) {
        return Err(Complaint::new(
            keys.coefficients,
            "rational or thin-prism terms (k4 and beyond) are not zero, and our lenses have none",
            "calibrate with five coefficients (plumb_bob), or as equidistant where the lens is wide",
        ));
    }
    Ok(match five == [0.0; 5] {
        true => Lens::pinhole(intrinsics),
        false => Lens::brown_conrady(intrinsics, five),
    })
}

fn four(keys: &Keys, model: &str, coefficients: &[f64]) -> Result<[f64; 4], Complaint> {
    coefficients
        .try_into()
        .map_err(|_| count(keys, coefficients, &format!("4 of {model}")))
}

fn count(keys: &Keys, coefficients: &[f64], expected: &str) -> Complaint {
    let cause = format!(
        "{} coefficients where {expected} belong",
        coefficients.len()
    );
    Complaint::new(keys.coefficients, cause, "")
}

/// Name and coefficients of a lens model in ROS.
pub(super) fn ros_distortion(lens: &Lens) -> (&'static str, Vec<f64>) {
    match lens.model() {
        LensModel::KannalaBrandt => ("equidistant", lens.distortion().to_vec()),
        LensModel::Pinhole => ("plumb_bob", vec![0.0; 5]),
        LensModel::BrownConrady => ("plumb_bob", lens.distortion().to_vec()),
    }
}
