//! The reprojection error of one tag in one image and its derivatives.
//!
//! Every derivative uses the motion of the corner in the object's frame: a small twist `(v, w)` of the object's
//! frame moves the point `X` by `v + w x X`. Steps of the object's pose and of a tag are such twists, and a camera's
//! is its adjoint, so one 8x6 Jacobian serves all of them (`J = J_pi R [I | -hat X]`).
//!
//! With a rolling shutter the object has moved between the capture time, which is that of the middle row, and the time
//! of a corner's row, by a constant twist: `X' = exp(x tau) X` (L. Oth, P. Furgale, L. Kneip, R. Siegwart, Rolling
//! shutter camera calibration, CVPR 2013, with a constant twist over an image). Steps of the object then act on `X'`,
//! those of a tag on `X` before.

use super::state::{Bundle, BundleImage, TagObservation};
use nalgebra::{Matrix2, Matrix2x3, Point2, SMatrix, SVector, Vector2, Vector6};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::{Lens, Pose, se3, so3, tag_corners_in_tag};

/// Chi-square of a corner that cannot be projected, which makes it an outlier.
const UNSEEN: f64 = 1e8;

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

/// Whitened, weighted error and derivatives of a tag.
pub(super) struct TagEquations {
    pub error: SVector<f64, 8>,
    /// With respect to a twist of the object's frame at the capture time.
    pub by_twist: SMatrix<f64, 8, 6>,
    /// With respect to a twist of the object's frame that moves the tag.
    pub by_tag: SMatrix<f64, 8, 6>,
    /// Seconds from the capture time to the time of each corner's row; repeated for x and y.
    pub after_s: SVector<f64, 8>,
    /// With respect to the logarithm of the tag's size.
    pub by_size: SVector<f64, 8>,
    /// With respect to the lens parameters; only filled where these are free.
    pub by_lens: SMatrix<f64, 8, MAX_PARAMETERS>,
    /// Robust cost, in units of the noise squared.
    pub rho: f64,
}

/// Whether to compute derivatives with respect to the lens.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum LensColumns {
    TagSpec,
    Unwanted,
}

/// Projection of the object into one image.
pub(super) struct View {
    pub lens: Lens,
    /// At the capture time.
    pub camera_from_object: Pose,
    pub shutter: Shutter,
    pub columns: LensColumns,
}

/// Motion of the object from the capture time to the time of a row: `exp(twist * seconds)`, in the object's own axes.
#[derive(Clone, Copy)]
pub(super) struct Shutter {
    pub twist: Vector6<f64>,
    line_delay_s: f64,
    middle_row: f64,
}

impl Shutter {
    fn of(bundle: &Bundle, image: &BundleImage) -> Self {
        let camera = &bundle.cameras[image.camera];
        Self {
            twist: bundle.instants[image.instant].twist,
            line_delay_s: bundle.motion.map_or(0.0, |_| camera.line_delay_s),
            middle_row: camera.middle_row,
        }
    }

    /// Rows from the middle one to a corner: the detected one, which misses the true one by a part of a row.
    pub(super) fn rows(&self, corner: &Point2<f64>) -> f64 {
        corner.y - self.middle_row
    }

    fn after_s(&self, corner: &Point2<f64>) -> f64 {
        self.line_delay_s * self.rows(corner)
    }

    fn motion(&self, after_s: f64) -> Pose {
        if after_s == 0.0 {
            Pose::identity()
        } else {
            se3::exp(&(self.twist * after_s))
        }
    }
}

impl View {
    pub(super) fn of(bundle: &Bundle, image: &BundleImage, columns: LensColumns) -> Self {
        let camera = &bundle.cameras[image.camera];
        let world_from_object = object_at(bundle, image);
        Self {
            lens: camera.lens,
            camera_from_object: camera.world_from_camera.inverse() * world_from_object,
            shutter: Shutter::of(bundle, image),
            columns,
        }
    }
}

/// Seconds from the instant to the image, by the world's clock.
fn delay(bundle: &Bundle, image: &BundleImage) -> f64 {
    let offset_s = bundle.cameras[image.camera].clock_offset_s;
    image.seconds_after_instant + offset_s + image.stamp_error_s
}

/// Pose of the object at the capture time of the image.
pub(super) fn object_at(bundle: &Bundle, image: &BundleImage) -> Pose {
    let instant = &bundle.instants[image.instant];
    match bundle.motion {
        None => instant.world_from_object,
        Some(_) => {
            let delay = delay(bundle, image);
            instant.world_from_object * se3::exp(&(instant.twist * delay))
        }
    }
}

/// Effect of a step of the instant on the object's frame at the time of the image, `delay` seconds later on the twist
/// `x`: `[Ad(exp(-x delay)) | delay J_r(x delay)]`; the right Jacobian is the left one of the inverse motion.
pub(super) fn lever<const D: usize>(bundle: &Bundle, image: &BundleImage) -> SMatrix<f64, 6, D> {
    if bundle.motion.is_none() {
        return SMatrix::from_fn(|row, column| if row == column { 1.0 } else { 0.0 });
    }
    let delay = delay(bundle, image);
    let back = bundle.instants[image.instant].twist * -delay;
    let (of_pose, of_twist) = (
        se3::adjoint(&se3::exp(&back)),
        se3::left_jacobian(&back) * delay,
    );
    SMatrix::from_fn(|row, column| match column.checked_sub(6) {
        None => of_pose[(row, column)],
        Some(column) => of_twist[(row, column)],
    })
}

/// Robust equations of a tag. A corner that cannot be projected counts as an outlier without derivatives.
pub(super) fn linearise(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
    kernel: &Kernel,
) -> TagEquations {
    let mut equations = TagEquations {
        error: SVector::zeros(),
        by_twist: SMatrix::zeros(),
        by_tag: SMatrix::zeros(),
        after_s: SVector::zeros(),
        by_size: SVector::zeros(),
        by_lens: SMatrix::zeros(),
        rho: 0.0,
    };
    let rotation = view.camera_from_object.rotation.to_rotation_matrix();
    for (corner, in_tag) in tag_corners_in_tag(size_m).iter().enumerate() {
        let on_tag = object_from_tag * in_tag;
        let after_s = view.shutter.after_s(&seen.corners[corner]);
        let motion = view.shutter.motion(after_s);
        let in_object = motion * on_tag;
        let in_camera = view.camera_from_object * in_object;
        let Some((pixel, by_point)) = view.lens.project_with_jacobian(&in_camera) else {
            equations.rho += kernel.rho(UNSEEN);
            continue;
        };
        let whitening: &Matrix2<f64> = &seen.whitening[corner];
        let error = whitening * (pixel - seen.corners[corner]);
        let square = error.norm_squared();
        equations.rho += kernel.rho(square);
        let weight = kernel.weight(square).sqrt();
        let weighted = whitening * weight;
        let by_object: Matrix2x3<f64> = weighted * (by_point * rotation.matrix());
        let by_turn: Matrix2x3<f64> = -by_object * so3::hat(&in_object.coords);
        let by_object_before: Matrix2x3<f64> =
            by_object * motion.rotation.to_rotation_matrix().matrix();
        let by_turn_before: Matrix2x3<f64> = -by_object_before * so3::hat(&on_tag.coords);
        let row = 2 * corner;
        equations.after_s.fixed_rows_mut::<2>(row).fill(after_s);
        equations
            .error
            .fixed_rows_mut::<2>(row)
            .copy_from(&(error * weight));
        let from_centre = object_from_tag.rotation * in_tag.coords;
        equations
            .by_size
            .fixed_rows_mut::<2>(row)
            .copy_from(&(by_object_before * from_centre));
        let mut rows = equations.by_twist.fixed_view_mut::<2, 6>(row, 0);
        rows.fixed_columns_mut::<3>(0).copy_from(&by_object);
        rows.fixed_columns_mut::<3>(3).copy_from(&by_turn);
        let mut rows = equations.by_tag.fixed_view_mut::<2, 6>(row, 0);
        rows.fixed_columns_mut::<3>(0).copy_from(&by_object_before);
        rows.fixed_columns_mut::<3>(3).copy_from(&by_turn_before);
        if view.columns == LensColumns::TagSpec
            && let Some(by_lens) = view.lens.parameter_jacobian(&in_camera)
        {
            equations
                .by_lens
                .fixed_view_mut::<2, MAX_PARAMETERS>(row, 0)
                .copy_from(&(weighted * by_lens));
        }
    }
    equations
}

/// Robust cost of a tag alone.
pub(super) fn rho(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
    kernel: &Kernel,
) -> f64 {
    let errors = errors_px(view, object_from_tag, size_m, seen);
    let squares = errors.iter().zip(&seen.whitening);
    squares
        .map(|(error, whitening)| {
            let square = error.map_or(UNSEEN, |error| (whitening * error).norm_squared());
            kernel.rho(square)
        })
        .sum()
}

/// Model less seen corners, pixels.
fn errors_px(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
) -> [Option<Vector2<f64>>; 4] {
    let mut errors = [None; 4];
    let corners = tag_corners_in_tag(size_m);
    for ((error, in_tag), at) in errors.iter_mut().zip(corners).zip(&seen.corners) {
        let motion = view.shutter.motion(view.shutter.after_s(at));
        let in_camera = view.camera_from_object * (motion * (object_from_tag * in_tag));
        *error = view.lens.project(&in_camera).map(|pixel| pixel - at);
    }
    errors
}

impl Bundle {
    /// Residuals of every tag of every image, in order.
    pub fn residuals(&self) -> impl Iterator<Item = TagResidual> {
        self.images
            .iter()
            .enumerate()
            .flat_map(move |(index, image)| {
                let view = View::of(self, image, LensColumns::Unwanted);
                let seen = image.tags.iter().enumerate();
                seen.map(move |(at, seen)| self.residual(&view, (index, at), seen))
            })
    }

    fn residual(
        &self,
        view: &View,
        (image, at): (usize, usize),
        seen: &TagObservation,
    ) -> TagResidual {
        let tag = &self.tags[seen.tag];
        let mut corners_px = errors_px(view, &tag.object_from_tag, tag.size_m, seen);
        let squares = corners_px.iter().zip(&seen.whitening);
        let chi_square = squares
            .map(|(error, whitening)| error.map_or(UNSEEN, |e| (whitening * e).norm_squared()))
            .sum();
        for (error, whitening) in corners_px.iter_mut().zip(&seen.whitening) {
            *error = error.filter(|_| *whitening != Matrix2::zeros());
        }
        TagResidual {
            image,
            seen: at,
            corners_px,
            chi_square,
        }
    }
}
