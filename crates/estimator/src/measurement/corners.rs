//! Residuals of the corners of one tag in one image, whitened and weighted, and how they change with the object's pose
//! ([`sextant_adjustment::residuals::corners`]).

use nalgebra::{Matrix2, Matrix3, Matrix6, Point2, Point3, Vector2, Vector3};
use sextant_geometry::{Lens, Pose, tag_corners_in_tag};

use crate::kinematics::chain::ChainLink;
use crate::kinematics::configuration::Configuration;
use crate::measurement::ray::Ray;
use crate::measurement::rolling_shutter::{LinkMotion, RollingShutter};
use crate::measurement::view_equations::{NoiseSource, ViewEquations};
use crate::measurement::whitening::{PoseRows, Rows, Whitening, product};
use sextant_adjustment::residuals::corners::{BodyInCamera, KERNEL, ProjectedCorner, UNSEEN};
use sextant_adjustment::shutter::{LaterPose, Slopes};
use sextant_site_model::{LensSigma, ObjectTag, PoseSigma, TagCorners, TagId};
use sextant_site_report::ClockOffset;

/// Twice the cost of a view that can't be seen from the pose: as bad as a view can be.
pub(crate) fn unseen_cost() -> f64 {
    4.0 * KERNEL.rho(UNSEEN)
}

/// A camera whose pose is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CalibratedCamera {
    pub lens: Lens,
    pub camera_from_world: Pose,
    /// Standard deviation of its pose; `None` where it is exact.
    pub sigma: Option<PoseSigma>,
    /// Standard deviation of its lens; `None` where it is exact.
    pub lens_sigma: Option<LensSigma>,
    /// Pixels from the lens's centre to the image's corners, as the lens's sigma means them.
    pub reach_px: f64,
    /// Its centre in the world.
    pub centre: Vector3<f64>,
    /// How its shutter rolls; `None` where all rows have one time.
    pub shutter: Option<RollingShutter>,
    /// Its rotation as a matrix.
    turn: Matrix3<f64>,
}

impl CalibratedCamera {
    pub fn new(lens: Lens, world_from_camera: &Pose, sigma: Option<PoseSigma>) -> Self {
        let camera_from_world = world_from_camera.inverse();
        let turn = camera_from_world.rotation.to_rotation_matrix().into_inner();
        Self {
            lens,
            camera_from_world,
            sigma,
            centre: world_from_camera.translation.vector,
            lens_sigma: None,
            reach_px: lens.intrinsics().cx.hypot(lens.intrinsics().cy),
            shutter: None,
            turn,
        }
    }

    /// How a pixel moves with a pixel more of focal length (first column) and of distortion (second), as [`LensSigma`]
    /// has them.
    pub fn displaced_by_lens(&self, pixel: &Point2<f64>) -> Matrix2<f64> {
        let numbers = self.lens.intrinsics();
        let out = pixel - Point2::new(numbers.cx, numbers.cy);
        let relative = out.norm_squared() / self.reach_px.powi(2);
        Matrix2::from_columns(&[
            Vector2::new(out.x / numbers.fx, out.y / numbers.fy),
            out * (relative / self.reach_px),
        ])
    }

    /// Derivatives of a point's pixel by a pixel more of focal length (first column) and by the first coefficient of
    /// the distortion, a radial one where the lens has none.
    pub fn by_lens(&self, in_camera: &Point3<f64>) -> Option<Matrix2<f64>> {
        let by_lens = self.lens.parameter_jacobian(in_camera)?;
        let by_distortion = if self.lens.distortion().is_empty() {
            let normalised = in_camera.coords.xy() / in_camera.z;
            let focal = Vector2::new(self.lens.intrinsics().fx, self.lens.intrinsics().fy);
            focal.component_mul(&normalised) * normalised.norm_squared()
        } else {
            by_lens.column(4).into_owned()
        };
        let by_focal = by_lens.column(0) + by_lens.column(1);
        Some(Matrix2::from_columns(&[by_focal, by_distortion]))
    }

    /// The ray through the middle of a view.
    pub fn ray_to(&self, view: &TagView) -> Option<Ray> {
        let corners = view.corners_in_image.iter();
        let middle = corners.fold(Vector2::zeros(), |sum, corner| sum + corner.coords) / 4.0;
        let in_camera = self.lens.unproject(&Point2::from(middle)).ok()?;
        Some(Ray {
            origin: self.centre,
            direction: self.turn.transpose() * in_camera,
        })
    }

    /// Ratio of the corners' residuals to their distances from the tag's centre, root mean squares.
    pub fn relative_residual(
        &self,
        view: &TagView,
        distortion_share: f64,
        at: &Configuration,
    ) -> Option<f64> {
        let link = view.moving(at);
        let centre = Point3::from(view.object_from_tag.translation.vector);
        let (mut residual, mut distance) = (0.0, 0.0);
        for index in 0..4 {
            let passage = view.passage(index, &link);
            let world_from_link = passage.map_or(link.pose, |passage| passage.pose);
            let project = |point: &Point3<f64>| {
                let in_world = world_from_link * point;
                self.lens.project(&(self.camera_from_world * in_world))
            };
            let expected = project(&view.corners_in_object[index])?;
            residual += (expected - view.corner(index, distortion_share)).norm_squared();
            distance += (expected - project(&centre)?).norm_squared();
        }
        Some((residual / distance).sqrt())
    }
}

/// Whitened residuals of a view's corners and their derivatives.
pub(crate) struct Linearisation {
    /// By the pose, with the residuals.
    pub rows: PoseRows,
    by_twist: Option<Rows<6>>,
    /// The robust weight of each corner.
    pub weights: [f64; 4],
    /// By how much twice the cost exceeds the weighted square.
    relief: f64,
    /// Sum of squared residuals in px², no weight.
    square_px: f64,
}

/// One tag in one image. "Object" is its link, where the object has links.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TagView {
    pub tag: TagId,
    /// The link that it is on; `None` where the object is rigid.
    pub chain_link: Option<ChainLink>,
    /// Edge of the black square in metres.
    pub size_m: f64,
    pub object_from_tag: Pose,
    /// Of the tag's model, in the object's frame.
    pub corners_in_object: [Point3<f64>; 4],
    /// As seen, in pixels.
    pub corners_in_image: [Point2<f64>; 4],
    /// The same with the covariance that the detector gives.
    pub seen: TagCorners,
    /// Distortion bias of the corners where a homography finds them, px; `None` where the lens bends no lines.
    pub distortion_bias: Option<[Vector2<f64>; 4]>,
    /// Inverse of the reported covariance of each corner, 1/px².
    pub information: [Matrix2<f64>; 4],
    /// Makes the residuals of the corners independent.
    pub whitening: Whitening,
    /// Whether the detector reports correlations between corners.
    pub is_joint: bool,
    pub noise_source: NoiseSource,
    /// Standard deviation of the pose of the tag on its object; `None` where it is exact.
    pub tag_sigma: Option<PoseSigma>,
    /// Time of the row of each corner after the capture time, s, where the shutter rolls.
    pub after_s: Option<[f64; 4]>,
}

impl TagView {
    /// Takes another place and size of the tag.
    pub fn set_model(&mut self, tag: &ObjectTag) {
        let Some(object_from_tag) = tag.object_from_tag else {
            return;
        };
        self.object_from_tag = object_from_tag;
        self.set_size(tag.size_m);
    }

    /// Takes another size of the tag, m.
    pub fn set_size(&mut self, size_m: f64) {
        self.size_m = size_m;
        let in_tag = tag_corners_in_tag(size_m);
        self.corners_in_object = in_tag.map(|corner| self.object_from_tag * corner);
    }

    /// A corner as seen, less a share of the distortion bias, px.
    #[inline(always)]
    pub fn corner(&self, corner: usize, distortion_share: f64) -> Point2<f64> {
        let seen = self.corners_in_image[corner];
        self.distortion_bias.map_or(seen, |distortion_bias| {
            seen - distortion_bias[corner] * distortion_share
        })
    }

    /// Where the tag's link is, or the object where it is rigid.
    pub fn world_from_link(&self, at: &Configuration) -> Pose {
        match &self.chain_link {
            None => at.pose,
            Some(chain_link) => chain_link.world_from_link(at),
        }
    }

    /// The configuration in which the tag's link is at a pose; root and joints are those of another.
    pub fn anchored(&self, world_from_link: &Pose, like: &Configuration) -> Configuration {
        let Some(chain_link) = &self.chain_link else {
            return Configuration {
                pose: *world_from_link,
                ..*like
            };
        };
        let anchored = Configuration {
            root: chain_link.link,
            pose: *world_from_link,
            ..chain_link.chain.rooted(like, chain_link.link)
        };
        chain_link.chain.rooted(&anchored, like.root)
    }

    /// Where the link has gone by the time of a corner's row.
    fn passage(&self, corner: usize, link: &LinkMotion) -> Option<LaterPose> {
        let (twist, after_s) = (link.twist?, self.after_s?);
        Some(LaterPose::new(&link.pose, &twist, after_s[corner]))
    }

    /// Pose of the tag's link, and its twist where the shutter rolls.
    pub fn moving(&self, at: &Configuration) -> LinkMotion {
        let twist = match (&self.after_s, &self.chain_link) {
            (None, _) => None,
            (Some(_), None) => Some(at.rates.twist),
            (Some(_), Some(chain_link)) => Some(chain_link.twist(at)),
        };
        LinkMotion {
            pose: self.world_from_link(at),
            twist,
        }
    }
}

/// A view with its camera and the weight of that camera's corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightedView<'a> {
    pub camera_index: usize,
    pub camera: &'a CalibratedCamera,
    pub view: &'a TagView,
    /// Factor on the variance of its corners as reported or configured.
    pub noise: f64,
    /// Share of the distortion bias in its corners.
    pub distortion_share: f64,
    /// Prior of the camera's clock offset; `None` where the clock is right.
    pub clock: Option<ClockOffset>,
}

/// Errors of the corners of a view besides those that its detector reports.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewNoise {
    /// Factor on the variance of the corners as reported or configured.
    pub factor: f64,
    /// Share of the distortion bias in the corners.
    pub distortion_share: f64,
}

impl<'a> WeightedView<'a> {
    pub fn new(
        camera_index: usize,
        camera: &'a CalibratedCamera,
        view: &'a TagView,
        noise: ViewNoise,
        clock: Option<ClockOffset>,
    ) -> Self {
        Self {
            camera_index,
            camera,
            view,
            noise: noise.factor,
            distortion_share: noise.distortion_share,
            clock,
        }
    }
}

impl WeightedView<'_> {
    /// The same with so many times the variance of its corners.
    pub fn noisier(self, factor: f64) -> Self {
        Self {
            noise: self.noise * factor,
            ..self
        }
    }

    /// Cost and normal equations about `world_from_object`; `None` where the tag would lie behind the camera or outside
    /// of the lens's field. A tag seen from its back has residuals all the same, which lead round to its face.
    pub fn normal(&self, link: &LinkMotion) -> Option<ViewEquations> {
        let linear = self.linearised(link)?;
        let by_twist = linear.by_twist.as_ref();
        let mut normal = ViewEquations::from_rows(&linear.rows, by_twist, self.view.noise_source);
        normal.chi2 += linear.relief;
        normal.square_px = linear.square_px;
        Some(normal)
    }

    /// Sum of the squared distances of the corners from where they are expected, px².
    pub fn square_px(&self, link: &LinkMotion) -> Option<f64> {
        Some(self.linearised(link)?.square_px)
    }

    /// The whitened residuals and their derivatives.
    #[inline(always)]
    pub(crate) fn linearised(&self, link: &LinkMotion) -> Option<Linearisation> {
        let mut linear = Linearisation {
            rows: [[0.0; 8]; 8],
            by_twist: None,
            weights: [0.0; 4],
            relief: 0.0,
            square_px: 0.0,
        };
        if link.twist.is_some() && self.view.after_s.is_some() {
            self.fill_passing(link, &mut linear)?;
        } else {
            let body = self.body(&link.pose);
            for corner in 0..4 {
                let seen = self.projected(corner, &body)?;
                self.fill(corner, &seen, &seen.by_pose(), &mut linear);
            }
        }
        linear.rows = self.view.whitening.whitened(&linear.rows, self.noise);
        Some(linear)
    }

    /// The rows of a corner, not whitened.
    #[inline(always)]
    fn fill(
        &self,
        corner: usize,
        seen: &ProjectedCorner,
        slopes: &Slopes,
        linear: &mut Linearisation,
    ) {
        let residual = seen.pixel - self.view.corner(corner, self.distortion_share);
        let (weight, relief) = self.weight(corner, &residual);
        let root = weight.sqrt();
        for axis in 0..2 {
            let (row, slopes) = (&mut linear.rows[2 * corner + axis], &slopes[axis]);
            (0..6).for_each(|n| row[n] = slopes[n] * root);
            row[6] = residual[axis] * root;
        }
        linear.weights[corner] = weight;
        linear.relief += relief;
        linear.square_px += residual.norm_squared();
    }

    /// Score of the share of the distortion bias: twice the slope of the log-likelihood and the information. With
    /// whitened bias d, residuals e, Jacobian J and covariance P of the fit the covariance of the residuals is I - J P
    /// J', and a larger share by a adds -a (I - J P J') d to them.
    pub fn distortion_score(
        &self,
        link: &LinkMotion,
        covariance: &Matrix6<f64>,
    ) -> Option<[f64; 2]> {
        let distortion_bias = self.view.distortion_bias?;
        let linear = self.linearised(link)?;
        let mut rows: Rows<1> = [[0.0]; 8];
        for (row, of_row) in rows.iter_mut().enumerate() {
            *of_row = [distortion_bias[row / 2][row % 2] * linear.weights[row / 2].sqrt()];
        }
        let rows = self.view.whitening.whitened(&rows, self.noise);
        let with = product(&linear.rows, &rows);
        let by_pose = with.fixed_rows::<6>(0);
        let fitted = by_pose.dot(&(covariance * by_pose));
        let square: f64 = rows.iter().map(|[one]| one * one).sum();
        Some([-with[6], (square - fitted).max(0.0)])
    }

    /// The same of all corners where each has its own time, and whitened rows by the twist.
    fn fill_passing(&self, link: &LinkMotion, linear: &mut Linearisation) -> Option<()> {
        let mut by_twist = [[0.0; 6]; 8];
        for corner in 0..4 {
            let passage = self.view.passage(corner, link)?;
            let seen = self.projected(corner, &self.body(&passage.pose))?;
            let (by_pose, by_rates) = passage.before(&seen.by_pose());
            self.fill(corner, &seen, &by_pose, linear);
            let root = linear.weights[corner].sqrt();
            for axis in 0..2 {
                by_twist[2 * corner + axis] = by_rates[axis].map(|slope| slope * root);
            }
        }
        linear.by_twist = Some(self.view.whitening.whitened(&by_twist, self.noise));
        Some(())
    }

    /// A corner at the time of its row: the body, where the corner is projected to, and its residual, px. `None` where
    /// it cannot be seen.
    pub(crate) fn at_corner(
        &self,
        corner: usize,
        link: &LinkMotion,
    ) -> Option<(BodyInCamera<'_>, ProjectedCorner, Vector2<f64>)> {
        let passage = self.view.passage(corner, link);
        let body = self.body(&passage.map_or(link.pose, |passage| passage.pose));
        let seen = self.projected(corner, &body)?;
        let residual = seen.pixel - self.view.corner(corner, self.distortion_share);
        Some((body, seen, residual))
    }

    #[inline(always)]
    fn body(&self, world_from_link: &Pose) -> BodyInCamera<'_> {
        let camera = self.camera;
        BodyInCamera::new(
            &camera.lens,
            &camera.camera_from_world,
            &camera.turn,
            world_from_link,
        )
    }

    /// The robust weight of a corner, and by how much twice the cost exceeds the weighted square.
    #[inline(always)]
    fn weight(&self, corner: usize, residual: &Vector2<f64>) -> (f64, f64) {
        let d2 = residual.dot(&(self.view.information[corner] * residual)) / self.noise;
        let weight = KERNEL.weight(d2);
        (weight, KERNEL.rho(d2) - weight * d2)
    }

    #[inline(always)]
    fn projected(&self, corner: usize, body: &BodyInCamera<'_>) -> Option<ProjectedCorner> {
        body.project(&self.view.corners_in_object[corner].coords)
    }

    /// Whether the tag's printed side is turned towards the camera.
    pub fn faces(&self, world_from_object: &Pose) -> bool {
        let tag = &self.view.object_from_tag;
        let outwards = world_from_object.rotation * (tag.rotation * Vector3::z());
        let place = world_from_object * Point3::from(tag.translation.vector);
        outwards.dot(&(place.coords - self.camera.centre)) < 0.0
    }

    /// Where the tag would be.
    pub fn camera_from_tag(&self, world_from_object: &Pose) -> Pose {
        self.camera.camera_from_world * world_from_object * self.view.object_from_tag
    }
}

impl WeightedView<'_> {
    /// Twice the robust cost of the view at a configuration.
    pub fn chi2(&self, at: &Configuration) -> f64 {
        let normal = self.normal(&self.view.moving(at));
        normal.map_or_else(unseen_cost, |normal| normal.chi2)
    }
}
