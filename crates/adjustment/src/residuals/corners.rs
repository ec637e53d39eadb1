//! The corner of a tag in an image: where it is projected to, and how it moves with everything that it depends on.
//!
//! A corner `q` of a tag (in the tag's axes, from its centre) lies in the world at `X = R s (t_tag + R_tag q) + t`,
//! with `(t, R)` the pose of its body at the time of the corner's row and `s` the scale of the body. Each parameter
//! moves that point, or the point as the camera sees it, by a simple vector, so that one 2x3 matrix, the derivative `J`
//! of the pixel by a displacement of the point in world axes, gives all derivatives (steps are those of FRAMES.md: `t
//! += dt`, `R = exp(dr) R`):
//!
//! | parameter | displacement of the point |
//! |---|---|
//! | pose of the body | `dt + dr x a`, `a = X - t` |
//! | pose of the camera, at `c` | `-dt - dr x (X - c)` |
//! | pose of the tag | `R s (dt + dr x R_tag q)` |
//! | logarithm of the tag's size | `R s R_tag q` |
//! | logarithm of the body's scale | `a` |
//! | time of the row | `v + w x a` |

use crate::layout::{CameraColumns, Layout, TagColumns};
use crate::shutter::{LaterPose, Slopes};
use crate::values::{BodyId, Bundle, BundleImage, BundleTag, TagObservation};
use nalgebra::{
    Const, Dyn, Matrix2, Matrix2x3, Matrix3, OMatrix, Point2, Point3, SVector, Vector2, Vector3,
    Vector6,
};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::{Lens, Pose, tag_corners_in_tag};

/// Robust kernel of corners, whether they are tracked or calibrated with: one wrong corner pulls ever less.
pub const KERNEL: Kernel = Kernel::CauchyTails { width: 3.0 };
/// Squared Mahalanobis length of a corner that cannot be projected: 250 through [`KERNEL`], more than any other.
pub const UNSEEN: f64 = 4e12;

/// Image of a corner of a tag, with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectedCorner {
    /// Where the lens puts it, px.
    pub pixel: Point2<f64>,
    /// Derivative by a displacement of the point, world axes, px/m.
    pub by_point: Matrix2x3<f64>,
    /// From the body's origin to the point, world axes, m.
    pub arm: Vector3<f64>,
}

impl ProjectedCorner {
    /// Derivatives by a step `(dt, dr)` of the body's pose.
    #[inline(always)]
    pub fn by_pose(&self) -> Slopes {
        [0, 1].map(|axis| {
            let by_place = self.by_point.row(axis).transpose();
            // J (dr x a) = (a x J) dr.
            let by_turn = self.arm.cross(&by_place);
            six(&by_place, &by_turn)
        })
    }
}

/// Derivatives of a corner's pixel, of x and of y, by steps of what it depends on (table above).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CornerJacobian {
    /// By the pose of the body at the time of the corner's row.
    pub body: Slopes,
    /// By the pose of the camera.
    pub camera: Slopes,
    /// By the pose of the tag on the body.
    pub tag: Slopes,
    /// By the logarithm of the tag's size.
    pub size: [f64; 2],
    /// By the logarithm of the body's scale.
    pub scale: [f64; 2],
}

impl CornerJacobian {
    /// By the time of the row, with the twist of the body.
    pub fn by_time(&self, twist: &Vector6<f64>) -> [f64; 2] {
        self.body.map(|slopes| Vector6::from(slopes).dot(twist))
    }
}

fn six(first: &Vector3<f64>, second: &Vector3<f64>) -> [f64; 6] {
    [first.x, first.y, first.z, second.x, second.y, second.z]
}

/// A body before a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyInCamera<'a> {
    lens: &'a Lens,
    camera_from_world: &'a Matrix3<f64>,
    world_from_body: Matrix3<f64>,
    origin_in_camera: Point3<f64>,
}

impl<'a> BodyInCamera<'a> {
    /// `camera_rotation` is the rotation of `camera_from_world`.
    #[inline(always)]
    pub fn new(
        lens: &'a Lens,
        camera_from_world: &Pose,
        camera_rotation: &'a Matrix3<f64>,
        world_from_body: &Pose,
    ) -> Self {
        Self {
            lens,
            camera_from_world: camera_rotation,
            world_from_body: world_from_body.rotation.to_rotation_matrix().into_inner(),
            origin_in_camera: camera_from_world * Point3::from(world_from_body.translation.vector),
        }
    }

    /// A point of the body in the camera's frame, m.
    pub fn in_camera(&self, in_body: &Vector3<f64>) -> Point3<f64> {
        self.origin_in_camera + self.camera_from_world * (self.world_from_body * in_body)
    }

    /// Derivatives of a projected corner that lies `from_centre` from its tag's centre, m, axes of the body; `scale` is
    /// that of the body.
    pub fn jacobian(
        &self,
        seen: &ProjectedCorner,
        from_centre: &Vector3<f64>,
        scale: f64,
    ) -> CornerJacobian {
        let from_camera = self.camera_from_world.tr_mul(&self.origin_in_camera.coords) + seen.arm;
        let mut by = CornerJacobian {
            body: seen.by_pose(),
            ..CornerJacobian::default()
        };
        for axis in 0..2 {
            let by_point = seen.by_point.row(axis).transpose();
            let by_place = self.world_from_body.tr_mul(&by_point) * scale;
            by.camera[axis] = six(&-by_point, &by_point.cross(&from_camera));
            by.tag[axis] = six(&by_place, &from_centre.cross(&by_place));
            by.size[axis] = by_place.dot(from_centre);
            by.scale[axis] = by_point.dot(&seen.arm);
        }
        by
    }

    /// Projects a point of the body; `None` where the lens cannot.
    #[inline(always)]
    pub fn project(&self, in_body: &Vector3<f64>) -> Option<ProjectedCorner> {
        let arm = self.world_from_body * in_body;
        let in_camera = self.origin_in_camera + self.camera_from_world * arm;
        let (pixel, by_point) = self.lens.project_with_jacobian(&in_camera)?;
        Some(ProjectedCorner {
            pixel,
            by_point: by_point * self.camera_from_world,
            arm,
        })
    }
}

/// The error of one tag in one image at the solution.
#[derive(Clone, Debug, PartialEq)]
pub struct TagResidual {
    /// Index into [`Bundle::images`].
    pub image: usize,
    /// Index into the image's tags.
    pub seen: usize,
    /// Projected minus detected corner, pixels; `None` if the corner cannot be projected or has zero weight.
    pub corners_px: [Option<Vector2<f64>>; 4],
    /// Sum over its corners of the squared errors in units of the detector's noise; 8 is expected.
    pub chi_square: f64,
}

impl TagResidual {
    /// Root mean square over the corners of the distance between model and seen corner, pixels.
    pub fn rms_px(&self) -> f64 {
        let seen = || self.corners_px.iter().flatten();
        let sum: f64 = seen().map(Vector2::norm_squared).sum();
        (sum / seen().count().max(1) as f64).sqrt()
    }
}

/// Whitened, weighted rows of a tag by the columns of its image: those of the camera, of the tag, the scale of its
/// body, the `D` of the instant, and one for the error of the stamp.
pub(crate) type TagRows = OMatrix<f64, Const<8>, Dyn>;

/// Where the columns of [`TagRows`] begin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowLayout<'a> {
    camera: &'a CameraColumns,
    tag: &'a TagColumns,
    has_scale: bool,
}

impl<'a> RowLayout<'a> {
    pub(crate) fn new(layout: &'a Layout, camera: usize, tag: usize, scale: Option<usize>) -> Self {
        Self {
            camera: &layout.cameras[camera],
            tag: &layout.tags[tag],
            has_scale: scale.is_some_and(|scale| layout.scales[scale].is_some()),
        }
    }

    fn tag_start(&self) -> usize {
        self.camera.width()
    }

    fn scale_start(&self) -> usize {
        self.tag_start() + self.tag.span().1
    }

    /// First column of the instant.
    pub(crate) fn instant_start(&self) -> usize {
        self.scale_start() + usize::from(self.has_scale)
    }

    /// The kept columns: where each block begins in the rows and in the system, and its width.
    pub(crate) fn kept(&self, scale_column: Option<usize>) -> [KeptBlock; 3] {
        let (tag_column, tag_width) = self.tag.span();
        [
            KeptBlock {
                row: 0,
                column: self.camera.start(),
                width: self.camera.width(),
            },
            KeptBlock {
                row: self.tag_start(),
                column: tag_column,
                width: tag_width,
            },
            KeptBlock {
                row: self.scale_start(),
                column: scale_column.unwrap_or(0),
                width: usize::from(self.has_scale),
            },
        ]
    }
}

/// Neighbouring kept columns, in the rows of a tag and in the whole system.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptBlock {
    pub row: usize,
    pub column: usize,
    pub width: usize,
}

/// One image of a bundle: its camera, and its body at the capture time.
pub(crate) struct ImageModel<'a> {
    bundle: &'a Bundle,
    image: &'a BundleImage,
    camera_from_world: Pose,
    camera_rotation: Matrix3<f64>,
    world_from_body: Pose,
    twist: Vector6<f64>,
    /// From the instant to the capture time, s.
    delay_s: f64,
    line_delay_s: f64,
}

impl<'a> ImageModel<'a> {
    pub(crate) fn new(bundle: &'a Bundle, image: &'a BundleImage) -> Self {
        let camera = &bundle.cameras[image.camera];
        let instant = &bundle.instants[image.instant];
        let camera_from_world = camera.world_from_camera.inverse();
        let moves = bundle.motion.is_some() && matches!(instant.body, BodyId::Moving(_));
        let delay_s = image.seconds_after_instant - camera.clock_offset_s - image.stamp_error_s;
        Self {
            bundle,
            image,
            camera_rotation: camera_from_world.rotation.to_rotation_matrix().into_inner(),
            camera_from_world,
            world_from_body: instant.world_from_object,
            twist: instant.twist,
            delay_s: if moves { delay_s } else { 0.0 },
            line_delay_s: if moves { camera.line_delay_s } else { 0.0 },
        }
    }

    fn lens(&self) -> &Lens {
        &self.bundle.cameras[self.image.camera].lens
    }

    /// Rows from the middle one to a corner: the detected one, which misses the true one by a part of a row.
    fn rows_after_middle(&self, corner: &Point2<f64>) -> f64 {
        corner.y - self.bundle.cameras[self.image.camera].middle_row
    }

    /// The body at the time of a corner's row.
    fn later(&self, corner: &Point2<f64>) -> LaterPose {
        let after_s = self.delay_s + self.line_delay_s * self.rows_after_middle(corner);
        LaterPose::new(&self.world_from_body, &self.twist, after_s)
    }

    fn body(&self, world_from_body: &Pose) -> BodyInCamera<'_> {
        BodyInCamera::new(
            self.lens(),
            &self.camera_from_world,
            &self.camera_rotation,
            world_from_body,
        )
    }

    /// Model less seen corners, pixels.
    pub(crate) fn errors_px(&self, seen: &TagObservation) -> [Option<Vector2<f64>>; 4] {
        let tag = &self.bundle.tags[seen.tag];
        let scale = self.bundle.scale(tag);
        let mut errors = [None; 4];
        let corners = tag_corners_in_tag(tag.size_m);
        for ((error, in_tag), at) in errors.iter_mut().zip(corners).zip(&seen.corners) {
            let later = self.later(at);
            let in_body = (tag.object_from_tag * in_tag).coords * scale;
            let in_camera = self.camera_from_world * (later.pose * Point3::from(in_body));
            *error = self.lens().project(&in_camera).map(|pixel| pixel - at);
        }
        errors
    }

    /// Robust cost of a tag.
    pub(crate) fn rho(&self, seen: &TagObservation, kernel: &Kernel) -> f64 {
        let errors = self.errors_px(seen);
        let squares = errors.iter().zip(&seen.whitening);
        squares
            .map(|(error, whitening)| {
                let square = error.map_or(UNSEEN, |error| (whitening * error).norm_squared());
                kernel.rho(square)
            })
            .sum()
    }

    /// The rows of a tag at the present values, and its robust cost.
    pub(crate) fn linearise<const D: usize>(
        &self,
        seen: &TagObservation,
        columns: &RowLayout<'_>,
        kernel: &Kernel,
        rows: &mut TagRows,
    ) -> (SVector<f64, 8>, f64) {
        let tag = &self.bundle.tags[seen.tag];
        rows.fill(0.0);
        let (mut error, mut rho) = (SVector::<f64, 8>::zeros(), 0.0);
        for (corner, in_tag) in tag_corners_in_tag(tag.size_m).into_iter().enumerate() {
            let from_centre = tag.object_from_tag.rotation * in_tag.coords;
            let placed = PlacedCorner::new(self, tag, from_centre, &seen.corners[corner]);
            let Some(placed) = placed else {
                rho += kernel.rho(UNSEEN);
                continue;
            };
            let whitening = &seen.whitening[corner];
            let residual = whitening * (placed.projected.pixel - seen.corners[corner]);
            let square = residual.norm_squared();
            let weight = kernel.weight(square).sqrt();
            error
                .fixed_rows_mut::<2>(2 * corner)
                .copy_from(&(residual * weight));
            rho += kernel.rho(square);
            placed.fill::<D>(&(whitening * weight), columns, corner, rows);
        }
        (error, rho)
    }
}

/// A corner at the time of its row.
struct PlacedCorner<'a> {
    model: &'a ImageModel<'a>,
    body: BodyInCamera<'a>,
    later: LaterPose,
    projected: ProjectedCorner,
    in_camera: Point3<f64>,
    /// From the tag's centre to the corner, axes of the body.
    from_centre: Vector3<f64>,
    scale: f64,
    rows_after_middle: f64,
}

impl<'a> PlacedCorner<'a> {
    /// `None` where the lens cannot project it.
    fn new(
        model: &'a ImageModel<'a>,
        tag: &BundleTag,
        from_centre: Vector3<f64>,
        at: &Point2<f64>,
    ) -> Option<Self> {
        let scale = model.bundle.scale(tag);
        let later = model.later(at);
        let body = model.body(&later.pose);
        let in_body = (tag.object_from_tag.translation.vector + from_centre) * scale;
        Some(Self {
            projected: body.project(&in_body)?,
            in_camera: body.in_camera(&in_body),
            body,
            from_centre,
            model,
            later,
            scale,
            rows_after_middle: model.rows_after_middle(at),
        })
    }

    /// Fills the two rows of the corner; `whitening` includes the robust weight.
    fn fill<const D: usize>(
        &self,
        whitening: &Matrix2<f64>,
        columns: &RowLayout<'_>,
        corner: usize,
        rows: &mut TagRows,
    ) {
        let whitened = ProjectedCorner {
            by_point: whitening * self.projected.by_point,
            ..self.projected
        };
        let by = self.body.jacobian(&whitened, &self.from_centre, self.scale);
        let by_time = by.by_time(&self.model.twist);
        let by_lens = match columns.camera.lens_parameters.is_empty() {
            true => None,
            false => self.model.lens().parameter_jacobian(&self.in_camera),
        };
        let by_lens = by_lens.map(|by_lens| whitening * by_lens);
        let (pose, twist) = self.later.before(&by.body);
        for axis in 0..2 {
            let mut row = Row {
                rows,
                row: 2 * corner + axis,
                at: 0,
            };
            let camera = columns.camera;
            row.put_if(camera.pose, &by.camera[axis]);
            row.put_if(camera.clock, &[-by_time[axis]]);
            row.put_if(camera.line_delay, &[by_time[axis] * self.rows_after_middle]);
            for &parameter in &camera.lens_parameters {
                row.put(&[by_lens.map_or(0.0, |by_lens| by_lens[(axis, parameter)])]);
            }
            row.put_if(columns.tag.pose, &by.tag[axis]);
            row.put_if(columns.tag.size, &[by.size[axis]]);
            row.put_if(columns.has_scale.then_some(0), &[by.scale[axis]]);
            row.put(&pose[axis]);
            row.put_if((D > 6).then_some(0), &twist[axis]);
            row.put(&[-by_time[axis]]);
        }
    }
}

/// A row that is filled from its first column on.
struct Row<'a> {
    rows: &'a mut TagRows,
    row: usize,
    at: usize,
}

impl Row<'_> {
    fn put(&mut self, values: &[f64]) {
        for value in values {
            self.rows[(self.row, self.at)] = *value;
            self.at += 1;
        }
    }

    /// Where the parameter has a column.
    fn put_if(&mut self, column: Option<usize>, values: &[f64]) {
        if column.is_some() {
            self.put(values);
        }
    }
}

impl Bundle {
    /// Residuals of every tag of every image, in order.
    pub fn residuals(&self) -> impl Iterator<Item = TagResidual> {
        self.images
            .iter()
            .enumerate()
            .flat_map(move |(index, image)| {
                let model = ImageModel::new(self, image);
                let seen = image.tags.iter().enumerate();
                seen.map(move |(at, seen)| {
                    let mut corners_px = model.errors_px(seen);
                    let squares = corners_px.iter().zip(&seen.whitening);
                    let chi_square = squares
                        .map(|(error, whitening)| {
                            error.map_or(UNSEEN, |e| (whitening * e).norm_squared())
                        })
                        .sum();
                    for (error, whitening) in corners_px.iter_mut().zip(&seen.whitening) {
                        *error = error.filter(|_| *whitening != Matrix2::zeros());
                    }
                    TagResidual {
                        image: index,
                        seen: at,
                        corners_px,
                        chi_square,
                    }
                })
            })
    }
}
