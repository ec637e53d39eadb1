//! What lies between normalised and distorted points: one of the models, each with its valid field.

use super::brown_conrady::BrownConrady;
use super::kannala_brandt::KannalaBrandt;
use super::parameters::{LensError, LensModel, ParameterJacobian};
use super::valid_field::MAX_RADIUS;
use nalgebra::{Matrix2, Vector2};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Distortion {
    None,
    BrownConrady(BrownConrady),
    KannalaBrandt(KannalaBrandt),
}

impl Distortion {
    pub(super) fn brown_conrady(coefficients: [f64; 5]) -> Result<Self, LensError> {
        BrownConrady::new(coefficients).map(Self::BrownConrady)
    }

    pub(super) fn kannala_brandt(coefficients: [f64; 4]) -> Result<Self, LensError> {
        KannalaBrandt::new(coefficients).map(Self::KannalaBrandt)
    }

    pub(super) fn model(&self) -> LensModel {
        match self {
            Self::None => LensModel::Pinhole,
            Self::BrownConrady(_) => LensModel::BrownConrady,
            Self::KannalaBrandt(_) => LensModel::KannalaBrandt,
        }
    }

    pub(super) fn coefficients(&self) -> &[f64] {
        match self {
            Self::None => &[],
            Self::BrownConrady(model) => model.coefficients(),
            Self::KannalaBrandt(model) => model.coefficients(),
        }
    }

    pub(super) fn max_radius(&self) -> f64 {
        match self {
            Self::None => MAX_RADIUS,
            Self::BrownConrady(model) => model.max_radius(),
            Self::KannalaBrandt(model) => model.max_radius(),
        }
    }

    /// The distorted point, `None` outside the valid field.
    pub(super) fn distort(&self, normalised: &Vector2<f64>) -> Option<Vector2<f64>> {
        self.holds(normalised).then(|| match self {
            Self::None => *normalised,
            Self::BrownConrady(model) => model.distort(normalised),
            Self::KannalaBrandt(model) => model.distort(normalised),
        })
    }

    /// As [`Distortion::distort`], with the derivative with respect to the normalised point.
    pub(super) fn distort_with_jacobian(
        &self,
        normalised: &Vector2<f64>,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        self.holds(normalised).then(|| match self {
            Self::None => (*normalised, Matrix2::identity()),
            Self::BrownConrady(model) => model.distort_with_jacobian(normalised),
            Self::KannalaBrandt(model) => model.distort_with_jacobian(normalised),
        })
    }

    /// The derivative of the distorted point with respect to the coefficients, from column four on.
    pub(super) fn coefficient_jacobian(&self, normalised: &Vector2<f64>) -> ParameterJacobian {
        let mut jacobian = ParameterJacobian::zeros();
        match self {
            Self::None => {}
            Self::BrownConrady(model) => {
                let by_coefficients = model.coefficient_jacobian(normalised);
                jacobian
                    .fixed_view_mut::<2, 5>(0, 4)
                    .copy_from(&by_coefficients);
            }
            Self::KannalaBrandt(model) => {
                let by_coefficients = model.coefficient_jacobian(normalised);
                jacobian
                    .fixed_view_mut::<2, 4>(0, 4)
                    .copy_from(&by_coefficients);
            }
        }
        jacobian
    }

    /// The normalised point inside the valid field that is seen at `distorted`, if there is one.
    pub(super) fn undistort(&self, distorted: &Vector2<f64>) -> Option<Vector2<f64>> {
        match self {
            Self::None => self.holds(distorted).then_some(*distorted),
            Self::BrownConrady(model) => model.undistort(distorted),
            Self::KannalaBrandt(model) => model.undistort(distorted),
        }
    }

    /// Whether a normalised point lies in the valid field; false for what is not finite.
    fn holds(&self, normalised: &Vector2<f64>) -> bool {
        let max_radius = self.max_radius();
        normalised.norm_squared() <= max_radius * max_radius
    }
}
