//! Residuals of the corners of one tag in one image, and how they change with the object's pose.
//!
//! r = pi(camera_from_world (R q + t)) - u; with t += dt and R = exp(dr) R:
//! dr/d(dt, dr) = J_pi R_cw [I | -[R q]x].

use nalgebra::{
    Matrix2, Matrix2x3, Matrix3, Matrix6, Point2, Point3, SMatrix, Vector2, Vector3, Vector6,
};
use sextant_geometry::{Lens, Pose};

use super::chain::{Configuration, Limb};
use super::edges::{EdgeModes, Matrix8, NoiseFactors, Vector8};
use crate::{ClockOffset, PoseSigma, TagId};

type Matrix2x6 = SMatrix<f64, 2, 6>;

/// A camera whose pose is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PosedCamera {
    pub lens: Lens,
    pub camera_from_world: Pose,
    /// How well its pose is known, where that is stated.
    pub sigma: Option<PoseSigma>,
    /// Its centre in the world.
    pub centre: Vector3<f64>,
    /// Its rotation as a matrix.
    turn: Matrix3<f64>,
}

impl PosedCamera {
    pub fn new(lens: Lens, world_from_camera: &Pose, sigma: Option<PoseSigma>) -> Self {
        let camera_from_world = world_from_camera.inverse();
        let turn = camera_from_world.rotation.to_rotation_matrix().into_inner();
        Self {
            lens,
            camera_from_world,
            sigma,
            centre: world_from_camera.translation.vector,
            turn,
        }
    }
}

impl PosedCamera {
    /// How a view's residuals go with the corners' distances from the tag's centre: sums over the corners of residual times
    /// distance, distance squared and residual squared, px². Seen minus expected is minus (ratio - 1) times the distance.
    pub fn size_of(&self, view: &View, at: &Configuration) -> Option<[f64; 3]> {
        let camera_from_object = self.camera_from_world * view.world_from_link(at);
        let expected = |point: &Point3<f64>| self.lens.project(&(camera_from_object * point));
        let centre = expected(&Point3::from(view.object_from_tag.translation.vector))?;
        let mut sums = [0.0; 3];
        for (corner, seen) in view.corners_in_object.iter().zip(&view.corners_in_image) {
            let expected = expected(corner)?;
            let (residual, distance) = (expected - seen, expected - centre);
            sums[0] += residual.dot(&distance);
            sums[1] += distance.norm_squared();
            sums[2] += residual.norm_squared();
        }
        Some(sums)
    }
}

/// A corner and its derivative by (dt, dr), in pixels.
struct Projected {
    pixel: Point2<f64>,
    jacobian: Matrix2x6,
}

/// Who states the noise of a view's corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoiseSource {
    Detector,
    /// It is the usual one.
    Nobody,
}

impl NoiseSource {
    /// Degrees of freedom of the noise's scale from view to view. What blur, light and contrast do to it a detector knows but
    /// for a rest; where nobody states anything, it is a factor of three.
    fn freedom(self) -> f64 {
        match self {
            Self::Detector => 12.0,
            Self::Nobody => 5.0,
        }
    }
}

/// One tag in one image. "Object" is its link, where the object has links.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct View {
    pub tag: TagId,
    /// The link that it is on; `None` where the object is rigid.
    pub limb: Option<Limb>,
    /// Edge of the black square in metres.
    pub size_m: f64,
    pub object_from_tag: Pose,
    /// Of the tag's model, in the object's frame.
    pub corners_in_object: [Point3<f64>; 4],
    /// As seen, in pixels.
    pub corners_in_image: [Point2<f64>; 4],
    /// Inverse of each corner's covariance as stated, 1/px².
    pub information: [Matrix2<f64>; 4],
    /// How the corners' errors hang together.
    pub edges: EdgeModes,
    pub noise_source: NoiseSource,
}

impl View {
    /// Where the tag's link is, or the object where it is rigid.
    pub fn world_from_link(&self, at: &Configuration) -> Pose {
        match &self.limb {
            None => at.pose,
            Some(limb) => limb.world_from_link(at),
        }
    }

    /// The configuration in which the tag's link is at a pose; root and joints are those of another.
    pub fn anchored(&self, world_from_link: &Pose, like: &Configuration) -> Configuration {
        let Some(limb) = &self.limb else {
            return Configuration::rigid(world_from_link);
        };
        let anchored = Configuration {
            root: limb.link,
            pose: *world_from_link,
            joints: like.joints,
        };
        limb.chain.rooted(&anchored, like.root)
    }
}

/// A view with its camera and the weight of that camera's corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub camera_index: usize,
    pub camera: &'a PosedCamera,
    pub view: &'a View,
    /// Of its noise against what is stated.
    pub noise: NoiseFactors,
    /// Factor on the information of single corners.
    weight: f64,
    /// Makes the residuals of the four corners independent with unit variance.
    whitener: Matrix8,
    /// What is known of the camera's clock, where it is not taken at its word.
    pub clock: Option<ClockOffset>,
}

/// The quadratic model of the robust cost of some views about a pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Normal {
    /// J^T W J over (dt, dr).
    pub information: Matrix6<f64>,
    /// The part of it that the directions of the edges give.
    pub of_turns: Matrix6<f64>,
    /// J^T W r.
    pub gradient: Vector6<f64>,
    /// Twice the robust cost: chi-square where nothing is an outlier.
    pub chi2: f64,
    /// Sum of squared residuals in px², no weight.
    pub square_px: f64,
    /// Sums of squared whitened residuals of the edges' places and directions, each view's by its weight.
    pub scale: [f64; 2],
}

impl Normal {
    /// Of whitened residuals, first those of the edges' places, then of their directions.
    fn of(residuals: &Vector8, jacobian: &SMatrix<f64, 8, 6>) -> Self {
        let (shifts, turns) = (jacobian.fixed_rows::<4>(0), jacobian.fixed_rows::<4>(4));
        let of_turns = turns.transpose() * turns;
        let square = |first: usize| residuals.fixed_rows::<4>(first).norm_squared();
        Self {
            information: shifts.transpose() * shifts + of_turns,
            of_turns,
            gradient: jacobian.transpose() * residuals,
            chi2: residuals.norm_squared(),
            square_px: 0.0,
            scale: [square(0), square(4)],
        }
    }

    /// Where the noise differs from view to view: with a variance of inverse gamma distribution about the usual one the
    /// residuals of a view are distributed as Student's t (Lange, Little, Taylor 1989, eq. 2), and a view off by much counts
    /// little.
    fn of_unknown_scale(self, source: NoiseSource) -> Self {
        let freedom = source.freedom();
        let weight = (freedom + 8.0) / (freedom + self.chi2);
        // Where the scale is all but unknown, Fisher's information on the place is smaller by this (ibid., eq. 10); a
        // detector's is meant as it is stated, and the weights only guard against its tails.
        let certain = match source {
            NoiseSource::Detector => 1.0,
            NoiseSource::Nobody => (freedom + 8.0) / (freedom + 10.0),
        };
        Self {
            information: self.information * (weight * certain),
            of_turns: self.of_turns * (weight * certain),
            gradient: self.gradient * weight,
            chi2: (freedom + 8.0) * (1.0 + self.chi2 / freedom).ln(),
            square_px: self.square_px,
            scale: self.scale.map(|scale| scale * weight),
        }
    }
}

/// Squared Mahalanobis length beyond which a corner loses weight: 98.9 % of the corners of a Gaussian lie within.
pub(crate) const ROBUST_LIMIT: f64 = 9.0;

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

impl<'a> Sight<'a> {
    pub fn new(
        camera_index: usize,
        camera: &'a PosedCamera,
        view: &'a View,
        noise: NoiseFactors,
        clock: Option<ClockOffset>,
    ) -> Self {
        let weight = noise.of_corner().recip();
        let whitener = view.edges.whitener(noise);
        Self {
            camera_index,
            camera,
            view,
            noise,
            weight,
            whitener,
            clock,
        }
    }
}

impl Sight<'_> {
    /// Cost and normal equations about `world_from_object`; `None` where the tag would lie behind the camera or outside
    /// of the lens's field. A tag seen from its back has residuals all the same, which lead round to its face.
    pub fn normal(&self, world_from_object: &Pose) -> Option<Normal> {
        let turn = world_from_object.rotation.to_rotation_matrix().into_inner();
        let place =
            self.camera.camera_from_world * Point3::from(world_from_object.translation.vector);
        let mut residuals = Vector8::zeros();
        let mut jacobian = SMatrix::<f64, 8, 6>::zeros();
        let (mut relief, mut square_px) = (0.0, 0.0);
        for corner in 0..4 {
            let arm = turn * self.view.corners_in_object[corner].coords;
            let seen = self.projected(&place, &arm)?;
            let residual = seen.pixel - self.view.corners_in_image[corner];
            let (weight, corner_relief) = self.weight(corner, &residual);
            residuals
                .fixed_rows_mut::<2>(2 * corner)
                .copy_from(&(residual * weight.sqrt()));
            jacobian
                .fixed_rows_mut::<2>(2 * corner)
                .copy_from(&(seen.jacobian * weight.sqrt()));
            relief += corner_relief;
            square_px += residual.norm_squared();
        }
        let (residuals, jacobian) = (self.whitener * residuals, self.whitener * jacobian);
        let normal = Normal::of(&residuals, &jacobian);
        let normal = normal.of_unknown_scale(self.view.noise_source);
        Some(Normal {
            chi2: normal.chi2 + relief,
            square_px,
            ..normal
        })
    }

    /// The robust weight of a corner, and by how much twice the cost exceeds the weighted square.
    fn weight(&self, corner: usize, residual: &Vector2<f64>) -> (f64, f64) {
        let d2 = residual.dot(&(self.view.information[corner] * residual)) * self.weight;
        let (weight, cost) = robust(d2);
        (weight, cost - weight * d2)
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
}
