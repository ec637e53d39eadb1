//! A lens from and to a vector of parameters, for calibration, and the table of `rig.toml`.

use super::distortion::Distortion;
use super::{Intrinsics, Lens, LensError, LensModel, LensParameters};

impl Lens {
    /// How many parameters this lens has.
    pub fn n_parameters(&self) -> usize {
        self.model().n_parameters()
    }

    /// fx, fy, cx, cy, then the distortion's coefficients in the order of `rig.toml`.
    pub fn parameters(&self) -> Vec<f64> {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics();
        [fx, fy, cx, cy]
            .iter()
            .chain(self.distortion())
            .copied()
            .collect()
    }

    /// A lens of the same model with other parameters.
    pub fn with_parameters(&self, parameters: &[f64]) -> Result<Self, LensError> {
        Self::from_parameters(self.model(), parameters)
    }

    /// The lens of a model with the given [`Lens::parameters`].
    pub fn from_parameters(model: LensModel, parameters: &[f64]) -> Result<Self, LensError> {
        match (model, parameters) {
            (LensModel::Pinhole, &[fx, fy, cx, cy]) => Self::pinhole(Intrinsics { fx, fy, cx, cy }),
            (LensModel::BrownConrady, &[fx, fy, cx, cy, k1, k2, p1, p2, k3]) => {
                Self::brown_conrady(Intrinsics { fx, fy, cx, cy }, [k1, k2, p1, p2, k3])
            }
            (LensModel::KannalaBrandt, &[fx, fy, cx, cy, k1, k2, k3, k4]) => {
                Self::kannala_brandt(Intrinsics { fx, fy, cx, cy }, [k1, k2, k3, k4])
            }
            _ => Err(LensError::ParameterCount {
                model,
                given: parameters.len(),
            }),
        }
    }
}

impl TryFrom<LensParameters> for Lens {
    type Error = LensError;

    fn try_from(parameters: LensParameters) -> Result<Self, LensError> {
        use LensParameters::{BrownConrady, KannalaBrandt, Pinhole};
        match parameters {
            Pinhole { fx, fy, cx, cy } => Self::pinhole(Intrinsics { fx, fy, cx, cy }),
            BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::brown_conrady(Intrinsics { fx, fy, cx, cy }, distortion),
            KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion,
            } => Self::kannala_brandt(Intrinsics { fx, fy, cx, cy }, distortion),
        }
    }
}

impl From<Lens> for LensParameters {
    fn from(lens: Lens) -> Self {
        let Intrinsics { fx, fy, cx, cy } = lens.intrinsics;
        match lens.distortion {
            Distortion::None => Self::Pinhole { fx, fy, cx, cy },
            Distortion::BrownConrady(model) => Self::BrownConrady {
                fx,
                fy,
                cx,
                cy,
                distortion: *model.coefficients(),
            },
            Distortion::KannalaBrandt(model) => Self::KannalaBrandt {
                fx,
                fy,
                cx,
                cy,
                distortion: *model.coefficients(),
            },
        }
    }
}
