//! Covariance of the corners of a view: as its detector reports it, or the configured default.

use nalgebra::{Matrix2, Point2, SVector, Vector2};

use crate::FusionOptions;
use crate::measurement::view_equations::NoiseSource;
use crate::measurement::whitening::{Matrix8, Whitening};
use sextant_site_model::TagCorners;

/// Area in px² of a tag with the usual noise.
const USUAL_AREA: f64 = 400.0;
/// Smallest and largest tag, against that area, to which the noise follows.
const USUAL_BOUNDS: (f64, f64) = (0.1, 10.0);

/// Area of a tag that is none, px².
const LEAST_AREA: f64 = 1e-12;

/// Of the corners of one view.
pub(crate) struct CornerNoise {
    /// Source of the covariance.
    pub source: NoiseSource,
    /// Of each corner by itself, 1/px².
    pub information: [Matrix2<f64>; 4],
    /// Whitens the residuals of all corners.
    pub whitening: Whitening,
    /// Whether the correlations between corners are reported; else the corners are independent.
    pub is_joint: bool,
}

impl CornerNoise {
    /// As reported, with correlations only where they form a covariance; the default noise where nothing usable is
    /// reported. The floor and what errors of the models displace are added. `None` where the corners enclose no area.
    pub fn from_corners(
        seen: &TagCorners,
        displacement: &Displacement,
        options: &FusionOptions,
    ) -> Option<Self> {
        let floor = options.corner_floor_px.powi(2);
        let displaced = displacement.covariance(&seen.corners);
        let widened = |noise: Matrix8| noise + of_all(floor) + displaced;
        if area_px2(&seen.corners) < LEAST_AREA {
            return None;
        }
        let stated = seen.own_covariance();
        let is_sensible = |own: &Matrix2<f64>| own.trace() > 0.0 && own.determinant() > 0.0;
        let (source, own) = if corners_of(&stated).iter().all(is_sensible) {
            (NoiseSource::Detector, stated)
        } else {
            let usual = usual_variance(&seen.corners, options);
            (NoiseSource::Nobody, of_all(usual))
        };
        let own = widened(own);
        let joint = (source == NoiseSource::Detector && seen.is_joint())
            .then(|| widened(seen.covariance()))
            .and_then(|joint| Whitening::new(&joint));
        let is_joint = joint.is_some();
        Some(Self {
            source,
            information: corners_of(&own).map(|own| own.try_inverse().unwrap_or_default()),
            whitening: joint.or_else(|| Whitening::new(&own))?,
            is_joint,
        })
    }
}

/// Variances by which errors of models displace the corners of a view against other views.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Displacement {
    /// Of each corner by itself along either axis, px²: images of other cameras are of other moments, and a filter that
    /// took the difference of two cameras for exact would take it for motion.
    pub apart: f64,
    /// Variance of the shift of all corners along either axis, px².
    pub shift: f64,
    /// Variance of the angle by which they turn about their middle, rad².
    pub turn: f64,
    /// Variance of the logarithm of their distances from it.
    pub scale: f64,
}

impl Displacement {
    /// Covariance of x and y of each corner in turn, px².
    fn covariance(&self, corners: &[Point2<f64>; 4]) -> Matrix8 {
        let sum = corners
            .iter()
            .fold(Vector2::zeros(), |sum, corner| sum + corner.coords);
        let from_middle = corners.map(|corner| corner.coords - sum / 4.0);
        let mode = |direction: fn(&Vector2<f64>) -> Vector2<f64>| {
            let of_corners = from_middle.map(|arm| direction(&arm));
            SVector::<f64, 8>::from_fn(|at, _| of_corners[at / 2][at % 2])
        };
        let (turned, scaled) = (mode(|arm| Vector2::new(-arm.y, arm.x)), mode(|arm| *arm));
        let shifted = Matrix8::from_fn(|row, column| f64::from(u8::from(row % 2 == column % 2)));
        of_all(self.apart)
            + shifted * self.shift
            + turned * turned.transpose() * self.turn
            + scaled * scaled.transpose() * self.scale
    }
}

/// Covariance of all corners with independent coordinates of one variance.
fn of_all(variance: f64) -> Matrix8 {
    Matrix8::from_diagonal_element(variance)
}

/// Covariance of each corner.
fn corners_of(noise: &Matrix8) -> [Matrix2<f64>; 4] {
    [0, 2, 4, 6].map(|x| noise.fixed_view::<2, 2>(x, x).into_owned())
}

/// Default variance of the corners of a tag, px²: the larger the tag, the more pixels make its corners.
fn usual_variance(corners: &[Point2<f64>; 4], options: &FusionOptions) -> f64 {
    let relative = (area_px2(corners) / USUAL_AREA).clamp(USUAL_BOUNDS.0, USUAL_BOUNDS.1);
    options.corner_sigma_px.powi(2) * relative.powf(-0.5)
}

/// Area within the corners, px².
pub(crate) fn area_px2([a, b, c, d]: &[Point2<f64>; 4]) -> f64 {
    0.5 * (c - a).perp(&(d - b)).abs()
}
