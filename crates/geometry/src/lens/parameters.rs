//! Parameters of a lens: intrinsics, models, their ranges, and the table of `rig.toml`.

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The most parameters any model has: fx, fy, cx, cy and five of Brown-Conrady.
pub const MAX_PARAMETERS: usize = 9;

/// Derivatives of a pixel with respect to a lens's parameters; columns from `Lens::n_parameters` on are zero.
pub type ParameterJacobian = SMatrix<f64, 2, MAX_PARAMETERS>;

/// Least focal length, pixels: even a fisheye of a tiny picture has more.
const MIN_FOCAL_LENGTH: f64 = 1.0;
/// Larger pixel figures than any sensor has; the bound keeps every product finite.
const MAX_PIXELS: f64 = 1e6;
/// Larger coefficients than any calibration gives; the bound keeps every polynomial of the field finite.
const MAX_COEFFICIENT: f64 = 1e6;
/// Least invertible radius, about half a degree: a lens with less has wrong coefficients.
const MIN_RADIUS: f64 = 0.01;

/// Focal lengths and principal point, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal length along the rows, in pixel widths.
    pub fx: f64,
    /// Focal length along the columns, in pixel heights.
    pub fy: f64,
    /// Column of the principal point.
    pub cx: f64,
    /// Row of the principal point.
    pub cy: f64,
}

/// The lens models, by the names they have in `rig.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LensModel {
    /// No distortion.
    Pinhole,
    /// Radial and tangential polynomials of the normalised radius: ordinary lenses.
    BrownConrady,
    /// A polynomial of the angle off the axis: wide and fisheye lenses.
    KannalaBrandt,
}

/// Why numbers are no lens.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LensError {
    /// A focal length that no camera has.
    #[error("focal length {name} = {} must be between 1 and 1e6 pixels", short(*value))]
    FocalLength {
        /// `fx` or `fy`.
        name: &'static str,
        /// As given.
        value: f64,
    },
    /// Another number that is not finite or absurdly large.
    #[error("{name} = {} must be finite and at most 1e6 in size", short(*value))]
    OutOfRange {
        /// The parameter, such as `cx` or `k1`.
        name: &'static str,
        /// As given.
        value: f64,
    },
    /// The distortion folds over almost at the axis.
    #[error(
        "this distortion can only be inverted up to {:.2} degrees off the axis: check the order \
         and units of its coefficients",
        half_angle.to_degrees()
    )]
    FieldTooNarrow {
        /// Half opening angle of the valid field, radians.
        half_angle: f64,
    },
    /// A list of parameters of the wrong length.
    #[error("a {model} lens has {} parameters, {given} were given", model.n_parameters())]
    ParameterCount {
        /// The requested model.
        model: LensModel,
        /// How many numbers came.
        given: usize,
    },
}

/// A name that is no lens model.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no lens model is called {0:?}; there are pinhole, brown-conrady and kannala-brandt")]
pub struct UnknownLensModel(String);

impl LensModel {
    /// All models.
    pub const ALL: [Self; 3] = [Self::Pinhole, Self::BrownConrady, Self::KannalaBrandt];

    /// The name in `rig.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::BrownConrady => "brown-conrady",
            Self::KannalaBrandt => "kannala-brandt",
        }
    }

    /// How many parameters a lens of this model has, the four intrinsics included.
    pub fn n_parameters(self) -> usize {
        match self {
            Self::Pinhole => 4,
            Self::BrownConrady => 9,
            Self::KannalaBrandt => 8,
        }
    }
}

impl fmt::Display for LensModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for LensModel {
    type Err = UnknownLensModel;

    fn from_str(name: &str) -> Result<Self, UnknownLensModel> {
        let found = Self::ALL.into_iter().find(|model| model.name() == name);
        found.ok_or_else(|| UnknownLensModel(name.to_owned()))
    }
}

/// A number as a person writes it: without hundreds of digits.
fn short(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-4..1e9).contains(&size) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

impl Intrinsics {
    pub(super) fn check(&self) -> Result<(), LensError> {
        for (name, value) in [("fx", self.fx), ("fy", self.fy)] {
            if !(MIN_FOCAL_LENGTH..=MAX_PIXELS).contains(&value) {
                return Err(LensError::FocalLength { name, value });
            }
        }
        check_sizes(&["cx", "cy"], &[self.cx, self.cy], MAX_PIXELS)
    }
}

pub(super) fn check_coefficients(names: &[&'static str], values: &[f64]) -> Result<(), LensError> {
    check_sizes(names, values, MAX_COEFFICIENT)
}

pub(super) fn check_field(max_radius: f64) -> Result<(), LensError> {
    if max_radius >= MIN_RADIUS {
        return Ok(());
    }
    Err(LensError::FieldTooNarrow {
        half_angle: max_radius.atan(),
    })
}

fn check_sizes(names: &[&'static str], values: &[f64], bound: f64) -> Result<(), LensError> {
    let fits = |value: &f64| value.abs() <= bound; // false for NaN
    match names.iter().zip(values).find(|(_, value)| !fits(value)) {
        Some((&name, &value)) => Err(LensError::OutOfRange { name, value }),
        None => Ok(()),
    }
}

/// A lens as its numbers, not yet checked: the `lens` table of `rig.toml`, and what other formats convert to.
// Struct variants, because serde refuses unknown keys of an internally tagged enum only for those, and never together
// with `flatten`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs, reason = "the intrinsics are those of `Intrinsics`")]
pub enum LensParameters {
    /// No distortion.
    Pinhole { fx: f64, fy: f64, cx: f64, cy: f64 },
    /// Distortion k1, k2, p1, p2, k3.
    BrownConrady {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        distortion: [f64; 5],
    },
    /// Distortion k1, k2, k3, k4.
    KannalaBrandt {
        fx: f64,
        fy: f64,
        cx: f64,
        cy: f64,
        distortion: [f64; 4],
    },
}
