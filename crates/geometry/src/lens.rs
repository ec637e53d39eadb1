//! Lenses: points in the camera frame to pixels and back.
//!
//! Camera frame: x right, y down, z forward, metres. Pixels: (0, 0) is the centre of the top left pixel. Between them
//! lie *normalised* points, (x/z, y/z), and *distorted* points, where the ideal lens would see what the real one sees.
//! A `Lens` is valid by construction: its numbers are finite and it knows its *valid field*, the disc of normalised
//! points within which its distortion can be inverted. Outside of it, and behind the camera, nothing is projected.

mod brown_conrady;
mod conversions;
mod distortion;
mod kannala_brandt;
mod parameters;
mod valid_field;

pub use parameters::{
    Intrinsics, LensError, LensModel, LensParameters, MAX_PARAMETERS, ParameterJacobian,
    UnknownLensModel,
};

use distortion::Distortion;
use nalgebra::{Matrix2, Matrix2x3, Point2, Point3, RowVector3, SMatrix, Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// A camera's lens: pinhole, Brown-Conrady or Kannala-Brandt. Serialises as the `lens` table of `rig.toml`.
///
/// Written with its model's name as a tag, so that only self-describing formats (TOML, JSON) can read it; for others
/// convert from and to [`LensParameters`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "LensParameters", into = "LensParameters")]
pub struct Lens {
    intrinsics: Intrinsics,
    distortion: Distortion,
}

/// Why a pixel has no ray.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum UnprojectError {
    /// The pixel is NaN or infinite.
    #[error("pixel ({x}, {y}) is not finite")]
    NotFinite {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
    },
    /// No point inside the lens's valid field is seen at this pixel.
    #[error(
        "pixel ({x:.1}, {y:.1}) is outside the valid field of the lens, which ends {:.1} degrees off its axis",
        half_angle.to_degrees()
    )]
    OutsideField {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
        /// Half opening angle of the valid field, radians.
        half_angle: f64,
    },
}

impl Lens {
    /// A lens without distortion.
    pub fn pinhole(intrinsics: Intrinsics) -> Result<Self, LensError> {
        Self::checked(intrinsics, Distortion::None)
    }

    /// D. Brown, Close-range camera calibration, 1971, as OpenCV writes it: `[k1, k2, p1, p2, k3]`.
    pub fn brown_conrady(intrinsics: Intrinsics, distortion: [f64; 5]) -> Result<Self, LensError> {
        Self::checked(intrinsics, Distortion::brown_conrady(distortion)?)
    }

    /// J. Kannala, S. Brandt, A generic camera model, PAMI 2006, as OpenCV's fisheye writes it: `[k1, k2, k3, k4]`.
    pub fn kannala_brandt(intrinsics: Intrinsics, distortion: [f64; 4]) -> Result<Self, LensError> {
        Self::checked(intrinsics, Distortion::kannala_brandt(distortion)?)
    }

    fn checked(intrinsics: Intrinsics, distortion: Distortion) -> Result<Self, LensError> {
        intrinsics.check()?;
        parameters::check_field(distortion.max_radius())?;
        Ok(Self {
            intrinsics,
            distortion,
        })
    }

    /// Which of the models this is.
    pub fn model(&self) -> LensModel {
        self.distortion.model()
    }

    /// Focal lengths and principal point, pixels.
    pub fn intrinsics(&self) -> Intrinsics {
        self.intrinsics
    }

    /// The distortion's coefficients in the order of `rig.toml`; empty for a pinhole.
    pub fn distortion(&self) -> &[f64] {
        self.distortion.coefficients()
    }

    /// Radius of the valid field in normalised coordinates, `tan` of [`Lens::half_angle`].
    pub fn max_radius(&self) -> f64 {
        self.distortion.max_radius()
    }

    /// Half opening angle of the valid field, radians, below pi/2.
    pub fn half_angle(&self) -> f64 {
        self.max_radius().atan()
    }

    /// The pixel at which the lens shows a point of the camera frame. `None` behind the camera or outside the field.
    pub fn project(&self, point_in_camera: &Point3<f64>) -> Option<Point2<f64>> {
        self.distort(&normalise(point_in_camera)?)
    }

    /// As [`Lens::project`], with the derivative of the pixel with respect to the point, pixels per metre.
    pub fn project_with_jacobian(
        &self,
        point_in_camera: &Point3<f64>,
    ) -> Option<(Point2<f64>, Matrix2x3<f64>)> {
        let normalised = normalise(point_in_camera)?;
        let (distorted, distorted_by_normalised) =
            self.distortion.distort_with_jacobian(&normalised.coords)?;
        let per_depth = 1.0 / point_in_camera.z;
        // d normalised / d point = [1, 0, -x; 0, 1, -y] / z.
        let row = |row: usize, focal: f64| {
            let by = distorted_by_normalised.row(row) * (focal * per_depth);
            RowVector3::new(by.x, by.y, -(by.x * normalised.x + by.y * normalised.y))
        };
        let rows = [row(0, self.intrinsics.fx), row(1, self.intrinsics.fy)];
        Some((
            self.intrinsics.pixel(&distorted),
            Matrix2x3::from_rows(&rows),
        ))
    }

    /// The derivative of the projected pixel with respect to [`Lens::parameters`], at a point of the camera frame.
    pub fn parameter_jacobian(&self, point_in_camera: &Point3<f64>) -> Option<ParameterJacobian> {
        let normalised = normalise(point_in_camera)?;
        let distorted = self.distortion.distort(&normalised.coords)?;
        let mut pixel_by_parameters = self.distortion.coefficient_jacobian(&normalised.coords);
        pixel_by_parameters.row_mut(0).scale_mut(self.intrinsics.fx);
        pixel_by_parameters.row_mut(1).scale_mut(self.intrinsics.fy);
        let pixel_by_intrinsics =
            SMatrix::<f64, 2, 4>::new(distorted.x, 0.0, 1.0, 0.0, 0.0, distorted.y, 0.0, 1.0);
        pixel_by_parameters
            .fixed_view_mut::<2, 4>(0, 0)
            .copy_from(&pixel_by_intrinsics);
        Some(pixel_by_parameters)
    }

    /// The pixel of a normalised point (x/z, y/z); `None` outside the valid field.
    pub fn distort(&self, normalised: &Point2<f64>) -> Option<Point2<f64>> {
        let distorted = self.distortion.distort(&normalised.coords)?;
        Some(self.intrinsics.pixel(&distorted))
    }

    /// The normalised point (x/z, y/z) seen at a pixel: the inverse of [`Lens::distort`].
    pub fn undistort(&self, pixel: &Point2<f64>) -> Result<Point2<f64>, UnprojectError> {
        let (x, y) = (pixel.x, pixel.y);
        if !(x.is_finite() && y.is_finite()) {
            return Err(UnprojectError::NotFinite { x, y });
        }
        let normalised = self.distortion.undistort(&self.intrinsics.distorted(pixel));
        let outside = UnprojectError::OutsideField {
            x,
            y,
            half_angle: self.half_angle(),
        };
        normalised.map(Point2::from).ok_or(outside)
    }

    /// As [`Lens::undistort`], with the derivative of the normalised point with respect to the pixel.
    pub fn undistort_with_jacobian(
        &self,
        pixel: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), UnprojectError> {
        let normalised = self.undistort(pixel)?;
        let outside = UnprojectError::OutsideField {
            x: pixel.x,
            y: pixel.y,
            half_angle: self.half_angle(),
        };
        let (_, distorted_by_normalised) = self
            .distortion
            .distort_with_jacobian(&normalised.coords)
            .ok_or(outside)?;
        let inverse = (self.intrinsics.scale() * distorted_by_normalised)
            .try_inverse()
            .ok_or(outside)?;
        Ok((normalised, inverse))
    }

    /// The ray seen at a pixel: a unit vector of the camera frame, z > 0.
    pub fn unproject(&self, pixel: &Point2<f64>) -> Result<Vector3<f64>, UnprojectError> {
        let normalised = self.undistort(pixel)?;
        Ok(Vector3::new(normalised.x, normalised.y, 1.0).normalize())
    }
}

/// Nothing nearer to the plane through the lens than a nanometre is seen; the bound keeps every derivative finite.
const MIN_DEPTH_M: f64 = 1e-9;

/// (x/z, y/z) of a point before the camera.
fn normalise(point_in_camera: &Point3<f64>) -> Option<Point2<f64>> {
    let z = point_in_camera.z;
    // Written so that NaN is refused; a ratio that overflows is refused by the field's bound.
    (z >= MIN_DEPTH_M).then(|| Point2::new(point_in_camera.x / z, point_in_camera.y / z))
}

impl Intrinsics {
    fn pixel(&self, distorted: &Vector2<f64>) -> Point2<f64> {
        Point2::new(
            self.fx * distorted.x + self.cx,
            self.fy * distorted.y + self.cy,
        )
    }

    fn distorted(&self, pixel: &Point2<f64>) -> Vector2<f64> {
        Vector2::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy)
    }

    fn scale(&self) -> Matrix2<f64> {
        Matrix2::new(self.fx, 0.0, 0.0, self.fy)
    }
}
