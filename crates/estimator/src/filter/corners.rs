//! Residuals of the corners of one tag in one image, and how they change with the object's pose.
//!
//! r = pi(camera_from_world (R q + t)) - u; with t += dt and R = exp(dr) R:
//! dr/d(dt, dr) = J_pi R_cw [I | -[R q]x].

use nalgebra::{
    Matrix2, Matrix2x3, Matrix3, Matrix6, Point2, Point3, SMatrix, Vector2, Vector3, Vector6,
};
use sextant_geometry::{Lens, Pose};

use crate::{ClockOffset, TagId};

type Matrix2x6 = SMatrix<f64, 2, 6>;

/// A camera whose pose is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PosedCamera {
    pub lens: Lens,
    pub camera_from_world: Pose,
    /// Its rotation as a matrix.
    turn: Matrix3<f64>,
}

impl PosedCamera {
    pub fn new(lens: Lens, world_from_camera: &Pose) -> Self {
        let camera_from_world = world_from_camera.inverse();
        let turn = camera_from_world.rotation.to_rotation_matrix().into_inner();
        Self {
            lens,
            camera_from_world,
            turn,
        }
    }
}

/// A corner and its derivative by (dt, dr), in pixels.
struct Projected {
    pixel: Point2<f64>,
    jacobian: Matrix2x6,
}

/// One tag in one image.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct View {
    pub tag: TagId,
    /// Edge of the black square in metres.
    pub size_m: f64,
    pub object_from_tag: Pose,
    /// Of the tag's model, in the object's frame.
    pub corners_in_object: [Point3<f64>; 4],
    /// As seen, in pixels.
    pub corners_in_image: [Point2<f64>; 4],
    /// Inverse of each corner's covariance, 1/px².
    pub information: [Matrix2<f64>; 4],
}

/// A view with its camera and the weight of that camera's corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub camera_index: usize,
    pub camera: &'a PosedCamera,
    pub view: &'a View,
    /// Factor on the information of the corners: 1 / (noise factor)².
    pub weight: f64,
    /// What is known of the camera's clock, where it is not taken at its word.
    pub clock: Option<ClockOffset>,
}

/// The quadratic model of the robust cost of some views about a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Normal {
    /// J^T W J over (dt, dr).
    pub information: Matrix6<f64>,
    /// J^T W r.
    pub gradient: Vector6<f64>,
    /// Twice the robust cost: chi-square where nothing is an outlier.
    pub chi2: f64,
    /// Sum of squared residuals in px², no weight.
    pub square_px: f64,
    /// Sum of the corners' squared Mahalanobis lengths, each cut off at [`SCALE_LIMIT`]: what tells the noise apart from
    /// outliers.
    pub scale: f64,
}

impl Normal {
    pub fn zero() -> Self {
        Self {
            information: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            chi2: 0.0,
            square_px: 0.0,
            scale: 0.0,
        }
    }

    pub fn add(&mut self, other: &Self) {
        self.information += other.information;
        self.gradient += other.gradient;
        self.chi2 += other.chi2;
        self.square_px += other.square_px;
        self.scale += other.scale;
    }
}

/// Squared Mahalanobis length beyond which a corner loses weight: 98.9 % of the corners of a Gaussian lie within.
pub(crate) const ROBUST_LIMIT: f64 = 9.0;

/// Squared Mahalanobis length at which a corner's share in the estimate of the noise is cut off: 86 % of the corners of a
/// Gaussian lie within.
pub(crate) const SCALE_LIMIT: f64 = 4.0;

/// Weight and twice the cost of a corner at the squared Mahalanobis length `d2`: quadratic within the limit, logarithmic
/// beyond (Gaussian core with Cauchy tails), so that one wrong corner pulls ever less.
fn robust(d2: f64) -> (f64, f64) {
    if d2 <= ROBUST_LIMIT {
        (1.0, d2)
    } else {
        (
            ROBUST_LIMIT / d2,
            ROBUST_LIMIT * (1.0 + (d2 / ROBUST_LIMIT).ln()),
        )
    }
}

impl Sight<'_> {
    /// Cost and normal equations about `world_from_object`; `None` where the tag would lie behind the camera or outside
    /// of the lens's field. A tag seen from its back has residuals all the same, which lead round to its face.
    pub fn normal(&self, world_from_object: &Pose) -> Option<Normal> {
        let turn = world_from_object.rotation.to_rotation_matrix().into_inner();
        let place =
            self.camera.camera_from_world * Point3::from(world_from_object.translation.vector);
        let mut sum = Normal::zero();
        for corner in 0..4 {
            let arm = turn * self.view.corners_in_object[corner].coords;
            let seen = self.projected(&place, &arm)?;
            let residual = seen.pixel - self.view.corners_in_image[corner];
            self.accumulate(&mut sum, corner, &residual, &seen.jacobian);
        }
        Some(sum)
    }

    /// The corner at `arm` (world axes) from the object's origin, which lies at `place` in the camera's frame.
    fn projected(&self, place: &Point3<f64>, arm: &Vector3<f64>) -> Option<Projected> {
        let in_camera = place + self.camera.turn * arm;
        let (pixel, by_point) = self.camera.lens.project_with_jacobian(&in_camera)?;
        let by_place: Matrix2x3<f64> = by_point * self.camera.turn;
        let (x, y) = (by_place.row(0).transpose(), by_place.row(1).transpose());
        // v [arm]x = (v x arm) as a row; the attitude's part is -J [arm]x.
        let (turn_x, turn_y) = (arm.cross(&x), arm.cross(&y));
        let jacobian = Matrix2x6::new(
            x.x, x.y, x.z, turn_x.x, turn_x.y, turn_x.z, //
            y.x, y.y, y.z, turn_y.x, turn_y.y, turn_y.z,
        );
        Some(Projected { pixel, jacobian })
    }

    /// Whether the tag's printed side is turned towards the camera.
    pub fn faces(&self, world_from_object: &Pose) -> bool {
        let camera_from_tag = self.camera_from_tag(world_from_object);
        let outwards = camera_from_tag.rotation * Vector3::z();
        outwards.dot(&camera_from_tag.translation.vector) < 0.0
    }

    /// Where the tag would be.
    pub fn camera_from_tag(&self, world_from_object: &Pose) -> Pose {
        self.camera.camera_from_world * world_from_object * self.view.object_from_tag
    }

    fn accumulate(
        &self,
        sum: &mut Normal,
        corner: usize,
        residual: &Vector2<f64>,
        jacobian: &Matrix2x6,
    ) {
        let information = self.view.information[corner] * self.weight;
        let d2 = residual.dot(&(information * residual));
        let (weight, cost) = robust(d2);
        let weighted = jacobian.transpose() * (information * weight);
        sum.information += weighted * jacobian;
        sum.gradient += weighted * residual;
        sum.chi2 += cost;
        sum.square_px += residual.norm_squared();
        sum.scale += d2.min(SCALE_LIMIT);
    }
}
