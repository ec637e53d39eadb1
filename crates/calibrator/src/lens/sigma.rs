//! Standard deviations of a lens as in a rig file: of the focal length and of the distortion.
//!
//! The effect of parameter errors over the image is decomposed, by least squares over the cells of the maps, into a
//! rotation of the whole camera (which its pose absorbs), a change of the focal length and a displacement with the cube
//! of the distance from the centre. The covariance of the latter two follows from that of the parameters.

use super::calibration::LensCalibration;
use super::maps::{Movement, movements};
use nalgebra::{DMatrix, Matrix2x5, Matrix5, Point2, SMatrix};
use sextant_geometry::Lens;
use sextant_site_model::LensSigma;

/// Largest valid standard deviation in a rig file, px.
const MOST_PX: f64 = 100.0;

impl LensCalibration {
    /// One sigma of focal length and distortion, in pixels.
    pub fn sigma(&self) -> LensSigma {
        lens_sigma(&self.lens, self.resolution, &self.covariance)
    }
}

/// One sigma of focal length and distortion, in pixels, from the covariance of all parameters.
pub(crate) fn lens_sigma(
    lens: &Lens,
    resolution: [u32; 2],
    covariance: &DMatrix<f64>,
) -> LensSigma {
    let modes = covariance_of_modes(lens, resolution, covariance);
    let sigma = |mode: usize| {
        let variance = modes.as_ref().map_or(f64::NAN, |all| all[(mode, mode)]);
        let sigma = variance.max(0.0).sqrt();
        if sigma.is_finite() {
            sigma.min(MOST_PX)
        } else {
            MOST_PX
        }
    };
    LensSigma {
        focal_px: sigma(3),
        distortion_px: sigma(4),
    }
}

/// Of the turn, the focal length and the distortion; `None` where the picture does not tell them apart.
fn covariance_of_modes(
    lens: &Lens,
    resolution: [u32; 2],
    covariance: &DMatrix<f64>,
) -> Option<Matrix5<f64>> {
    let n = covariance.nrows();
    let reach_px = reach_px(lens, resolution);
    let (mut normal, mut right) = (Matrix5::zeros(), DMatrix::zeros(5, n));
    for (pixel, movement) in movements(lens, n, resolution) {
        let modes = modes(lens, &pixel, &movement, reach_px);
        normal += modes.transpose() * modes;
        right += modes.transpose() * &movement.by_parameters;
    }
    let by_parameters = normal.try_inverse()? * right;
    let covariance = &by_parameters * covariance * by_parameters.transpose();
    Some(SMatrix::from_fn(|row, column| covariance[(row, column)]))
}

/// How a place of the picture moves with a turn about each axis, with a pixel of focal length and one of distortion.
fn modes(lens: &Lens, pixel: &Point2<f64>, movement: &Movement, reach_px: f64) -> Matrix2x5<f64> {
    let numbers = lens.intrinsics();
    let out = pixel - Point2::new(numbers.cx, numbers.cy);
    let cubic = out * (out.norm_squared() / reach_px.powi(3));
    let turn = &movement.by_turn;
    Matrix2x5::from_fn(|row, column| match column {
        3 => out[row] / [numbers.fx, numbers.fy][row],
        4 => cubic[row],
        _ => turn[(row, column)],
    })
}

/// Pixels from the lens's centre to the farthest corner of the picture.
fn reach_px(lens: &Lens, resolution: [u32; 2]) -> f64 {
    let numbers = lens.intrinsics();
    let [width, height] = resolution.map(|pixels| f64::from(pixels) - 1.0);
    let farthest = |centre: f64, last: f64| centre.abs().max((last - centre).abs());
    farthest(numbers.cx, width).hypot(farthest(numbers.cy, height))
}
