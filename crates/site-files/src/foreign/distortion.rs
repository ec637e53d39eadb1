//! Distortion models of other tools and the corresponding lenses.

use super::refit::{MOST_PX, Rational};
use crate::error::Complaint;
use sextant_geometry::{Intrinsics, Lens, LensError, LensModel};

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
    size: [u32; 2],
) -> Result<Lens, Complaint> {
    let lens = match model {
        "plumb_bob" | "radtan" | "radial-tangential" | "rational_polynomial" => {
            polynomial(keys, intrinsics, coefficients, size)?
        }
        "equidistant" | "fisheye" => {
            let coefficients = four(keys, model, coefficients)?;
            Lens::kannala_brandt(intrinsics, coefficients)
        }
        "none" | "" => match coefficients.iter().all(|&k| k == 0.0) {
            true => Lens::pinhole(intrinsics),
            false => polynomial(keys, intrinsics, coefficients, size)?,
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

/// k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]] in OpenCV's order. With terms from k4 on, the nearest lens without
/// them.
fn polynomial(
    keys: &Keys,
    intrinsics: Intrinsics,
    coefficients: &[f64],
    size: [u32; 2],
) -> Result<Result<Lens, LensError>, Complaint> {
    if ![0, 4, 5, 8, 12, 14].contains(&coefficients.len()) {
        return Err(count(keys, coefficients, "0, 4, 5, 8, 12 or 14"));
    }
    let mut all = [0.0; 14];
    all[..coefficients.len()].copy_from_slice(coefficients);
    let [five @ .., _, _, _, _, _, _, _, _, _] = all;
    if all[12..] != [0.0; 2] {
        let cause = "a tilted sensor (tx, ty), which our lenses lack";
        return Err(Complaint::new(keys.coefficients, cause, FEWER));
    }
    if all[5..] != [0.0; 9] {
        return nearest(keys, intrinsics, &all, size).map(Ok);
    }
    Ok(match five == [0.0; 5] {
        true => Lens::pinhole(intrinsics),
        false => Lens::brown_conrady(intrinsics, five),
    })
}

const FEWER: &str =
    "calibrate with five coefficients (plumb_bob), or as equidistant where the lens is wide";

fn nearest(
    keys: &Keys,
    intrinsics: Intrinsics,
    all: &[f64; 14],
    size: [u32; 2],
) -> Result<Lens, Complaint> {
    let [coefficients @ .., _, _] = *all;
    let rational = Rational {
        intrinsics,
        coefficients,
    };
    let terms = "rational or thin-prism terms (k4 and beyond)";
    let cause = match rational.nearest(size) {
        Some((lens, off)) if off <= MOST_PX => return Ok(lens),
        Some((_, off)) => format!("{terms} that no lens here follows better than to {off:.1} px"),
        None => format!("{terms} that no lens here follows"),
    };
    Err(Complaint::new(keys.coefficients, cause, FEWER))
}

/// Four, and any number of zeros behind them.
fn four(keys: &Keys, model: &str, coefficients: &[f64]) -> Result<[f64; 4], Complaint> {
    match coefficients.split_first_chunk() {
        Some((four, rest)) if rest.iter().all(|&k| k == 0.0) => Ok(*four),
        _ => Err(count(keys, coefficients, &format!("4 of {model}"))),
    }
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
