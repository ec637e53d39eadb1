//! The noise of a tag's corners before anything is learned of it: as its detector states it, or the usual one.

use nalgebra::{Matrix2, Point2};

use crate::measurement::edge_modes::{EdgeModes, Matrix8};
use crate::measurement::view_equations::NoiseSource;
use crate::{FusionOptions, TagCorners};

/// Area in px² of a tag with the usual noise.
const USUAL_AREA: f64 = 400.0;
/// Smallest and largest tag, against that area, to which the noise follows.
const USUAL_BOUNDS: (f64, f64) = (0.1, 10.0);

/// Of the corners of one view.
pub(crate) struct CornerNoise {
    /// Who says so.
    pub source: NoiseSource,
    /// Of each corner by itself, 1/px².
    pub information: [Matrix2<f64>; 4],
    /// Of all corners together.
    pub edges: EdgeModes,
    /// Whether it is stated how their errors hang together; else they are independent.
    pub is_joint: bool,
}

impl CornerNoise {
    /// As stated, what is said of pairs only where it is the covariance of something; the usual noise where nothing or nonsense is
    /// stated. The floor and `misplaced`, in px², come on top. `None` where the corners enclose nothing.
    pub fn of(seen: &TagCorners, misplaced: f64, options: &FusionOptions) -> Option<Self> {
        let floor = options.corner_floor_px.powi(2);
        let widened = |noise: Matrix8| noise + of_all(floor) + of_all(misplaced);
        let modes = |noise: &Matrix8| EdgeModes::new(&seen.corners, noise);
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
            .and_then(|joint| modes(&joint));
        let is_joint = joint.is_some();
        Some(Self {
            source,
            information: corners_of(&own).map(|own| own.try_inverse().unwrap_or_default()),
            edges: joint.or_else(|| modes(&own))?,
            is_joint,
        })
    }
}

/// Of x and y of each corner in turn, all alike and independent.
fn of_all(variance: f64) -> Matrix8 {
    Matrix8::from_diagonal_element(variance)
}

/// What is said of each corner by itself.
fn corners_of(noise: &Matrix8) -> [Matrix2<f64>; 4] {
    [0, 2, 4, 6].map(|x| noise.fixed_view::<2, 2>(x, x).into_owned())
}

/// The usual noise of a tag's corners in px²: the larger the tag, the more pixels its corners are made from.
fn usual_variance(corners: &[Point2<f64>; 4], options: &FusionOptions) -> f64 {
    let relative = (area_px2(corners) / USUAL_AREA).clamp(USUAL_BOUNDS.0, USUAL_BOUNDS.1);
    options.corner_sigma_px.powi(2) * relative.powf(-0.5)
}

/// What the corners enclose.
pub(crate) fn area_px2([a, b, c, d]: &[Point2<f64>; 4]) -> f64 {
    0.5 * (c - a).perp(&(d - b)).abs()
}
