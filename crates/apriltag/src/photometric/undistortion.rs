//! Local undistortion around a tag, so that its edges are straight.
//!
//! Undistorted points are pixels of a pinhole camera, with an affine map that makes them equal to the pixels of the
//! lens around the centre of the tag.

use super::state::Row;
use crate::quad::{Point, Quad, middle};
use nalgebra::{Matrix2, Point2, Vector2};
use sextant_geometry::Lens;

pub(super) struct Undistortion {
    lens: Lens,
    /// Centre of the tag: pixel and normalised point.
    middle: Vector2<f64>,
    normalised: Vector2<f64>,
    normalised_by_pixel: Matrix2<f64>,
    pixel_by_normalised: Matrix2<f64>,
}

impl Undistortion {
    /// The undistortion around a quad; `None` outside the field of the lens.
    pub(super) fn at(lens: &Lens, quad: &Quad) -> Option<Self> {
        let [x, y] = middle(quad).map(f64::from);
        let (normalised, normalised_by_pixel) =
            lens.undistort_with_jacobian(&Point2::new(x, y)).ok()?;
        Some(Self {
            lens: *lens,
            middle: Vector2::new(x, y),
            normalised: normalised.coords,
            normalised_by_pixel,
            pixel_by_normalised: normalised_by_pixel.try_inverse()?,
        })
    }

    /// The undistorted point of a pixel; the pixel itself outside the field of the lens.
    pub(super) fn place(&self, [x, y]: Point) -> Point {
        let pixel = Point2::new(f64::from(x), f64::from(y));
        let Ok(normalised) = self.lens.undistort(&pixel) else {
            return [x, y];
        };
        let away = self.pixel_by_normalised * (normalised.coords - self.normalised);
        (self.middle + away).cast().into()
    }

    /// Pixel of an undistorted point.
    pub(super) fn pixel(&self, [x, y]: Point) -> Option<Point> {
        let away = Vector2::new(f64::from(x), f64::from(y)) - self.middle;
        let normalised = self.normalised + self.normalised_by_pixel * away;
        let pixel = self.lens.distort(&Point2::from(normalised))?;
        Some(pixel.coords.cast().into())
    }

    /// Pixel of an undistorted point, with its derivatives given those of the point.
    pub(super) fn shown(&self, [x, y]: Point, [of_x, of_y]: [Row; 2]) -> Option<(Point, [Row; 2])> {
        const STEP_PX: f32 = 0.5;
        let (left, right) = (self.pixel([x - STEP_PX, y])?, self.pixel([x + STEP_PX, y])?);
        let (above, below) = (self.pixel([x, y - STEP_PX])?, self.pixel([x, y + STEP_PX])?);
        let shown = [0, 1].map(|axis| {
            let (by_x, by_y) = (right[axis] - left[axis], below[axis] - above[axis]);
            std::array::from_fn(|n| by_x * of_x[n] + by_y * of_y[n])
        });
        Some((self.pixel([x, y])?, shown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Intrinsics;

    #[test]
    fn straightened_places_are_the_lenss_and_lead_back_to_their_pixels() {
        let intrinsics = Intrinsics {
            fx: 500.0,
            fy: 510.0,
            cx: 320.0,
            cy: 240.0,
        };
        let lens = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.001, -0.002, 0.0]).unwrap();
        let quad = [[400.0, 60.0], [560.0, 80.0], [550.0, 230.0], [410.0, 220.0]];
        let undistortion = Undistortion::at(&lens, &quad).unwrap();
        for pixel in [
            [480.0, 150.0],
            [400.0, 60.0],
            [560.0, 80.0],
            [455.5, 210.25],
        ] {
            let exact = undistortion.place(pixel);
            let back = undistortion.pixel(exact).unwrap();
            assert!(
                (back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 1e-3,
                "{pixel:?}"
            );
        }
    }

    #[test]
    fn a_quad_outside_the_lenss_field_has_none() {
        let intrinsics = Intrinsics {
            fx: 200.0,
            fy: 200.0,
            cx: 320.0,
            cy: 240.0,
        };
        let lens = Lens::brown_conrady(intrinsics, [-0.3, 0.0, 0.0, 0.0, 0.0]).unwrap();
        let quad = [
            [5000.0, 60.0],
            [5060.0, 80.0],
            [5050.0, 130.0],
            [5010.0, 120.0],
        ];
        assert!(Undistortion::at(&lens, &quad).is_none());
    }
}
