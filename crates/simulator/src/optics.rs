//! The whole lens of a camera: its model and what the model lacks.

use crate::scenario::{LensResidual, SceneCamera};
use nalgebra::{Point2, Point3, Vector2};
use sextant_geometry::{Lens, LensModel};
use std::f64::consts::TAU;

/// Rounds in which the inverse of the residual settles; each brings it nearer by its slope, a tenth at most.
const ROUNDS: usize = 12;

/// From points to pixels and back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Optics {
    lens: Lens,
    residual: LensResidual,
    middle: Point2<f64>,
    half_diagonal: f64,
}

impl Optics {
    pub fn from_camera(camera: &SceneCamera) -> Self {
        let half = Vector2::from(camera.resolution.map(|n| (f64::from(n) - 1.0) / 2.0));
        Self {
            lens: camera.lens,
            residual: camera.lens_residual,
            middle: half.into(),
            half_diagonal: half.norm(),
        }
    }

    /// True where straight edges stay straight.
    pub fn is_straight(&self) -> bool {
        self.lens.model() == LensModel::Pinhole && self.is_ideal()
    }

    /// Pixel of a point in the camera's frame.
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Option<Point2<f64>> {
        Some(self.displaced(self.lens.project(point_in_camera)?))
    }

    /// Pixel of a normalised point (x/z, y/z).
    pub fn distort(&self, normalised: &Point2<f64>) -> Option<Point2<f64>> {
        Some(self.displaced(self.lens.distort(normalised)?))
    }

    /// Normalised point of a pixel.
    pub fn undistort(&self, pixel: &Point2<f64>) -> Option<Point2<f64>> {
        let mut ideal = *pixel;
        if !self.is_ideal() {
            for _ in 0..ROUNDS {
                ideal = pixel - self.residual_at(&ideal);
            }
        }
        self.lens.undistort(&ideal).ok()
    }

    fn is_ideal(&self) -> bool {
        self.residual == LensResidual::default()
    }

    fn displaced(&self, pixel: Point2<f64>) -> Point2<f64> {
        if self.is_ideal() {
            return pixel;
        }
        pixel + self.residual_at(&pixel)
    }

    fn residual_at(&self, pixel: &Point2<f64>) -> Vector2<f64> {
        let from_middle = pixel - self.middle;
        let distance = from_middle.norm();
        let share = distance / self.half_diagonal;
        let outwards = from_middle / distance.max(f64::MIN_POSITIVE);
        let wave = self.residual.radial_px * libm::sin(2.0 * TAU * share);
        outwards * wave + Vector2::from(self.residual.prism_px) * (share * share)
    }
}

impl SceneCamera {
    /// Pixel of a point in the camera's frame, through the lens model and [`LensResidual`].
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Option<Point2<f64>> {
        Optics::from_camera(self).project(point_in_camera)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    #[test]
    fn the_inverse_of_a_lens_with_residuals_gives_the_pixel_back() {
        let mut camera = Scenario::demo(1, 1, 1).cameras.remove(0);
        camera.lens_residual = LensResidual {
            radial_px: 3.0,
            prism_px: [5.0, -5.0],
        };
        let optics = Optics::from_camera(&camera);
        let mut largest: f64 = 0.0;
        for y in (0..480).step_by(20) {
            for x in (0..640).step_by(20) {
                let pixel = Point2::new(f64::from(x), f64::from(y));
                let normalised = optics.undistort(&pixel).unwrap();
                let again = optics.distort(&normalised).unwrap();
                assert!((again - pixel).norm() < 1e-6, "{pixel}: {again}");
                let model = camera.lens.distort(&normalised).unwrap();
                largest = largest.max((model - pixel).norm());
            }
        }
        assert!(largest > 6.0, "{largest}");
    }
}
